// CubeMars frames <-> numbers: the host's arithmetic. See codec.hpp for contracts, README.md for
// sources.
#include "drivers/cubemars/codec.hpp"

#include <cmath>
#include <limits>

namespace geodesic::drivers::cubemars {

namespace {

constexpr std::uint8_t kLength = 8;

/// Rounded to the nearest count and kept within what `Integer` holds.
template <class Integer>
Integer counts(double value, double unit) noexcept {
  const double exact = std::round(value / unit);
  constexpr auto kLeast = static_cast<double>(std::numeric_limits<Integer>::min());
  constexpr auto kMost = static_cast<double>(std::numeric_limits<Integer>::max());
  return static_cast<Integer>(exact < kLeast ? kLeast : (exact > kMost ? kMost : exact));
}

void store_big(Frame& frame, std::size_t at, std::uint32_t value, std::size_t bytes) noexcept {
  for (std::size_t i = 0; i < bytes; ++i) {
    frame.data[at + i] = static_cast<std::uint8_t>(value >> (8U * (bytes - 1U - i)) & 0xFFU);
  }
}

std::int32_t load_int32(const Frame& frame, std::size_t at) noexcept {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    value = value << 8U | frame.data[at + i];
  }
  return static_cast<std::int32_t>(value);
}

std::int16_t load_int16(const Frame& frame, std::size_t at) noexcept {
  return static_cast<std::int16_t>(static_cast<std::uint16_t>(frame.data[at] << 8U) |
                                   frame.data[at + 1]);
}

Frame servo_frame(Function function, std::uint32_t motor, std::uint8_t length) noexcept {
  Frame frame;
  frame.id = servo_id(function, motor);
  frame.extended = true;
  frame.length = length;
  return frame;
}

/// Of one count of a command's int32; 0: the function has another form.
double unit_of(Function function) noexcept {
  switch (function) {
    case Function::kDuty:
      return servo::kDutyUnit;
    case Function::kCurrent:
    case Function::kBrakeCurrent:
      return servo::kCurrentUnit;
    case Function::kSpeed:
      return servo::kSpeedUnit;
    case Function::kPosition:
      return servo::kPositionUnit;
    default:
      return 0.0;
  }
}

}  // namespace

std::optional<Frame> encode_mit(std::uint32_t id, const MitCommand& command,
                                const Ranges& ranges) noexcept {
  if (!std::isfinite(command.position_rad) || !std::isfinite(command.velocity_rad_s) ||
      !std::isfinite(command.stiffness_nm_rad) || !std::isfinite(command.damping_nm_s_rad) ||
      !std::isfinite(command.torque_nm)) {
    return std::nullopt;
  }
  Frame frame;
  frame.id = id;
  frame.length = kLength;
  std::uint64_t word =
      place_signed(command.position_rad, ranges.position_rad, mit::kPosition) |
      place_signed(command.velocity_rad_s, ranges.velocity_rad_s, mit::kVelocity) |
      place_signed(command.torque_nm, ranges.torque_nm, mit::kTorque) |
      place(to_code(command.stiffness_nm_rad, 0.0, mit::kMaxStiffness, mit::kStiffness.bits),
            mit::kStiffness) |
      place(to_code(command.damping_nm_s_rad, 0.0, mit::kMaxDamping, mit::kDamping.bits),
            mit::kDamping);
  store_word(frame, word);
  if (decode_special(frame)) {
    word -= place(1, mit::kDamping);  // the torque stays what was asked for
    store_word(frame, word);
  }
  return frame;
}

std::optional<MitCommand> decode_mit(const Frame& frame, const Ranges& ranges) noexcept {
  if (frame.length != kLength || decode_special(frame)) {
    return std::nullopt;
  }
  return MitCommand{
      .position_rad = signed_at(frame, ranges.position_rad, mit::kPosition),
      .velocity_rad_s = signed_at(frame, ranges.velocity_rad_s, mit::kVelocity),
      .stiffness_nm_rad =
          from_code(extract(frame, mit::kStiffness), 0.0, mit::kMaxStiffness, mit::kStiffness.bits),
      .damping_nm_s_rad =
          from_code(extract(frame, mit::kDamping), 0.0, mit::kMaxDamping, mit::kDamping.bits),
      .torque_nm = signed_at(frame, ranges.torque_nm, mit::kTorque),
  };
}

Frame encode_special(std::uint32_t id, Special special) noexcept {
  Frame frame;
  frame.id = id;
  frame.length = kLength;
  store_word(frame, ~std::uint64_t{0} << 8U | static_cast<std::uint8_t>(special));
  return frame;
}

