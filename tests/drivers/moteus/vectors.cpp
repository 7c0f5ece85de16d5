// Holds rows of golden vectors against the moteus codec and the simulated drive, both ways; see
// vectors.hpp.
#include "tests/drivers/moteus/vectors.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "drivers/moteus/codec.hpp"
#include "drivers/moteus/family.hpp"
#include "drivers/moteus/settings.hpp"
#include "drivers/moteus/simulated.hpp"

namespace geodesic::drivers::test {

namespace {

using namespace moteus;  // NOLINT(google-build-using-namespace): the codec under test

struct Key {
  const char* key;
  std::uint32_t number;
};
constexpr std::array kCommandKeys = {Key{"position", 0x020},           Key{"velocity", 0x021},
                                     Key{"feedforward_torque", 0x022}, Key{"kp_scale", 0x023},
                                     Key{"kd_scale", 0x024},           Key{"maximum_torque", 0x025},
                                     Key{"watchdog_timeout", 0x027},   Key{"ilimit_scale", 0x02B}};
constexpr std::array kReplyKeys = {Key{"mode", 0x000},
                                   Key{"position", 0x001},
                                   Key{"velocity", 0x002},
                                   Key{"torque", 0x003},
                                   Key{"q_current", 0x004},
                                   Key{"motor_temperature", 0x00A},
                                   Key{"trajectory_complete", 0x00B},
                                   Key{"voltage", 0x00D},
                                   Key{"temperature", 0x00E},
                                   Key{"fault", 0x00F}};

constexpr auto k8 = Resolution::kInt8;
constexpr auto k16 = Resolution::kInt16;
constexpr auto k32 = Resolution::kInt32;
constexpr auto kReal = Resolution::kFloat;

std::vector<Item> query_items(int format) {
  const auto item = [](unsigned number, Resolution resolution) {
    return Item{static_cast<Register>(number), resolution};
  };
  switch (format) {
    case 0:
      return {item(0, k8),  item(1, kReal), item(2, kReal), item(3, kReal),
              item(13, k8), item(14, k8),   item(15, k8)};
    case 1:
      return {item(0, k8),  item(1, k16), item(2, k16), item(3, k16),
              item(13, k8), item(14, k8), item(15, k8)};
    case 2:
      return {item(0, k8),  item(1, k32),  item(2, k32),  item(3, k32),
              item(4, k16), item(13, k16), item(14, k16), item(15, k8)};
    case 3:
      return {item(0, k16), item(1, kReal), item(2, kReal), item(3, kReal), item(10, k16),
              item(11, k8), item(13, k16),  item(14, k16),  item(15, k16)};
    default:
      return {};
  }
}

double unit_of(std::uint32_t number, Resolution resolution) {
  const RegisterFact* fact = find_register(number);
  const Scale& scale = kScales.at(static_cast<std::size_t>(fact->quantity));
  return resolution == k8 ? scale.int8 : (resolution == k16 ? scale.int16 : scale.int32);
}

double top_of(Resolution resolution) {
  return resolution == k8 ? 127.0 : (resolution == k16 ? 32767.0 : 2147483647.0);
}

class Checker {
 public:
  explicit Checker(const Row& row) : row_(row) {}

  std::vector<std::string> run() {
    if (row_.description.rfind("DISAGREEMENT", 0) == 0) {
      return {};
    }
    Reader reader(row_.frame);
    for (Entry entry; reader.next(entry);) {
      entries_.push_back(entry);
    }
    if (reader.malformed()) {
      problem("is malformed to our reader");
    }
    if (row_.command) {
      check_command();
    } else {
      check_feedback();
    }
    check_words();
    return problems_;
  }

 private:
  void problem(std::string text) { problems_.push_back(std::move(text)); }

  const Entry* find(std::uint8_t kind, std::uint32_t number) const {
    const auto at = std::find_if(entries_.begin(), entries_.end(), [&](const Entry& entry) {
      return entry.kind == kind && entry.number == number;
    });
    return at == entries_.end() ? nullptr : &*at;
  }

  int whole(const char* key) const { return static_cast<int>(row_.number(key)); }

  /// `found` is what a register of that resolution makes of `wanted`, within `codes` of it.
  void expect_near(const std::string& what, const Entry& at, double found, double wanted,
                   double codes) {
    if (std::isnan(wanted) || std::isnan(found)) {
      if (std::isnan(wanted) != std::isnan(found)) {
        problem(fmt::format("{} is {:.9g}, the vector says {:.9g}", what, found, wanted));
      }
      return;
    }
    double slack = 1e-6 * std::abs(wanted) + 1e-12;
    if (at.resolution != kReal) {
      const double unit = unit_of(at.number, at.resolution);
      const double end = unit * top_of(at.resolution);
      wanted = std::clamp(wanted, -end, end);
      slack += codes * unit;
    }
    if (!(std::abs(found - wanted) <= slack)) {
      problem(fmt::format("{} is {:.9g}, the vector says {:.9g}", what, found, wanted));
    }
  }

