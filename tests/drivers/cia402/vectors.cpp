// Holds rows of golden vectors against the CANopen codec, both ways; see vectors.hpp.
#include "tests/drivers/cia402/vectors.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <optional>

#include "drivers/cia402/codec.hpp"
#include "drivers/cia402/family.hpp"

namespace geodesic::drivers::test {

namespace {

using namespace cia402;  // NOLINT(google-build-using-namespace): the codec under test

class Checker {
 public:
  explicit Checker(const Row& row) : row_(row) {}

  std::vector<std::string> run() {
    if (row_.description.rfind("DISAGREEMENT", 0) == 0) {
      return {};  // what somebody else sends: documentation
    }
    if (row_.has("nmt")) {
      check_nmt();
    } else if (row_.has("nmt_state")) {
      check_heartbeat();
    } else if (row_.has("controlword")) {
      check_torque();
    } else if (row_.has("statusword")) {
      check_report();
    } else if (row_.has("emcy_code")) {
      check_emergency();
    } else if (row_.says("SYNC")) {
      expect_frame(encode_sync());
      expect(decode_sync(row_.frame), "was not decoded as SYNC");
    } else if (row_.frame.id == cob::kSdoRequest + node() ||
               row_.frame.id == cob::kSdoReply + node()) {
      check_sdo();
    } else {
      problem("of no kind that is known here: nothing to hold it against");
    }
    DriveOptions options;
    options.id = node();
    expect(decode(row_.frame, options).has_value(), "cannot be told in words");
    return problems_;
  }

 private:
  void problem(std::string text) { problems_.push_back(std::move(text)); }
  void expect(bool right, const char* text) {
    if (!right) {
      problem(text);
    }
  }

  std::uint32_t node() const { return static_cast<std::uint32_t>(row_.number("node")); }
  template <class T>
  T whole(const char* key) const {
    return static_cast<T>(static_cast<std::int64_t>(row_.number(key)));
  }

  static std::string words(const Frame& frame) {
    std::string text = fmt::format("{:03X}#", frame.id);
    for (const std::uint8_t byte : frame.payload()) {
      text += fmt::format("{:02X}", byte);
    }
    return text;
  }

  void expect_frame(const Frame& encoded) {
    if (encoded != row_.frame) {
      problem(fmt::format("encoded as {}, the vector is {}", words(encoded), words(row_.frame)));
    }
  }

  void check_nmt() {
    const NmtRequest wanted{whole<NmtCommand>("nmt"), static_cast<std::uint8_t>(node())};
    expect_frame(encode_nmt(wanted));
    expect(decode_nmt(row_.frame) == wanted, "was decoded as another NMT command");
  }

  void check_heartbeat() {
    const auto wanted = whole<NmtState>("nmt_state");
    expect_frame(encode_heartbeat(node(), wanted));
    expect(decode_heartbeat(row_.frame) == wanted, "was decoded as another NMT state");
  }

  void check_torque() {
    const TorqueCommand wanted{whole<std::uint16_t>("controlword"),
                               whole<std::int16_t>("target_torque")};
    expect_frame(encode_torque(node(), wanted));
    expect(decode_torque(row_.frame) == wanted, "was decoded as another torque command");
    if (row_.has("torque_nm")) {
      const double rated = row_.number("rated_torque_mnm") * 1e-3;
      const double torque = row_.number("torque_nm");
      const std::optional<std::int16_t> permille = to_permille(torque, rated, 32767);
      if (permille != wanted.torque_permille) {
        problem(fmt::format("{} N·m is {} per mille, the vector has {}", torque,
                            permille.value_or(0), wanted.torque_permille));
      }
      const double decoded = from_permille(wanted.torque_permille, rated);
      if (!(std::abs(decoded - torque) <= 1e-6 * std::abs(torque) + 1e-12)) {
        problem(fmt::format("decoded as {} N·m, the vector says {}", decoded, torque));
      }
    }
  }

  void check_report() {
    const Report wanted{whole<std::uint16_t>("statusword"), whole<std::int32_t>("position"),
                        whole<std::int16_t>("torque_actual")};
    expect_frame(encode_report(node(), wanted));
    expect(decode_report(row_.frame) == wanted, "was decoded as another report");
    std::string name = row_.text("state").value_or("");
    for (char& c : name) {
      c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    }
    const std::optional<PowerState> state = power_state(wanted.statusword);
    if (!state || name != power_state_name(*state)) {
      problem(fmt::format("its state is {}, the vector says {}",
                          state ? power_state_name(*state) : "none", name));
    }
  }

  void check_emergency() {
    const Emergency wanted{whole<std::uint16_t>("emcy_code"),
                           whole<std::uint8_t>("error_register")};
    Frame encoded = encode_emergency(node(), wanted);
    for (std::size_t i = 3; i < 8; ++i) {
      encoded.data[i] = row_.frame.data[i];  // the vendor's own
    }
    expect_frame(encoded);
    expect(decode_emergency(row_.frame) == wanted, "was decoded as another emergency");
  }

  /// Rows of configuration sequences do not say what they carry: there, decoding and encoding again
  /// must give the same bytes.
  void check_sdo() {
    const std::optional<Sdo> sdo =
        row_.command ? decode_sdo_request(row_.frame) : decode_sdo_reply(row_.frame);
    if (!sdo) {
      problem("was not decoded as an expedited transfer");
      return;
    }
    const Object object{sdo->index, sdo->sub, sdo->bytes};
    switch (sdo->kind) {
      case Sdo::Kind::kRead:
        expect_frame(encode_read(node(), object));
        break;
      case Sdo::Kind::kWrite:
        expect_frame(encode_write(node(), object, sdo->value));
        break;
      case Sdo::Kind::kReadReply:
        expect_frame(encode_read_reply(node(), object, sdo->value));
        break;
      case Sdo::Kind::kWriteReply:
        expect_frame(encode_write_reply(node(), object));
        break;
      case Sdo::Kind::kAbort:
        expect_frame(encode_abort(node(), object, static_cast<Abort>(sdo->value)));
        break;
    }
    if (row_.has("index")) {
      expect(sdo->index == whole<std::uint16_t>("index") && sdo->sub == whole<std::uint8_t>("sub"),
             "was decoded as another object");
    }
    const bool carries = sdo->kind == Sdo::Kind::kWrite || sdo->kind == Sdo::Kind::kReadReply;
    if (row_.has("value") && carries) {
      expect(sdo->value == whole<std::uint32_t>("value"), "was decoded as another value");
    }
    if (row_.says("upload")) {
      expect(row_.command ? sdo->kind == Sdo::Kind::kRead
                          : (sdo->kind == Sdo::Kind::kReadReply || sdo->kind == Sdo::Kind::kAbort),
             "was decoded as another transfer than an upload");
    } else {
      expect(sdo->kind == (row_.command ? Sdo::Kind::kWrite : Sdo::Kind::kWriteReply),
             "was decoded as another transfer than a download");
    }
    if (const std::optional<std::string> code = row_.text("abort"); code && !row_.command) {
      expect(
          sdo->kind == Sdo::Kind::kAbort && sdo->value == std::strtoul(code->c_str(), nullptr, 16),
          "was decoded as another abort");
    }
  }

  const Row& row_;
  std::vector<std::string> problems_;
};

}  // namespace

std::vector<std::string> check_cia402_row(const Row& row) {
  return Checker(row).run();
}

}  // namespace geodesic::drivers::test
