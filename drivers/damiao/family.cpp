// The Damiao family for people: checks of options, names of errors, frames in words. See
// family.hpp.
#include "drivers/damiao/family.hpp"

#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <utility>

#include "drivers/damiao/codec.hpp"
#include "drivers/damiao/driver.hpp"
#include "drivers/damiao/scanner.hpp"
#include "drivers/damiao/simulated.hpp"
#include "drivers/damiao/zeroing.hpp"

namespace geodesic::drivers::damiao {

namespace {

constexpr std::uint32_t kLastId = Scanner::kLastId;
constexpr std::uint32_t kLastReplyId = 0x7FE;
constexpr std::int64_t kLeastWatchdogNs = 1'000'000;
constexpr std::int64_t kMostWatchdogNs = 10'000'000'000;

DecodedField field(std::string name, double value, std::string unit) {
  return {std::move(name), fmt::format("{:.6g}", value), std::move(unit)};
}

DecodedFrame decode_command(const MitCommand& command) {
  return {"MIT command",
          {field("position", command.position_rad, "rad"),
           field("velocity", command.velocity_rad_s, "rad/s"),
           field("stiffness", command.stiffness_nm_rad, "N·m/rad"),
           field("damping", command.damping_nm_s_rad, "N·m·s/rad"),
           field("torque", command.torque_nm, "N·m")}};
}

const char* name_of(Special special) {
  switch (special) {
    case Special::kClearError:
      return "clear error";
    case Special::kEnable:
      return "enable";
    case Special::kDisable:
      return "disable";
    case Special::kSetZero:
      return "set zero";
  }
  return "special";
}

const char* status_name(std::uint8_t status) {
  switch (static_cast<Status>(status)) {
    case Status::kDisabled:
      return "disabled";
    case Status::kEnabled:
      return "enabled";
    default:
      return error_name(status);
  }
}

DecodedFrame decode_state(const StateReport& report) {
  return {"state",
          {{"status", status_name(report.status), ""},
           field("position", report.position_rad, "rad"),
           field("velocity", report.velocity_rad_s, "rad/s"),
           field("torque", report.torque_nm, "N·m"),
           field("MOSFET temperature", report.mosfet_c, "°C"),
           field("rotor temperature", report.rotor_c, "°C")}};
}

/// "read", "write" with the register's name and, where it says something, its value.
DecodedFrame register_words(const RegisterFrame& frame, const char* side, bool with_value) {
  const RegisterFact* fact = find_register(frame.number);
  DecodedFrame words{
      fmt::format("register {} {}",
                  frame.operation == static_cast<std::uint8_t>(Operation::kRead) ? "read" : "write",
                  side),
      {{"register", fmt::format("{}", frame.number), ""}}};
  if (fact != nullptr) {
    words.fields.push_back({"name", fact->name, ""});
  }
  if (with_value) {
    const bool integer = fact == nullptr || fact->integer;
    words.fields.push_back(
        {"value", integer ? fmt::format("{}", frame.raw) : fmt::format("{:.6g}", frame.real()),
         fact != nullptr ? fact->unit : ""});
  }
  return words;
}

std::optional<DecodedFrame> decode_register_request(const Frame& frame, std::uint32_t id) {
  const std::optional<RegisterFrame> request = decode_register(frame);
  if (!request || request->id != id) {
    return std::nullopt;
  }
  switch (static_cast<Operation>(request->operation)) {
    case Operation::kRead:
      return register_words(*request, "request", false);
    case Operation::kWrite:
      return register_words(*request, "request", true);
    case Operation::kSave:
      return DecodedFrame{"save registers", {}};
    case Operation::kState:
      return DecodedFrame{"state request", {}};
  }
  return DecodedFrame{"unknown register operation",
                      {{"operation", fmt::format("0x{:02X}", request->operation), ""}}};
}

std::optional<DecodedFrame> decode_reply(const Frame& frame, std::uint32_t id,
                                         const Ranges& ranges) {
  // A listener does not know what was asked: what looks like a register answer in its first four
  // bytes is taken for one, which as a state would be a disabled drive at its far end.
  const std::optional<RegisterFrame> answer = decode_register(frame);
  if (answer && answer->id == id && find_register(answer->number) != nullptr) {
    if (answer->operation == static_cast<std::uint8_t>(Operation::kRead) ||
        answer->operation == static_cast<std::uint8_t>(Operation::kWrite)) {
      return register_words(*answer, "reply", true);
    }
    if (answer->operation == static_cast<std::uint8_t>(Operation::kSave)) {
      return DecodedFrame{"save reply", {}};
    }
  }
  const std::optional<StateReport> report = decode_report(frame, ranges);
  if (!report || report->motor != (id & 0xFU)) {
    return std::nullopt;
  }
  return decode_state(*report);
}

/// Commands of the modes we do not drive in, at ESC_ID + 0x100 and on.
std::optional<DecodedFrame> decode_other_mode(const Frame& frame, std::uint32_t id) {
  if (frame.id == command_id(id, ControlMode::kPositionVelocity)) {
    if (const auto command = decode_position_velocity(frame)) {
      return DecodedFrame{"position-velocity command",
                          {field("position", command->position_rad, "rad"),
                           field("velocity limit", command->velocity_limit_rad_s, "rad/s")}};
    }
  } else if (frame.id == command_id(id, ControlMode::kVelocity)) {
    if (const auto velocity = decode_velocity(frame)) {
      return DecodedFrame{"velocity command", {field("velocity", *velocity, "rad/s")}};
    }
  } else if (frame.id == command_id(id, ControlMode::kPositionForce)) {
    if (const auto command = decode_position_force(frame)) {
      return DecodedFrame{"position-force command",
                          {field("position", command->position_rad, "rad"),
                           field("velocity limit", command->velocity_limit_rad_s, "rad/s"),
                           field("current limit", command->current_limit, "of maximum")}};
    }
  }
  return std::nullopt;
}

}  // namespace

std::optional<DecodedFrame> decode(const Frame& frame, const DriveOptions& options) {
  const Ranges ranges{options.position_range_rad, options.velocity_range_rad_s,
                      options.torque_range_nm};
  if (frame.error || frame.extended || frame.remote) {
    return std::nullopt;
  }
  if (frame.id == kRegisterId) {
    return decode_register_request(frame, options.id);
  }
  if (frame.id == options.reply_id) {
    return decode_reply(frame, options.id, ranges);
  }
  if (frame.id == options.id) {
    if (const auto special = decode_special(frame)) {
      return DecodedFrame{name_of(*special), {}};
    }
    if (const auto command = decode_mit(frame, ranges)) {
      return decode_command(*command);
    }
    return std::nullopt;
  }
  return decode_other_mode(frame, options.id);
}

const char* error_name(std::uint8_t code) {
  switch (static_cast<Status>(code)) {
    case Status::kOverVoltage:
      return "over-voltage";
    case Status::kUnderVoltage:
      return "under-voltage";
    case Status::kOverCurrent:
      return "over-current";
    case Status::kMosfetOverTemperature:
      return "MOSFET over-temperature";
    case Status::kRotorOverTemperature:
      return "rotor over-temperature";
    case Status::kCommunicationLost:
      return "communication lost (the drive's watchdog expired)";
    case Status::kOverload:
      return "overload";
    default:
      return "unknown error";
  }
}

std::vector<std::string> check(const DriveOptions& options) {
  std::vector<std::string> wrong;
  if (options.id < 1 || options.id > kLastId) {
    wrong.push_back(fmt::format(
        "the drive's id (ESC_ID) is 0x{:X}; it must be between 0x01 and 0xFF, since its other "
        "control modes listen at 0x100, 0x200 and 0x300 above it",
        options.id));
  }
  if (options.reply_id < 1 || options.reply_id > kLastReplyId) {
    wrong.push_back(fmt::format(
        "the drive's reply id (MST_ID) is 0x{:X}; it must be between 0x001 and 0x7FE: at 0, the "
        "factory setting, all drives answer on one identifier and destroy each other's frames. "
        "Write register 7 (usual: id + 0x10) and save",
        options.reply_id));
  }
  for (std::uint32_t mode = 1; mode <= 4; ++mode) {
    if (options.reply_id == command_id(options.id, static_cast<ControlMode>(mode))) {
      wrong.push_back(fmt::format(
          "the drive's reply id 0x{:X} is an identifier it is commanded by; choose another "
          "MST_ID (register 7), usually id + 0x10",
          options.reply_id));
    }
  }
  const auto range = [&wrong](const char* what, double value, const char* unit) {
    if (!std::isfinite(value) || value <= 0.0) {
      wrong.push_back(fmt::format("the drive's {} is {} {}; it must be the drive's own, above 0",
                                  what, value, unit));
    }
  };
  range("position range (PMAX)", options.position_range_rad, "rad");
  range("velocity range (VMAX)", options.velocity_range_rad_s, "rad/s");
  range("torque range (TMAX)", options.torque_range_nm, "N·m");
  if (options.watchdog_ns < kLeastWatchdogNs || options.watchdog_ns > kMostWatchdogNs) {
    wrong.push_back(
        fmt::format("the drive's watchdog time is {} ms; it must be between 1 ms and 10 s",
                    static_cast<double>(options.watchdog_ns) * 1e-6));
  }
  return wrong;
}

Family family() {
  return {
      .name = "damiao",
      .summary = "Damiao DM-J, DM-H and DM-G series in MIT mode, CAN or CAN FD",
      .make_drive = [](const DriveOptions& options) -> std::unique_ptr<Drive> {
        return std::make_unique<Driver>(options);
      },
      .make_simulated = [](const DriveOptions& options) -> std::unique_ptr<SimulatedDrive> {
        return std::make_unique<Simulated>(options);
      },
      .decode = decode,
      .check = check,
      .error_name = error_name,
      .settings = {},
      .cyclic_frames = [](const DriveOptions& options, double) -> std::vector<CyclicFrame> {
        return {{.what = "torque", .id = options.id},
                {.what = "state", .id = options.reply_id, .reply = true}};
      },
      .position_period_rad = [](const DriveOptions&) { return 2.0 * std::numbers::pi; },
      .make_scanner = [](bool fd) -> std::unique_ptr<drivers::Scanner> {
        return std::make_unique<Scanner>(fd);
      },
      .make_zeroing = [](const DriveOptions& options) -> std::unique_ptr<drivers::Zeroing> {
        return std::make_unique<Zeroing>(options);
      },
  };
}

}  // namespace geodesic::drivers::damiao