  std::vector<Item> wanted_writes() {
    const std::string op = row_.text("op").value_or("");
    const auto mode = [](Mode value) {
      return Item{Register::kMode, k8, static_cast<double>(value)};
    };
    if (op == "stop") return {mode(Mode::kStopped)};
    if (op == "brake") return {mode(Mode::kBrake)};
    if (op == "query") return {};
    if (op == "output_nearest" || op == "output_exact") {
      return {{op == "output_exact" ? Register::kSetOutputExact : Register::kSetOutputNearest,
               kReal, row_.number("position")}};
    }
    if (op == "current") {
      return {mode(Mode::kCurrent),
              {Register::kCommandQCurrent, kReal, row_.number("q_A")},
              {static_cast<Register>(0x01D), kReal, row_.number("d_A")}};
    }
    std::vector<Item> items = {mode(Mode::kPosition)};
    if (op != "position") {
      problem(fmt::format("op={} is not known", op));
      return items;
    }
    const std::map<std::string, Resolution> kNames = {
        {"int8", k8}, {"int16", k16}, {"int32", k32}, {"float", kReal}};
    for (const Key& key : kCommandKeys) {
      if (!row_.has(key.key)) continue;
      const Entry* there = find(opcode::kWrite, key.number);
      if (there == nullptr) {
        problem(fmt::format("{} is not written", key.key));
        continue;
      }
      if (const auto named = row_.text("resolution");
          named && there->resolution != kNames.at(*named)) {
        problem(fmt::format("{} is not written as {}", key.key, *named));
      }
      items.push_back({static_cast<Register>(key.number), there->resolution, row_.number(key.key)});
    }
    return items;
  }

  void check_command() {
    const Address address{static_cast<std::uint32_t>(whole("source")),
                          static_cast<std::uint32_t>(whole("dest")), whole("reply") == 1,
                          row_.has("prefix") ? static_cast<std::uint32_t>(whole("prefix")) : 0U};
    if (from_id(row_.frame.id) != address) {
      problem("the identifier was taken apart into something else");
    }
    const std::vector<Item> writes = wanted_writes();
    Frame ours = make_frame(address);
    const int format = !address.reply_wanted      ? -1
                       : row_.has("query_format") ? whole("query_format")
                                                  : 0;
    const bool fitted = append_writes(ours, writes) && append_reads(ours, query_items(format));
    if (!fitted || ours.length != whole("len_unpadded")) {
      problem(fmt::format("encoded it has {} bytes, the vector says {}", ours.length,
                          whole("len_unpadded")));
    }
    pad(ours);
    compare(ours);
    for (const Item& item : writes) {
      const Entry* there = find(opcode::kWrite, static_cast<std::uint32_t>(item.number));
      if (there != nullptr) {
        expect_near(fmt::format("register 0x{:03X} decoded", there->number), *there, there->value,
                    item.value, 1.001);
      }
    }
    check_simulated(address, writes);
  }

  void compare(const Frame& ours) {
    if (ours.id != row_.frame.id || ours.extended != row_.frame.extended ||
        ours.fd != row_.frame.fd || ours.length != row_.frame.length) {
      problem(fmt::format("encoded as {:X} with {} bytes", ours.id, ours.length));
      return;
    }
    Reader reader(ours);
    std::size_t at = 0;
    bool exact = true;
    for (Entry entry; reader.next(entry); ++at) {
      if (at >= entries_.size() || entry.kind != entries_[at].kind ||
          entry.number != entries_[at].number || entry.resolution != entries_[at].resolution) {
        problem(fmt::format("subframe {} is encoded as another", at));
        return;
      }
      exact = exact && entry.code == entries_[at].code && entry.resolution != kReal;
      // The reference truncates: one code; a scale in 32 bits is float32 there: 128.
      const double codes =
          entry.resolution == k32 && entry.number >= 0x23 && entry.number <= 0x24 ? 128.0 : 1.001;
      expect_near(fmt::format("register 0x{:03X} encoded", entry.number), entries_[at], entry.value,
                  entries_[at].value, codes);
    }
    if (at != entries_.size()) {
      problem("encoded, subframes are missing");
    }
    if (exact && ours.data != row_.frame.data) {
      problem("the same values are encoded as other bytes");
    }
  }

