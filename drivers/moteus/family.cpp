// The moteus family for people: checks of options, names of faults, frames in words. See
// family.hpp.
#include "drivers/moteus/family.hpp"

#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <utility>

#include "drivers/moteus/driver.hpp"
#include "drivers/moteus/scanner.hpp"
#include "drivers/moteus/settings.hpp"
#include "drivers/moteus/simulated.hpp"
#include "drivers/moteus/zeroing.hpp"

namespace geodesic::drivers::moteus {

namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr std::int64_t kLeastWatchdogNs = 2'000'000;
constexpr std::int64_t kMostWatchdogNs = 10'000'000'000;
constexpr double kMostTorqueNm = 100'000.0;

std::string number(double value) {
  return fmt::format("{:.6g}", value);
}

std::string register_name(std::uint32_t number) {
  const RegisterFact* fact = find_register(number);
  return fact != nullptr ? std::string(fact->name) : fmt::format("register 0x{:03X}", number);
}

DecodedField value_field(const Entry& entry) {
  const RegisterFact* fact = find_register(entry.number);
  DecodedField field{register_name(entry.number), number(entry.value),
                     fact != nullptr ? fact->unit : ""};
  if (entry.number == 0x000 && entry.value >= 0.0 &&
      entry.value < static_cast<double>(kModeNames.size())) {
    field.value = kModeNames.at(static_cast<std::size_t>(entry.value));
  } else if (entry.number == 0x00F && entry.value > 0.0 && entry.value < 256.0) {
    field.value = error_name(static_cast<std::uint8_t>(entry.value));
  } else if (entry.number == 0x101) {
    const auto code = static_cast<std::uint32_t>(entry.code);
    field.value = fmt::format("{}.{}.{}", code >> 16U & 0xFFU, code >> 8U & 0xFFU, code & 0xFFU);
  }
  return field;
}

/// Printable, for the console's text may be anything.
std::string printable(std::string_view text) {
  std::string shown;
  for (const char letter : text) {
    shown += letter >= ' ' && letter <= '~' ? letter : ' ';
  }
  return shown;
}

/// All that stands in the frame, and what it is by its first writing or reading.
DecodedFrame words_of(const Frame& frame, bool reply) {
  DecodedFrame words;
  std::string asked;
  bool state = false;
  Reader reader(frame);
  for (Entry entry; reader.next(entry);) {
    switch (entry.kind) {
      case opcode::kWrite:
        if (words.kind.empty()) {
          words.kind = entry.number == 0x000 ? fmt::format("{} command", value_field(entry).value)
                                             : "register write";
        }
        [[fallthrough]];
      case opcode::kReply:
        state = state || (entry.kind == opcode::kReply && entry.number == 0x001);
        words.fields.push_back(value_field(entry));
        break;
      case opcode::kRead:
        asked += asked.empty() ? "" : ", ";
        asked += register_name(entry.number);
        break;
      case opcode::kWriteError:
      case opcode::kReadError:
        words.fields.push_back(
            {entry.kind == opcode::kReadError ? "read error" : "write error",
             fmt::format("{}: {}", register_name(entry.number),
                         entry.value == kNotWriteable ? "not writeable" : "unknown"),
             ""});
        break;
      case opcode::kClientPoll:
        words.kind = "console poll";
        break;
      default:
        words.kind = "console";
        words.fields.push_back({"text", fmt::format("'{}'", printable(entry.text)), ""});
    }
  }
  if (words.kind.empty()) {
    words.kind = reply ? (state ? "state" : "register reply") : "query";
  }
  if (!asked.empty()) {
    words.fields.push_back({"asks for", asked, ""});
  }
  if (reader.malformed()) {
    words.fields.push_back({"malformed", "the rest makes no sense", ""});
  }
  return words;
}

}  // namespace

std::optional<DecodedFrame> decode(const Frame& frame, const DriveOptions& options) {
  if (frame.error || frame.remote) {
    return std::nullopt;
  }
  const Address address = from_id(frame.id);
  const Link link = link_for(options);
  if (address.prefix != link.prefix) {
    return std::nullopt;
  }
  if (address.source == link.drive && !address.reply_wanted && address.destination == link.host) {
    return words_of(frame, true);
  }
  if (address.destination == link.drive || address.destination == kBroadcast) {
    return words_of(frame, false);
  }
  return std::nullopt;
}

