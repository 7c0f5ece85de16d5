// The MyActuator family for people: checks of options, names of errors, frames in words. See
// family.hpp.
#include "drivers/myactuator/family.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "drivers/myactuator/bench.hpp"
#include "drivers/myactuator/codec.hpp"
#include "drivers/myactuator/driver.hpp"
#include "drivers/myactuator/settings.hpp"
#include "drivers/myactuator/simulated.hpp"

namespace geodesic::drivers::myactuator {

namespace {

constexpr std::int64_t kLeastWatchdogNs = 1'000'000;
constexpr std::int64_t kMostWatchdogNs = 10'000'000'000;

DecodedField field(std::string name, double value, std::string unit) {
  return {std::move(name), fmt::format("{:.6g}", value), std::move(unit)};
}

const char* name_of(std::uint8_t command) {
  switch (static_cast<Command>(command)) {
    case Command::kFunction:
      return "function";
    case Command::kZeroHere:
      return "zero here";
    case Command::kPower:
      return "power";
    case Command::kReset:
      return "reset";
    case Command::kReleaseBrake:
      return "release brake";
    case Command::kLockBrake:
      return "lock brake";
    case Command::kShutdown:
      return "shut down";
    case Command::kStop:
      return "stop";
    case Command::kAngle:
      return "multi-turn angle";
    case Command::kStatus1:
      return "status 1";
    case Command::kStatus2:
      return "status 2";
    case Command::kStatus3:
      return "status 3";
    case Command::kTorque:
      return "torque";
    case Command::kSpeed:
      return "speed";
    case Command::kPosition:
      return "position";
    case Command::kRunTime:
      return "run time";
    case Command::kVersion:
      return "version";
    case Command::kWatchdog:
      return "watchdog time";
    case Command::kModel:
      return "model";
    case Command::kWatchdogExpired:
      return "watchdog expired";
  }
  return nullptr;
}

std::string kind_of(std::uint8_t command, const char* side) {
  const char* name = name_of(command);
  return name != nullptr ? fmt::format("{} {}", name, side)
                         : fmt::format("command 0x{:02X} {}", command, side);
}

DecodedFrame request_words(const Frame& frame, const Facts& facts) {
  DecodedFrame words{kind_of(frame.data[0], "request"), {}};
  if (const auto current = decode_torque(frame)) {
    words.fields.push_back(field("current", *current, "A"));
    if (facts.torque_per_ampere_nm > 0.0) {
      words.fields.push_back(field("torque", *current * facts.torque_per_ampere_nm, "N·m"));
    }
  } else if (const auto speed = decode_speed(frame)) {
    words.fields.push_back(field("speed", *speed, "deg/s"));
  } else if (const auto position = decode_position(frame)) {
    words.fields.push_back(field("angle", position->angle_deg, "deg"));
    words.fields.push_back(field("speed limit", position->speed_limit_deg_s, "deg/s"));
  } else if (frame.data[0] == static_cast<std::uint8_t>(Command::kWatchdog)) {
    words.fields.push_back({"time", fmt::format("{}", decode_value(frame)), "ms"});
  } else if (frame.data[0] == static_cast<std::uint8_t>(Command::kFunction)) {
    words.fields.push_back({"index", fmt::format("{}", frame.data[1]), ""});
    words.fields.push_back({"value", fmt::format("{}", decode_value(frame)), ""});
  }
  return words;
}

std::string error_words(std::uint16_t errors) {
  std::string words;
  for (std::uint8_t code = 1; code <= 16; ++code) {
    if ((errors >> (code - 1U) & 1U) != 0U) {
      words += words.empty() ? "" : ", ";
      words += error_name(code);
    }
  }
  return words.empty() ? "none" : words;
}

DecodedFrame reply_words(const Frame& frame, const Facts& facts) {
  DecodedFrame words{kind_of(frame.data[0], "reply"), {}};
  if (const auto loop = decode_loop_reply(frame)) {
    words.fields = {
        field("temperature", loop->temperature_c, "°C"), field("current", loop->current_a, "A"),
        field("speed", loop->speed_deg_s, "deg/s"), field("angle", loop->angle_deg, "deg")};
    if (facts.torque_per_ampere_nm > 0.0) {
      words.fields.push_back(field("torque", loop->current_a * facts.torque_per_ampere_nm, "N·m"));
    }
  } else if (const auto status = decode_status1(frame)) {
    words.fields = {field("motor temperature", status->motor_c, "°C"),
                    field("MOSFET temperature", status->mosfet_c, "°C"),
                    {"brake", status->brake_released ? "released" : "locked", ""},
                    field("supply", status->voltage_v, "V"),
                    {"errors", error_words(status->errors), ""}};
  } else if (const auto currents = decode_status3(frame)) {
    words.fields = {field("temperature", currents->temperature_c, "°C"),
                    field("phase a", currents->current_a[0], "A"),
                    field("phase b", currents->current_a[1], "A"),
                    field("phase c", currents->current_a[2], "A")};
  } else if (const auto angle = decode_angle(frame)) {
    words.fields = {field("angle", *angle, "deg"), field("position", *angle * kDegree, "rad")};
  } else if (frame.data[0] == static_cast<std::uint8_t>(Command::kWatchdog)) {
    words.fields = {{"time", fmt::format("{}", decode_value(frame)), "ms"}};
  } else if (frame.data[0] == static_cast<std::uint8_t>(Command::kVersion)) {
    words.fields = {{"date", fmt::format("{}", decode_value(frame)), ""}};
  }
  return words;
}

std::optional<DecodedFrame> decode_motion_frame(const Frame& frame, const DriveOptions& options) {
  const Ranges ranges = ranges_of(options);
  if (frame.id == kMotionRequestId + options.id) {
    const MotionCommand command = decode_motion(frame, ranges).value_or(MotionCommand{});
    return DecodedFrame{"motion command",
                        {field("position", command.position_rad, "rad"),
                         field("velocity", command.velocity_rad_s, "rad/s"),
                         field("stiffness", command.stiffness_nm_rad, "N·m/rad"),
                         field("damping", command.damping_nm_s_rad, "N·m·s/rad"),
                         field("torque", command.torque_nm, "N·m")}};
  }
  if (frame.id == kMotionReplyId + options.id && frame.data[0] == options.id) {
    const MotionReply reply = decode_motion_reply(frame, ranges).value_or(MotionReply{});
    return DecodedFrame{"motion reply",
                        {field("position", reply.position_rad, "rad"),
                         field("velocity", reply.velocity_rad_s, "rad/s"),
                         field("torque", reply.torque_nm, "N·m")}};
  }
  return std::nullopt;
}

}  // namespace

std::optional<DecodedFrame> decode(const Frame& frame, const DriveOptions& options) {
  if (frame.error || frame.remote || frame.fd || frame.extended || frame.length != kLength) {
    return std::nullopt;
  }
  const Facts facts(options);
  if (frame.id == kRequestId + options.id || frame.id == kBroadcastId) {
    return request_words(frame, facts);
  }
  if (frame.id == kReplyId + options.id) {
    return reply_words(frame, facts);
  }
  return decode_motion_frame(frame, options);
}

const char* error_name(std::uint8_t code) {
  switch (static_cast<Error>(code >= 1 && code <= 16 ? 1U << (code - 1U) : 0U)) {
    case Error::kStall:
      return "stall";
    case Error::kUnderVoltage:
      return "under-voltage";
    case Error::kOverVoltage:
      return "over-voltage";
    case Error::kOverCurrent:
      return "phase over-current";
    case Error::kPowerOverrun:
      return "power overrun";
    case Error::kCalibrationWrite:
      return "calibration parameters could not be written";
    case Error::kOverSpeed:
      return "over-speed";
    case Error::kBoardOverTemperature:
      return "board over-temperature";
    case Error::kMotorOverTemperature:
      return "motor over-temperature";
    case Error::kEncoderCalibration:
      return "encoder calibration";
    case Error::kEncoderData:
      return "encoder data";
  }
  return "unknown error";
}

std::vector<std::string> check(const DriveOptions& options) {
  std::vector<std::string> wrong;
  const Facts facts(options);
  if (options.id < 1 || options.id > kLastMotor) {
    wrong.push_back(fmt::format(
        "the drive's id is 0x{:X}; it must be the motor's number, 1 to 32 (0x140 and the like are "
        "added to it)",
        options.id));
  } else if (options.reply_id != 0 && options.reply_id != kReplyId + options.id) {
    wrong.push_back(fmt::format(
        "the drive's reply id is 0x{:X}; motor {} answers on 0x{:X} (protocol V3 or V4): leave it "
        "out",
        options.reply_id, options.id, kReplyId + options.id));
  }
  if (options.fd) {
    wrong.emplace_back("MyActuator drives speak classic CAN only; fd must be off");
  }
  const auto above_zero = [&wrong](const char* what, double value, const char* unit) {
    if (!std::isfinite(value) || value <= 0.0) {
      wrong.push_back(
          fmt::format("the drive's {} is {} {}; it must be above 0", what, value, unit));
    }
  };
  above_zero("velocity range", options.velocity_range_rad_s, "rad/s");
  above_zero("torque range", options.torque_range_nm, "N·m");
  if (facts.motion) {
    above_zero("position range (12.5, or 12.566 since protocol V4.4)", options.position_range_rad,
               "rad");
  } else {
    above_zero("torque_constant_nm_a (0xA1 commands current)", facts.torque_per_ampere_nm, "N·m/A");
  }
  if (options.watchdog_ns < kLeastWatchdogNs || options.watchdog_ns > kMostWatchdogNs) {
    wrong.push_back(
        fmt::format("the drive's watchdog time is {} ms; it must be between 1 ms and 10 s",
                    static_cast<double>(options.watchdog_ns) * 1e-6));
  }
  return wrong;
}

std::vector<CyclicFrame> cyclic_frames(const DriveOptions& options, double rate_hz) {
  const double status = 1e9 / static_cast<double>(Driver::kStatusIntervalNs);
  const double share = rate_hz > status ? status / rate_hz : 1.0;
  const std::uint32_t request = kRequestId + options.id;
  const std::uint32_t reply = kReplyId + options.id;
  if (Facts(options).motion) {
    return {{.what = "motion", .id = kMotionRequestId + options.id, .classic = true},
            {.what = "ask errors", .id = request, .share = share, .classic = true},
            {.what = "state", .id = kMotionReplyId + options.id, .reply = true, .classic = true},
            {.what = "errors", .id = reply, .reply = true, .share = share, .classic = true}};
  }
  return {{.what = "current", .id = request, .classic = true},
          {.what = "ask angle", .id = request, .classic = true},
          {.what = "ask errors", .id = request, .share = share, .classic = true},
          {.what = "state", .id = reply, .reply = true, .classic = true},
          {.what = "angle", .id = reply, .reply = true, .classic = true},
          {.what = "errors", .id = reply, .reply = true, .share = share, .classic = true}};
}

Family family() {
  return {
      .name = "myactuator",
      .summary = "MyActuator RMD-X, protocol V3 and V4, by current (0xA1) or in motion mode, CAN",
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
      .position_period_rad =
          [](const DriveOptions& options) { return Facts(options).power_on_period_rad; },
      .make_scanner = [](bool fd) -> std::unique_ptr<Scanner> {
        return fd ? nullptr : std::make_unique<BusScanner>();
      },
      .make_zeroing = [](const DriveOptions& options) -> std::unique_ptr<Zeroing> {
        return std::make_unique<ZeroSetter>(options);
      },
  };
}

}  // namespace geodesic::drivers::myactuator
