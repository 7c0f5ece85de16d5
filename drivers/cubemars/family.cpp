// The CubeMars family for people: checks of options, names of errors, frames in words. See
// family.hpp.
#include "drivers/cubemars/family.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "drivers/cubemars/bench.hpp"
#include "drivers/cubemars/codec.hpp"
#include "drivers/cubemars/driver.hpp"
#include "drivers/cubemars/settings.hpp"
#include "drivers/cubemars/simulated.hpp"

namespace geodesic::drivers::cubemars {

namespace {

constexpr std::int64_t kLeastWatchdogNs = 1'000'000;
constexpr std::int64_t kMostWatchdogNs = 10'000'000'000;
constexpr double kStatusRateHz = 500.0;  ///< the fastest the drive can be set to

DecodedField field(std::string name, double value, std::string unit) {
  return {std::move(name), fmt::format("{:.6g}", value), std::move(unit)};
}

const char* error_words(std::uint8_t code) {
  return code == 0 ? "none" : error_name(code);
}

const char* name_of(Special special) {
  switch (special) {
    case Special::kEnter:
      return "enter MIT control";
    case Special::kExit:
      return "leave MIT control";
    case Special::kSetZero:
      return "set zero";
  }
  return "special";
}

DecodedFrame command_words(const MitCommand& command) {
  return {"MIT command",
          {field("position", command.position_rad, "rad"),
           field("velocity", command.velocity_rad_s, "rad/s"),
           field("stiffness", command.stiffness_nm_rad, "N·m/rad"),
           field("damping", command.damping_nm_s_rad, "N·m·s/rad"),
           field("torque", command.torque_nm, "N·m")}};
}

DecodedFrame reply_words(const MitReply& reply, double temperature_offset_c) {
  DecodedFrame words{"MIT reply",
                     {{"motor", fmt::format("{}", reply.motor), ""},
                      field("position", reply.position_rad, "rad"),
                      field("velocity", reply.velocity_rad_s, "rad/s"),
                      field("torque", reply.torque_nm, "N·m")}};
  if (reply.voltage_v) {
    words.fields.push_back(field("bus voltage", *reply.voltage_v, "V"));
  }
  if (reply.temperature_raw) {
    words.fields.push_back(
        field("temperature", *reply.temperature_raw + temperature_offset_c, "°C"));
    words.fields.push_back({"error", error_words(reply.error), ""});
  }
  return words;
}

DecodedFrame servo_words(const ServoCommand& command) {
  switch (command.function) {
    case Function::kDuty:
      return {"servo duty command", {field("duty", command.value, "")}};
    case Function::kCurrent:
      return {"servo current command", {field("current", command.value, "A")}};
    case Function::kBrakeCurrent:
      return {"servo brake command", {field("brake current", command.value, "A")}};
    case Function::kSpeed:
      return {"servo speed command", {field("speed", command.value, "erpm")}};
    case Function::kPosition:
      return {"servo position command", {field("position", command.value, "deg")}};
    default:
      return {"servo set origin",
              {{"kept", command.value != 0.0 ? "for good" : "until power-off", ""}}};
  }
}

std::optional<DecodedFrame> decode_extended(const Frame& frame, const Facts& facts) {
  switch (static_cast<Function>(frame.id >> 8U & 0xFFU)) {
    case Function::kStatus:
      if (const auto status = decode_status(frame)) {
        DecodedFrame words{"servo status",
                           {field("position", status->position_deg, "deg"),
                            field("speed", status->speed_erpm, "erpm"),
                            field("current", status->current_a, "A"),
                            field("temperature", status->temperature_c, "°C"),
                            {"error", error_words(status->error), ""}}};
        if (facts.gear >= 1.0 && facts.torque_per_ampere_nm > 0.0) {
          words.fields.push_back(
              field("position", status->position_deg * facts.radians_per_degree, "rad"));
          words.fields.push_back(
              field("velocity", status->speed_erpm * facts.rad_s_per_erpm, "rad/s"));
          words.fields.push_back(
              field("torque", status->current_a * facts.torque_per_ampere_nm, "N·m"));
        }
        return words;
      }
      return std::nullopt;
    case Function::kServoMode:
      return DecodedFrame{"drive is in servo mode", {}};
    case Function::kStartUp:
      return DecodedFrame{"drive was switched on", {}};
    case Function::kPositionSpeed:
      if (const auto command = decode_position_speed(frame)) {
        return DecodedFrame{"servo position-speed command",
                            {field("position", command->position_deg, "deg"),
                             field("speed", command->speed_erpm, "erpm"),
                             field("acceleration", command->acceleration_erpm_s, "erpm/s")}};
      }
      return std::nullopt;
    default:
      break;
  }
  const auto command = decode_servo(frame);
  return command ? std::optional(servo_words(*command)) : std::nullopt;
}

}  // namespace

std::optional<DecodedFrame> decode(const Frame& frame, const DriveOptions& options) {
  if (frame.error || frame.remote || frame.fd) {
    return std::nullopt;
  }
  const Facts facts(options);
  const Ranges ranges{options.position_range_rad, options.velocity_range_rad_s,
                      options.torque_range_nm};
  if (frame.extended) {
    const bool ours = frame.id >> 16U == 0 && (frame.id & 0xFFU) == options.id;
    return ours ? decode_extended(frame, facts) : std::nullopt;
  }
  const auto reply = decode_reply(frame, ranges);
  if (frame.id == options.reply_id && reply && reply->motor == options.id) {
    return reply_words(*reply, facts.temperature_offset_c);
  }
  if (frame.id != options.id) {
    return std::nullopt;
  }
  if (const auto special = decode_special(frame)) {
    return DecodedFrame{name_of(*special), {}};
  }
  const auto command = decode_mit(frame, ranges);
  return command ? std::optional(command_words(*command)) : std::nullopt;
}

const char* error_name(std::uint8_t code) {
  switch (static_cast<Error>(code)) {
    case Error::kMotorOverTemperature:
      return "motor over-temperature";
    case Error::kOverCurrent:
      return "over-current";
    case Error::kOverVoltage:
      return "over-voltage";
    case Error::kUnderVoltage:
      return "under-voltage";
    case Error::kEncoder:
      return "encoder";
    case Error::kMosfetOverTemperature:
      return "MOSFET over-temperature (older firmware: phase currents unbalanced)";
    case Error::kStall:
      return "stall";
    default:
      return "unknown error";
  }
}

std::vector<std::string> check(const DriveOptions& options) {
  std::vector<std::string> wrong;
  const Facts facts(options);
  if (options.id < 1 || options.id > 0xFF) {
    wrong.push_back(
        fmt::format("the drive's id is 0x{:X}; it must be between 0x01 and 0xFF", options.id));
  }
  if (!facts.servo && options.reply_id > 0x7FE) {
    wrong.push_back(fmt::format(
        "the drive's reply id (host id) is 0x{:X}; it must be at most 0x7FE. Usual: 0 (older "
        "firmware, all drives in common) or the drive's own id (manual of 2026)",
        options.reply_id));
  }
  if (options.fd) {
    wrong.emplace_back("CubeMars drives speak classic CAN only; fd must be off");
  }
  const auto above_zero = [&wrong](const char* what, double value, const char* unit) {
    if (!std::isfinite(value) || value <= 0.0) {
      wrong.push_back(
          fmt::format("the drive's {} is {} {}; it must be above 0", what, value, unit));
    }
  };
  if (!facts.servo) {
    above_zero("position range (12.5 for all current models)", options.position_range_rad, "rad");
  }
  above_zero("velocity range", options.velocity_range_rad_s, "rad/s");
  above_zero("torque range", options.torque_range_nm, "N·m");
  if (!(facts.gear >= 1.0)) {
    wrong.push_back(
        fmt::format("the drive's gear_ratio is {}; it must be at least 1 (AK80-9: 9)", facts.gear));
  }
  if (facts.servo && facts.gear >= 1.0) {
    above_zero("torque_constant_nm_a (servo mode commands current)",
               facts.torque_per_ampere_nm / facts.gear, "N·m/A");
  }
  if (options.watchdog_ns < kLeastWatchdogNs || options.watchdog_ns > kMostWatchdogNs) {
    wrong.push_back(
        fmt::format("the drive's watchdog time is {} ms; it must be between 1 ms and 10 s",
                    static_cast<double>(options.watchdog_ns) * 1e-6));
  }
  return wrong;
}

std::vector<CyclicFrame> cyclic_frames(const DriveOptions& options, double rate_hz) {
  if (Facts(options).servo) {
    return {{.what = "current",
             .id = servo_id(Function::kCurrent, options.id),
             .bytes = 4,
             .extended = true,
             .classic = true},
            {.what = "status",
             .id = servo_id(Function::kStatus, options.id),
             .extended = true,
             .reply = true,
             .share = rate_hz > 0.0 ? kStatusRateHz / rate_hz : 1.0,
             .unasked = true,
             .classic = true}};
  }
  return {{.what = "torque", .id = options.id, .classic = true},
          {.what = "state", .id = options.reply_id, .reply = true, .classic = true}};
}

Family family() {
  return {
      .name = "cubemars",
      .summary = "CubeMars / T-Motor AK series, MIT mode or servo mode, CAN",
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
      .cyclic_frames = cyclic_frames,
      .position_period_rad = position_period_rad,
      .make_scanner = [](bool fd) -> std::unique_ptr<Scanner> {
        return fd ? nullptr : std::make_unique<BusScanner>();
      },
      .make_zeroing = [](const DriveOptions& options) -> std::unique_ptr<Zeroing> {
        return std::make_unique<ZeroSetter>(options);
      },
  };
}

}  // namespace geodesic::drivers::cubemars