const char* error_name(std::uint8_t code) {
  switch (code) {
    case 11:
      return "position time-out (the drive's watchdog expired)";
    case 32:
      return "calibration fault";
    case 33:
      return "gate driver fault (often the supply gives way)";
    case 34:
      return "over-voltage";
    case 35:
      return "encoder fault";
    case 36:
      return "motor not configured (run moteus_tool --calibrate)";
    case 37:
      return "PWM cycle overrun";
    case 38:
      return "over-temperature";
    case 39:
      return "start outside the drive's position limits";
    case 40:
      return "under-voltage";
    case 41:
      return "configuration changed in operation";
    case 42:
      return "theta invalid (no commutation encoder)";
    case 43:
      return "position invalid (no output encoder)";
    case 44:
      return "gate driver cannot be enabled";
    case 45:
      return "stop position is deprecated";
    case 46:
      return "timing violation";
    case 47:
      return "back-EMF feed-forward without acceleration limit";
    case 48:
      return "invalid position limits";
    case 49:
      return "position error beyond its threshold";
    case 50:
      return "velocity error beyond its threshold";
    case 96:
      return "limited by maximum velocity";
    case 97:
      return "limited by maximum power";
    case 98:
      return "limited by supply voltage";
    case 99:
      return "limited by maximum current";
    case 100:
      return "limited by board temperature";
    case 101:
      return "limited by motor temperature";
    case 102:
      return "limited by commanded maximum torque";
    case 103:
      return "limited by position bounds";
    case 104:
      return "flux braking";
    case 105:
      return "field weakening";
    default:
      return "unknown error";
  }
}

std::vector<std::string> check(const DriveOptions& options) {
  std::vector<std::string> wrong;
  if (options.id < 1 || options.id > kLastId) {
    wrong.push_back(
        fmt::format("the drive's id (id.id) is {}; it must be between 1 and 126 (127 is everybody)",
                    options.id));
  }
  const Link link = link_for(options);
  if (link.host == options.id) {
    wrong.push_back(fmt::format("host_id {} is the drive's own id; choose another", link.host));
  }
  if (options.reply_id != 0 && options.reply_id != to_id(link.reply())) {
    wrong.push_back(fmt::format(
        "the drive's reply id is 0x{:X}; this family answers on 0x{:X} (its id, then the host's): "
        "remove reply_id",
        options.reply_id, to_id(link.reply())));
  }
  if (!options.fd) {
    wrong.push_back(
        "the drive needs CAN FD: its torque commands have 32 bytes and more; set fd = true for "
        "the bus");
  }
  const auto range = [&wrong](const char* what, double value, const char* unit) {
    if (!std::isfinite(value) || value <= 0.0 || value > kMostTorqueNm) {
      wrong.push_back(fmt::format(
          "the drive's {} is {} {}; it must be above 0, the most that is ever asked for", what,
          value, unit));
    }
  };
  range("torque range", options.torque_range_nm, "N·m");
  range("velocity range", options.velocity_range_rad_s, "rad/s");
  if (!std::isfinite(options.position_range_rad) || options.position_range_rad < 0.0) {
    wrong.push_back(
        fmt::format("the drive's position range is {} rad; leave it out, or say how far "
                    "the drive turns at most",
                    options.position_range_rad));
  }
  if (options.watchdog_ns < kLeastWatchdogNs || options.watchdog_ns > kMostWatchdogNs) {
    wrong.push_back(
        fmt::format("the drive's watchdog time is {} ms; it must be between 2 ms and 10 s",
                    static_cast<double>(options.watchdog_ns) * 1e-6));
  }
  return wrong;
}

Family family() {
  return {
      .name = "moteus",
      .summary = "mjbots moteus controllers, register protocol on CAN FD",
      .make_drive = [](const DriveOptions& options) -> std::unique_ptr<Drive> {
        return std::make_unique<Driver>(options);
      },
      .make_simulated = [](const DriveOptions& options) -> std::unique_ptr<SimulatedDrive> {
        return std::make_unique<Simulated>(options);
      },
      .decode = decode,
      .check = check,
      .error_name = error_name,
      .settings = kSettings,
      .cyclic_frames = [](const DriveOptions& options, double) -> std::vector<CyclicFrame> {
        const Link link = link_for(options);
        const Formats formats = formats_for(options);
        const std::uint32_t reply = to_id(link.reply());
        return {{.what = "torque",
                 .id = to_id(link.command()),
                 .bytes = static_cast<std::uint8_t>(command_length(formats, options.watchdog_ns)),
                 .extended = true},
                {.what = "state",
                 .id = reply,
                 .bytes = static_cast<std::uint8_t>(reply_length(formats)),
                 .extended = reply > kLastStandardId,
                 .reply = true}};
      },
      .position_period_rad =
          [](const DriveOptions& options) {
            return kTurn * (setting(options, kHome) == 0.0 ? 1.0 : setting(options, kRatio));
          },
      .make_scanner = [](bool fd) -> std::unique_ptr<drivers::Scanner> {
        return fd ? std::make_unique<Scanner>() : nullptr;
      },
      .make_zeroing = [](const DriveOptions& options) -> std::unique_ptr<drivers::Zeroing> {
        return std::make_unique<Zeroing>(options);
      },
  };
}

}  // namespace geodesic::drivers::moteus
