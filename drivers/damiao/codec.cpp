// Damiao frames <-> numbers: the host's arithmetic. See codec.hpp for contracts, README.md for
// sources.
#include "drivers/damiao/codec.hpp"

#include <cmath>
#include <limits>

namespace geodesic::drivers::damiao {

namespace {

constexpr std::uint8_t kLength = 8;

Frame make_frame(std::uint32_t id, bool fd, std::uint8_t length) noexcept {
  Frame frame;
  frame.id = id;
  frame.fd = fd;
  frame.bit_rate_switch = fd;
  frame.length = length;
  return frame;
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

void store_float(Frame& frame, std::size_t at, double value) noexcept {
  store_little(frame, at, std::bit_cast<std::uint32_t>(static_cast<float>(value)), 4);
}

double load_float(const Frame& frame, std::size_t at) noexcept {
  return static_cast<double>(std::bit_cast<float>(load_little(frame, at, 4)));
}

/// A double that no float32 can hold would leave as infinity.
bool fits_float(double value) noexcept {
  return std::abs(value) <= static_cast<double>(std::numeric_limits<float>::max());
}

Frame register_frame(std::uint32_t id, bool fd, Operation operation, std::uint8_t number,
                     std::uint32_t raw) noexcept {
  Frame frame = make_frame(kRegisterId, fd, kLength);
  store_little(frame, 0, id, 2);
  frame.data[2] = static_cast<std::uint8_t>(operation);
  frame.data[3] = number;
  store_little(frame, 4, raw, 4);
  return frame;
}

}  // namespace

std::optional<Frame> encode_mit(std::uint32_t id, bool fd, const MitCommand& command,
                                const Ranges& ranges) noexcept {
  if (!std::isfinite(command.position_rad) || !std::isfinite(command.velocity_rad_s) ||
      !std::isfinite(command.stiffness_nm_rad) || !std::isfinite(command.damping_nm_s_rad) ||
      !std::isfinite(command.torque_nm)) {
    return std::nullopt;
  }
  Frame frame = make_frame(id, fd, kLength);
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
    // One code less of torque could be the next special frame; one less of damping is none, and
    // matters least.
    word -= place(1, mit::kDamping);
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

Frame encode_special(std::uint32_t id, bool fd, Special special) noexcept {
  Frame frame = make_frame(id, fd, kLength);
  store_word(frame, ~std::uint64_t{0} << 8U | static_cast<std::uint8_t>(special));
  return frame;
}

std::optional<Special> decode_special(const Frame& frame) noexcept {
  const std::uint64_t word = load_word(frame);
  const auto last = static_cast<std::uint8_t>(word & 0xFFU);
  if (frame.length != kLength || word >> 8U != ~std::uint64_t{0} >> 8U ||
      last < static_cast<std::uint8_t>(Special::kClearError) ||
      last > static_cast<std::uint8_t>(Special::kSetZero)) {
    return std::nullopt;
  }
  return static_cast<Special>(last);
}

std::optional<StateReport> decode_report(const Frame& frame, const Ranges& ranges) noexcept {
  if (frame.length != kLength) {
    return std::nullopt;
  }
  return StateReport{
      .status = static_cast<std::uint8_t>(extract(frame, report::kStatus)),
      .motor = static_cast<std::uint8_t>(extract(frame, report::kMotor)),
      .position_rad = signed_at(frame, ranges.position_rad, report::kPosition),
      .velocity_rad_s = signed_at(frame, ranges.velocity_rad_s, report::kVelocity),
      .torque_nm = signed_at(frame, ranges.torque_nm, report::kTorque),
      .mosfet_c = static_cast<double>(extract(frame, report::kMosfetTemperature)),
      .rotor_c = static_cast<double>(extract(frame, report::kRotorTemperature)),
  };
}

Frame encode_read(std::uint32_t id, bool fd, std::uint8_t number) noexcept {
  return register_frame(id, fd, Operation::kRead, number, 0);
}

Frame encode_write(std::uint32_t id, bool fd, std::uint8_t number, std::uint32_t raw) noexcept {
  return register_frame(id, fd, Operation::kWrite, number, raw);
}

Frame encode_save(std::uint32_t id, bool fd) noexcept {
  return register_frame(id, fd, Operation::kSave, 0, 0);
}

Frame encode_state_request(std::uint32_t id, bool fd) noexcept {
  return register_frame(id, fd, Operation::kState, 0, 0);
}

std::optional<RegisterFrame> decode_register(const Frame& frame) noexcept {
  if (frame.length != kLength) {
    return std::nullopt;
  }
  return RegisterFrame{.id = static_cast<std::uint16_t>(load_little(frame, 0, 2)),
                       .operation = frame.data[2],
                       .number = frame.data[3],
                       .raw = load_little(frame, 4, 4)};
}

std::optional<Frame> encode_position_velocity(std::uint32_t id, bool fd,
                                              const PositionVelocityCommand& command) noexcept {
  if (!fits_float(command.position_rad) || !fits_float(command.velocity_limit_rad_s)) {
    return std::nullopt;
  }
  Frame frame = make_frame(command_id(id, ControlMode::kPositionVelocity), fd, kLength);
  store_float(frame, 0, command.position_rad);
  store_float(frame, 4, command.velocity_limit_rad_s);
  return frame;
}

std::optional<PositionVelocityCommand> decode_position_velocity(const Frame& frame) noexcept {
  const PositionVelocityCommand command{load_float(frame, 0), load_float(frame, 4)};
  if (frame.length != kLength || !fits_float(command.position_rad) ||
      !fits_float(command.velocity_limit_rad_s)) {
    return std::nullopt;
  }
  return command;
}

std::optional<Frame> encode_velocity(std::uint32_t id, bool fd, double velocity_rad_s) noexcept {
  if (!fits_float(velocity_rad_s)) {
    return std::nullopt;
  }
  Frame frame = make_frame(command_id(id, ControlMode::kVelocity), fd, 4);
  store_float(frame, 0, velocity_rad_s);
  return frame;
}

std::optional<double> decode_velocity(const Frame& frame) noexcept {
  const double velocity_rad_s = load_float(frame, 0);
  if ((frame.length != 4 && frame.length != kLength) || !fits_float(velocity_rad_s)) {
    return std::nullopt;
  }
  return velocity_rad_s;
}

std::optional<Frame> encode_position_force(std::uint32_t id, bool fd,
                                           const PositionForceCommand& command) noexcept {
  if (!fits_float(command.position_rad) || !std::isfinite(command.velocity_limit_rad_s) ||
      !std::isfinite(command.current_limit)) {
    return std::nullopt;
  }
  Frame frame = make_frame(command_id(id, ControlMode::kPositionForce), fd, kLength);
  store_float(frame, 0, command.position_rad);
  const auto counts = [](double value, double scale) {
    const double scaled = value * scale + 0.5;
    return static_cast<std::uint32_t>(scaled < 0.0 ? 0.0 : (scaled > 10000.0 ? 10000.0 : scaled));
  };
  store_little(frame, 4, counts(command.velocity_limit_rad_s, 100.0), 2);
  store_little(frame, 6, counts(command.current_limit, 10000.0), 2);
  return frame;
}

std::optional<PositionForceCommand> decode_position_force(const Frame& frame) noexcept {
  const double position_rad = load_float(frame, 0);
  if (frame.length != kLength || !fits_float(position_rad)) {
    return std::nullopt;
  }
  return PositionForceCommand{position_rad, load_little(frame, 4, 2) / 100.0,
                              load_little(frame, 6, 2) / 10000.0};
}

}  // namespace geodesic::drivers::damiao
