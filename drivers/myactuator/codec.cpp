// MyActuator frames <-> numbers: the host's arithmetic. See codec.hpp for contracts, README.md for
// sources.
#include "drivers/myactuator/codec.hpp"

#include <bit>
#include <cmath>
#include <limits>

#include "drivers/myactuator/settings.hpp"

namespace geodesic::drivers::myactuator {

namespace {

/// Rounded to the nearest count and kept within what `Integer` holds.
template <class Integer>
Integer counts(double value, double unit) noexcept {
  const double exact = std::round(value / unit);
  constexpr auto kLeast = static_cast<double>(std::numeric_limits<Integer>::min());
  constexpr auto kMost = static_cast<double>(std::numeric_limits<Integer>::max());
  return static_cast<Integer>(exact < kLeast ? kLeast : (exact > kMost ? kMost : exact));
}

void store_little(Frame& frame, std::size_t at, std::uint32_t value, std::size_t bytes) noexcept {
  for (std::size_t i = 0; i < bytes; ++i) {
    frame.data[at + i] = static_cast<std::uint8_t>(value >> (8U * i) & 0xFFU);
  }
}

std::uint32_t load_little(const Frame& frame, std::size_t at, std::size_t bytes) noexcept {
  std::uint32_t value = 0;
  for (std::size_t i = bytes; i-- > 0;) {
    value = value << 8U | frame.data[at + i];
  }
  return value;
}

double int16_at(const Frame& frame, std::size_t at) noexcept {
  return static_cast<double>(static_cast<std::int16_t>(load_little(frame, at, 2)));
}

double int32_at(const Frame& frame, std::size_t at) noexcept {
  return static_cast<double>(static_cast<std::int32_t>(load_little(frame, at, 4)));
}

double int8_at(const Frame& frame, std::size_t at) noexcept {
  return static_cast<double>(static_cast<std::int8_t>(frame.data[at]));
}

Frame frame_of(std::uint32_t id) noexcept {
  Frame frame;
  frame.id = id;
  frame.length = kLength;
  return frame;
}

bool is(const Frame& frame, Command command) noexcept {
  return frame.length == kLength && frame.data[0] == static_cast<std::uint8_t>(command);
}

}  // namespace

Ranges ranges_of(const DriveOptions& options) noexcept {
  return {.position_rad = options.position_range_rad,
          .velocity_rad_s = options.velocity_range_rad_s,
          .torque_nm = options.torque_range_nm,
          .stiffness_nm_rad = Facts::get(options, kStiffnessRange),
          .damping_nm_s_rad = Facts::get(options, kDampingRange)};
}

Frame encode_request(std::uint32_t motor, Command command) noexcept {
  Frame frame = frame_of(kRequestId + motor);
  frame.data[0] = static_cast<std::uint8_t>(command);
  return frame;
}

Frame encode_value(std::uint32_t motor, Command command, std::uint32_t value,
                   std::uint8_t index) noexcept {
  Frame frame = encode_request(motor, command);
  frame.data[1] = index;
  store_little(frame, kValueAt, value, 4);
  return frame;
}

std::optional<Frame> encode_torque(std::uint32_t motor, double current_a) noexcept {
  if (!std::isfinite(current_a)) {
    return std::nullopt;
  }
  Frame frame = encode_request(motor, Command::kTorque);
  const auto code = static_cast<std::uint16_t>(counts<std::int16_t>(current_a, kCurrentUnit));
  store_little(frame, kValueAt, code, 2);
  return frame;
}

std::optional<Frame> encode_speed(std::uint32_t motor, double speed_deg_s) noexcept {
  if (!std::isfinite(speed_deg_s)) {
    return std::nullopt;
  }
  return encode_value(motor, Command::kSpeed,
                      static_cast<std::uint32_t>(counts<std::int32_t>(speed_deg_s, kSpeedUnit)));
}

std::optional<Frame> encode_position(std::uint32_t motor, const PositionCommand& command) noexcept {
  if (!std::isfinite(command.angle_deg) || !std::isfinite(command.speed_limit_deg_s)) {
    return std::nullopt;
  }
  Frame frame =
      encode_value(motor, Command::kPosition,
                   static_cast<std::uint32_t>(counts<std::int32_t>(command.angle_deg, kAngleUnit)));
  store_little(frame, kSpeedLimitAt, counts<std::uint16_t>(command.speed_limit_deg_s, 1.0), 2);
  return frame;
}

std::optional<Frame> encode_motion(std::uint32_t motor, const MotionCommand& command,
                                   const Ranges& ranges) noexcept {
  if (!std::isfinite(command.position_rad) || !std::isfinite(command.velocity_rad_s) ||
      !std::isfinite(command.stiffness_nm_rad) || !std::isfinite(command.damping_nm_s_rad) ||
      !std::isfinite(command.torque_nm)) {
    return std::nullopt;
  }
  Frame frame = frame_of(kMotionRequestId + motor);
  store_word(frame,
             place_signed(command.position_rad, ranges.position_rad, motion::kPosition) |
                 place_signed(command.velocity_rad_s, ranges.velocity_rad_s, motion::kVelocity) |
                 place_signed(command.torque_nm, ranges.torque_nm, motion::kTorque) |
                 place(to_code(command.stiffness_nm_rad, 0.0, ranges.stiffness_nm_rad,
                               motion::kStiffness.bits),
                       motion::kStiffness) |
                 place(to_code(command.damping_nm_s_rad, 0.0, ranges.damping_nm_s_rad,
                               motion::kDamping.bits),
                       motion::kDamping));
  return frame;
}

std::optional<std::uint8_t> command_of(const Frame& frame) noexcept {
  return frame.length == kLength ? std::optional(frame.data[0]) : std::nullopt;
}

std::optional<double> decode_torque(const Frame& frame) noexcept {
  return is(frame, Command::kTorque) ? std::optional(int16_at(frame, kValueAt) * kCurrentUnit)
                                     : std::nullopt;
}

std::optional<double> decode_speed(const Frame& frame) noexcept {
  return is(frame, Command::kSpeed) ? std::optional(int32_at(frame, kValueAt) * kSpeedUnit)
                                    : std::nullopt;
}

std::optional<PositionCommand> decode_position(const Frame& frame) noexcept {
  if (!is(frame, Command::kPosition)) {
    return std::nullopt;
  }
  return PositionCommand{int32_at(frame, kValueAt) * kAngleUnit,
                         static_cast<double>(load_little(frame, kSpeedLimitAt, 2))};
}

std::optional<LoopReply> decode_loop_reply(const Frame& frame) noexcept {
  if (!is(frame, Command::kTorque) && !is(frame, Command::kSpeed) &&
      !is(frame, Command::kPosition) && !is(frame, Command::kStatus2)) {
    return std::nullopt;
  }
  return LoopReply{.temperature_c = int8_at(frame, kTemperatureAt),
                   .current_a = int16_at(frame, kCurrentAt) * kCurrentUnit,
                   .speed_deg_s = int16_at(frame, kSpeedAt),
                   .angle_deg = int16_at(frame, kAngleAt)};
}

std::optional<Status1> decode_status1(const Frame& frame) noexcept {
  if (!is(frame, Command::kStatus1)) {
    return std::nullopt;
  }
  return Status1{.motor_c = int8_at(frame, kTemperatureAt),
                 .mosfet_c = int8_at(frame, kMosfetTemperatureAt),
                 .brake_released = frame.data[kBrakeAt] != 0,
                 .voltage_v = load_little(frame, kVoltageAt, 2) * kVoltageUnit,
                 .errors = static_cast<std::uint16_t>(load_little(frame, kErrorsAt, 2))};
}

std::optional<Status3> decode_status3(const Frame& frame) noexcept {
  if (!is(frame, Command::kStatus3)) {
    return std::nullopt;
  }
  return Status3{.temperature_c = int8_at(frame, kTemperatureAt),
                 .current_a = {int16_at(frame, 2) * kCurrentUnit, int16_at(frame, 4) * kCurrentUnit,
                               int16_at(frame, 6) * kCurrentUnit}};
}

std::optional<double> decode_angle(const Frame& frame) noexcept {
  return is(frame, Command::kAngle) ? std::optional(int32_at(frame, kValueAt) * kAngleUnit)
                                    : std::nullopt;
}

std::uint32_t decode_value(const Frame& frame) noexcept {
  return load_little(frame, kValueAt, 4);
}

std::optional<MotionCommand> decode_motion(const Frame& frame, const Ranges& ranges) noexcept {
  if (frame.length != kLength) {
    return std::nullopt;
  }
  return MotionCommand{
      .position_rad = signed_at(frame, ranges.position_rad, motion::kPosition),
      .velocity_rad_s = signed_at(frame, ranges.velocity_rad_s, motion::kVelocity),
      .stiffness_nm_rad = from_code(extract(frame, motion::kStiffness), 0.0,
                                    ranges.stiffness_nm_rad, motion::kStiffness.bits),
      .damping_nm_s_rad = from_code(extract(frame, motion::kDamping), 0.0, ranges.damping_nm_s_rad,
                                    motion::kDamping.bits),
      .torque_nm = signed_at(frame, ranges.torque_nm, motion::kTorque),
  };
}

std::optional<MotionReply> decode_motion_reply(const Frame& frame, const Ranges& ranges) noexcept {
  if (frame.length != kLength) {
    return std::nullopt;
  }
  return MotionReply{
      .motor = static_cast<std::uint8_t>(extract(frame, motion::kReplyMotor)),
      .position_rad = signed_at(frame, ranges.position_rad, motion::kReplyPosition),
      .velocity_rad_s = signed_at(frame, ranges.velocity_rad_s, motion::kReplyVelocity),
      .torque_nm = signed_at(frame, ranges.torque_nm, motion::kReplyTorque),
  };
}

bool is_bare(const Frame& frame) noexcept {
  for (std::size_t i = 1; i < kLength; ++i) {
    if (frame.data[i] != 0) {
      return false;
    }
  }
  return true;
}

std::uint8_t error_code(std::uint16_t errors) noexcept {
  return errors == 0 ? std::uint8_t{0} : static_cast<std::uint8_t>(std::countr_zero(errors) + 1);
}

}  // namespace geodesic::drivers::myactuator