std::optional<Special> decode_special(const Frame& frame) noexcept {
  const std::uint64_t word = load_word(frame);
  const auto last = static_cast<std::uint8_t>(word & 0xFFU);
  if (frame.length != kLength || word >> 8U != ~std::uint64_t{0} >> 8U ||
      last < static_cast<std::uint8_t>(Special::kEnter) ||
      last > static_cast<std::uint8_t>(Special::kSetZero)) {
    return std::nullopt;
  }
  return static_cast<Special>(last);
}

std::optional<MitReply> decode_reply(const Frame& frame, const Ranges& ranges) noexcept {
  if (frame.length < reply::kShort || frame.length > reply::kWithError) {
    return std::nullopt;
  }
  MitReply decoded{
      .motor = static_cast<std::uint8_t>(extract(frame, reply::kMotor)),
      .position_rad = signed_at(frame, ranges.position_rad, reply::kPosition),
      .velocity_rad_s = signed_at(frame, ranges.velocity_rad_s, reply::kVelocity),
      .torque_nm = signed_at(frame, ranges.torque_nm, reply::kTorque),
  };
  if (frame.length == reply::kWithVoltage) {
    decoded.voltage_v =
        from_code(extract(frame, reply::kVoltage), 0.0, reply::kMaxVoltage, reply::kVoltage.bits);
  } else if (frame.length == reply::kWithError) {
    decoded.temperature_raw = static_cast<std::uint8_t>(extract(frame, reply::kTemperature));
    decoded.error = static_cast<std::uint8_t>(extract(frame, reply::kError));
  }
  return decoded;
}

std::optional<Frame> encode_servo(std::uint32_t motor, const ServoCommand& command) noexcept {
  if (!std::isfinite(command.value)) {
    return std::nullopt;
  }
  if (command.function == Function::kOrigin) {
    Frame frame = servo_frame(command.function, motor, 1);
    frame.data[0] = command.value != 0.0 ? servo::kPermanent : std::uint8_t{0};
    return frame;
  }
  const double unit = unit_of(command.function);
  if (unit == 0.0) {
    return std::nullopt;
  }
  Frame frame = servo_frame(command.function, motor, 4);
  store_big(frame, 0, static_cast<std::uint32_t>(counts<std::int32_t>(command.value, unit)), 4);
  return frame;
}

std::optional<ServoCommand> decode_servo(const Frame& frame) noexcept {
  const std::uint32_t number = frame.id >> 8U;
  if (!frame.extended || number > static_cast<std::uint32_t>(Function::kOrigin)) {
    return std::nullopt;
  }
  const auto function = static_cast<Function>(number);
  if (function == Function::kOrigin && frame.length == 1) {
    return ServoCommand{function, static_cast<double>(frame.data[0])};
  }
  const double unit = unit_of(function);
  if (unit == 0.0 || frame.length != 4) {
    return std::nullopt;
  }
  return ServoCommand{function, static_cast<double>(load_int32(frame, 0)) * unit};
}

std::optional<Frame> encode_position_speed(std::uint32_t motor,
                                           const PositionSpeedCommand& command) noexcept {
  if (!std::isfinite(command.position_deg) || !std::isfinite(command.speed_erpm) ||
      !std::isfinite(command.acceleration_erpm_s)) {
    return std::nullopt;
  }
  const auto short_counts = [](double value) {
    const auto count = counts<std::int16_t>(value, servo::kProfileSpeedUnit);
    return static_cast<std::uint32_t>(static_cast<std::uint16_t>(count));
  };
  Frame frame = servo_frame(Function::kPositionSpeed, motor, kLength);
  store_big(
      frame, 0,
      static_cast<std::uint32_t>(counts<std::int32_t>(command.position_deg, servo::kPositionUnit)),
      4);
  store_big(frame, 4, short_counts(command.speed_erpm), 2);
  store_big(frame, 6, short_counts(command.acceleration_erpm_s), 2);
  return frame;
}

std::optional<PositionSpeedCommand> decode_position_speed(const Frame& frame) noexcept {
  if (!frame.extended || frame.length != kLength ||
      frame.id >> 8U != static_cast<std::uint32_t>(Function::kPositionSpeed)) {
    return std::nullopt;
  }
  return PositionSpeedCommand{load_int32(frame, 0) * servo::kPositionUnit,
                              load_int16(frame, 4) * servo::kProfileSpeedUnit,
                              load_int16(frame, 6) * servo::kProfileSpeedUnit};
}

std::optional<ServoStatus> decode_status(const Frame& frame) noexcept {
  if (frame.length != kLength) {
    return std::nullopt;
  }
  return ServoStatus{.position_deg = load_int16(frame, 0) * servo::kStatusPositionUnit,
                     .speed_erpm = load_int16(frame, 2) * servo::kStatusSpeedUnit,
                     .current_a = load_int16(frame, 4) * servo::kStatusCurrentUnit,
                     .temperature_c = static_cast<double>(static_cast<std::int8_t>(frame.data[6])),
                     .error = frame.data[7]};
}

}  // namespace geodesic::drivers::cubemars