  /// The simulated drive reads the same from the frame.
  void check_simulated(const Address& address, const std::vector<Item>& writes) {
    DriveOptions options = options_for(address.destination);
    options.settings.values[kPrefix] = address.prefix;
    Simulated drive(options);
    std::array<Frame, 1> reply;
    const std::size_t replies = drive.receive(row_.frame, 0, reply);
    if (replies != (address.reply_wanted ? 1U : 0U)) {
      problem(fmt::format("the simulated drive replied {} times", replies));
    }
    for (const Item& item : writes) {
      const auto number = static_cast<std::uint32_t>(item.number);
      if (number < 0x020 || number > 0x02B) continue;
      Frame ask = make_frame({address.source, address.destination, true, address.prefix});
      const std::array<Item, 1> asked = {Item{item.number, kReal}};
      append_reads(ask, asked);
      pad(ask);
      drive.receive(ask, 0, reply);
      Reader reader(reply[0]);
      Entry entry;
      const Entry* there = find(opcode::kWrite, number);
      if (!reader.next(entry) || there == nullptr) {
        problem("the simulated drive does not tell a register");
        continue;
      }
      expect_near(fmt::format("register 0x{:03X} in the simulated drive", number), *there,
                  entry.value, item.value, 1.001);
    }
  }

  void check_feedback() {
    for (const Key& key : kReplyKeys) {
      if (!row_.has(key.key)) continue;
      const Entry* there = find(opcode::kReply, key.number);
      if (there == nullptr) {
        problem(fmt::format("{} was not found", key.key));
        continue;
      }
      expect_near(key.key, *there, there->value, row_.number(key.key), 1e-4);
    }
    const StateReport report = decode_report(row_.frame);
    if (!report.mode || *report.mode != whole("mode") || !report.fault ||
        *report.fault != whole("fault") || !report.position_rev) {
      problem("was not decoded as this state");
    }
    if (report.saturated != row_.says("saturated at the integer limits") &&
        whole("query_format") == 1 && !row_.says("minimum integers")) {
      problem("saturation was not noticed, or seen where there is none");
    }
    const Address expected{row_.frame.id >> 8U, 0, false, 0};
    if (from_id(row_.frame.id) != expected) {
      problem("the identifier was taken apart into something else");
    }
    check_simulated_reply();
  }

  /// Asked the same way of the same shaft, the simulated drive sends the same position and
  /// velocity.
  void check_simulated_reply() {
    const double position = row_.number("position");
    const double velocity = row_.number("velocity");
    if (std::isnan(position)) return;
    constexpr double kTurn = 6.283185307179586;
    Simulated drive(options_for(row_.frame.id >> 8U));
    const bool saturated = row_.says("saturated");
    drive.set_shaft(position * kTurn * (saturated ? 100.0 : 1.0),
                    velocity * kTurn * (saturated ? 1000.0 : 1.0));
    Frame ask = make_frame({0, row_.frame.id >> 8U, true, 0});
    append_reads(ask, query_items(whole("query_format")));
    pad(ask);
    std::array<Frame, 1> reply;
    if (drive.receive(ask, 0, reply) != 1 || reply[0].length != row_.frame.length ||
        reply[0].id != row_.frame.id || reply[0].extended != row_.frame.extended) {
      problem("the simulated drive replies in another shape");
      return;
    }
    if (saturated && whole("query_format") == 2) return;  // 32 bits end elsewhere
    Reader reader(reply[0]);
    for (Entry entry; reader.next(entry);) {
      const Entry* there = find(opcode::kReply, entry.number);
      if (there == nullptr) {
        problem("the simulated drive replies with another register");
      } else if (entry.number == 1 || entry.number == 2) {
        expect_near(fmt::format("register {} of the simulated drive", entry.number), *there,
                    entry.value, there->value, 1.001);
      }
    }
  }

  static DriveOptions options_for(std::uint32_t id) {
    DriveOptions options;
    options.id = id;
    options.fd = true;
    options.velocity_range_rad_s = 50.0;
    options.torque_range_nm = 10.0;
    return options;
  }

  void check_words() {
    const Address address = from_id(row_.frame.id);
    DriveOptions options = options_for(row_.command ? address.destination : address.source);
    options.settings.values[kPrefix] = address.prefix;
    const auto words = decode(row_.frame, options);
    if (!words || words->kind.empty()) {
      problem("cannot be told in words");
    }
  }

  const Row& row_;
  std::vector<Entry> entries_;
  std::vector<std::string> problems_;
};

}  // namespace

std::vector<std::string> check_moteus_row(const Row& row) {
  return Checker(row).run();
}

}  // namespace geodesic::drivers::test
