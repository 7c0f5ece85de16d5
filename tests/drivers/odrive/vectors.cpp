// Holds rows of golden vectors against the ODrive codec, both ways; see vectors.hpp.
#include "tests/drivers/odrive/vectors.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "drivers/odrive/codec.hpp"
#include "drivers/odrive/settings.hpp"
#include "drivers/odrive/words.hpp"

namespace geodesic::drivers::test {

namespace {

using namespace odrive;  // NOLINT(google-build-using-namespace): the codec under test

class Checker {
 public:
  explicit Checker(const Row& row) : row_(row) {}

  std::vector<std::string> run() {
    if (row_.description.rfind("DISAGREEMENT", 0) == 0) {
      return {};  // what somebody else sends: documentation
    }
    const std::string name = row_.text("msg").value_or("");
    const std::string firmware = row_.text("fw").value_or("");
    if (firmware != "0.6" && firmware != "0.5") {
      throw std::invalid_argument("fw is '" + firmware + "', expected 0.6 or 0.5");
    }
    firmware_ = firmware == "0.6" ? Firmware::k06 : Firmware::k05;
    const auto found = std::find_if(kMessages.begin(), kMessages.end(), [&](const Message* one) {
      return one->in(firmware_) && name == one->name;
    });
    if (found == kMessages.end()) {
      problem(fmt::format("msg={} is not known of firmware {}", name, firmware));
      return problems_;
    }
    message_ = *found;
    check();
    return problems_;
  }

 private:
  void problem(std::string text) { problems_.push_back(std::move(text)); }

  std::uint32_t node() const { return static_cast<std::uint32_t>(row_.number("node")); }

  void check() {
    if (row_.frame.id != frame_id(node(), message_->command) || row_.frame.extended ||
        row_.frame.fd) {
      problem(fmt::format("identifier {:X}, expected {:X}", row_.frame.id,
                          frame_id(node(), message_->command)));
    }
    if (row_.command == message_->report) {
      problem("the direction is the other one");
    }
    if (row_.says("must refuse")) {
      if (encode(node(), *message_, {std::nan("")})) {
        problem("a number that is not finite was encoded");
      }
      return;
    }
    if (message_ == &kRxSdo06 || message_ == &kTxSdo06) {
      check_sdo();
    } else {
      check_decoding();
      check_encoding();
    }
    DriveOptions options;
    options.id = node();
    options.settings.values[static_cast<std::size_t>(Key::kFirmware)] =
        firmware_ == Firmware::k06 ? 0.0 : 1.0;
    const auto words = decode(row_.frame, options);
    if (!words || words->kind != message_->name) {
      problem("cannot be told in words");
    }
  }

  /// What was asked for; rounded fields say it apart.
  double wanted(const Field& field) const {
    const std::string requested = fmt::format("{}_requested", field.name);
    return row_.has(requested) ? row_.number(requested) : row_.number(field.name);
  }

  void check_decoding() {
    for (std::size_t i = 0; i < message_->count(); ++i) {
      const Field& field = message_->fields[i];
      if (!row_.has(field.name)) {
        continue;
      }
      const double expected = row_.number(field.name);
      const auto value = decode(row_.frame, field);
      const bool same = value && (std::isnan(expected) ? std::isnan(*value)
                                                       : std::abs(*value - expected) <=
                                                             1e-6 * std::abs(expected) + 1e-12);
      if (!same) {
        problem(fmt::format("{} decoded as {}, the vector says {}", field.name,
                            value.value_or(-1e99), expected));
      }
    }
  }

  void check_encoding() {
    std::vector<double> values;
    for (std::size_t i = 0; i < message_->count(); ++i) {
      const Field& field = message_->fields[i];
      values.push_back(row_.has(field.name) ? wanted(field) : 0.0);
      if (std::isnan(values.back())) {
        if (encode(node(), *message_, values)) {
          problem("a number that is not finite was encoded");
        }
        return;  // a drive may send it
      }
    }
    const auto encoded = encode(node(), *message_, values);
    if (!encoded) {
      problem("was refused");
      return;
    }
    for (std::size_t i = 0; i < message_->count(); ++i) {
      const Field& field = message_->fields[i];
      const auto ours = decode(*encoded, field);
      const auto theirs = decode(row_.frame, field);
      const double code = field.type == Type::kI16Milli ? 1.001e-3 : 0.0;  // theirs is truncated
      if (!ours || !theirs || !(std::abs(*ours - *theirs) <= code)) {
        problem(fmt::format("{} = {} encoded as {}, the vector has {}", field.name, values[i],
                            ours.value_or(-1e99), theirs.value_or(-1e99)));
      }
    }
    const bool exact = std::none_of(message_->fields.begin(), message_->fields.end(),
                                    [](const Field& f) { return f.type == Type::kI16Milli; });
    const auto common = static_cast<std::ptrdiff_t>(std::min(encoded->length, row_.frame.length));
    if (exact && !std::equal(encoded->data.begin(), encoded->data.begin() + common,
                             row_.frame.data.begin())) {
      problem("encoded as other bytes");
    }
    if (encoded->length > row_.frame.length || encoded->id != row_.frame.id) {
      problem("encoded longer than the vector, or to another identifier");
    }
  }

  void check_sdo() {
    const auto endpoint = static_cast<std::uint16_t>(row_.number("endpoint"));
    const auto sdo = decode_sdo(row_.frame);
    const bool with_value = row_.has("value");
    const double value = with_value ? row_.number("value") : 0.0;
    if (!sdo || sdo->endpoint != endpoint || sdo->bytes != (with_value ? 4 : 0) ||
        std::abs(sdo_value(*sdo, ParameterType::kFloat) - value) > 1e-6 * std::abs(value)) {
      problem("was decoded as another endpoint or value");
    }
    if (!row_.command) {
      return;
    }
    const Frame ours = row_.number("opcode") == 0.0
                           ? encode_sdo_read(node(), endpoint)
                           : encode_sdo_write(node(), endpoint, ParameterType::kFloat, value);
    if (ours != row_.frame) {
      problem("was encoded as other bytes");
    }
  }

  const Row& row_;
  Firmware firmware_ = Firmware::k06;
  const Message* message_ = nullptr;
  std::vector<std::string> problems_;
};

}  // namespace

std::vector<std::string> check_odrive_row(const Row& row) {
  return Checker(row).run();
}

}  // namespace geodesic::drivers::test
