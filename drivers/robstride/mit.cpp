// RobStride's MIT protocol, frames <-> numbers; see mit.hpp.
#include "drivers/robstride/mit.hpp"

#include <cmath>

namespace geodesic::drivers::robstride {

namespace {

std::uint64_t code(double value, double low, double high, unsigned bits) noexcept {
  const double clamped = value < low ? low : (value > high ? high : value);
  const auto top = static_cast<double>((1U << bits) - 1U);
  return static_cast<std::uint64_t>(std::lround((clamped - low) / (high - low) * top));
}

double value(std::uint64_t word, unsigned shift, unsigned bits, double low, double high) noexcept {
  const std::uint64_t top = (1U << bits) - 1U;
  return static_cast<double>(word >> shift & top) / static_cast<double>(top) * (high - low) + low;
}

std::uint64_t word_of(const Frame& frame) noexcept {
  std::uint64_t word = 0;
  for (unsigned i = 0; i < 8; ++i) {
    word = word << 8U | frame.data[i];
  }
  return word;
}

/// Six bytes FF and a last one of F8 to FE; the seventh is the argument of some.
bool is_special(std::uint64_t word) noexcept {
  return word >> 16U == ~std::uint64_t{0} >> 16U && (word & 0xFFU) >= 0xF8U &&
         (word & 0xFFU) < 0xFFU;
}

}  // namespace

std::optional<Frame> encode_mit(std::uint8_t motor, const ControlCommand& command,
                                const Ranges& ranges) noexcept {
  if (!std::isfinite(command.position_rad) || !std::isfinite(command.velocity_rad_s) ||
      !std::isfinite(command.stiffness_nm_rad) || !std::isfinite(command.damping_nm_s_rad) ||
      !std::isfinite(command.torque_nm)) {
    return std::nullopt;
  }
  std::uint64_t word =
      code(command.position_rad, -ranges.position_rad, ranges.position_rad, 16) << 48U |
      code(command.velocity_rad_s, -ranges.velocity_rad_s, ranges.velocity_rad_s, 12) << 36U |
      code(command.stiffness_nm_rad, 0.0, ranges.stiffness_nm_rad, 12) << 24U |
      code(command.damping_nm_s_rad, 0.0, ranges.damping_nm_s_rad, 12) << 12U |
      code(command.torque_nm, -ranges.torque_nm, ranges.torque_nm, 12);
  word -= is_special(word) ? std::uint64_t{1} << 24U : 0U;
  Frame frame;
  frame.id = motor;
  frame.length = 8;
  for (unsigned i = 0; i < 8; ++i) {
    frame.data[i] = static_cast<std::uint8_t>(word >> (56U - 8U * i) & 0xFFU);
  }
  return frame;
}

std::optional<ControlCommand> decode_mit(const Frame& frame, const Ranges& ranges) noexcept {
  const std::uint64_t word = word_of(frame);
  if (frame.length != 8 || frame.extended || is_special(word)) {
    return std::nullopt;
  }
  return ControlCommand{
      .position_rad = value(word, 48, 16, -ranges.position_rad, ranges.position_rad),
      .velocity_rad_s = value(word, 36, 12, -ranges.velocity_rad_s, ranges.velocity_rad_s),
      .stiffness_nm_rad = value(word, 24, 12, 0.0, ranges.stiffness_nm_rad),
      .damping_nm_s_rad = value(word, 12, 12, 0.0, ranges.damping_nm_s_rad),
      .torque_nm = value(word, 0, 12, -ranges.torque_nm, ranges.torque_nm)};
}

std::optional<MitReply> decode_mit_reply(const Frame& frame, const Ranges& ranges) noexcept {
  const std::uint64_t word = word_of(frame);
  if (frame.length != 8 || frame.extended) {
    return std::nullopt;
  }
  return MitReply{
      .motor = frame.data[0],
      .position_rad = value(word, 40, 16, -ranges.position_rad, ranges.position_rad),
      .velocity_rad_s = value(word, 28, 12, -ranges.velocity_rad_s, ranges.velocity_rad_s),
      .torque_nm = value(word, 16, 12, -ranges.torque_nm, ranges.torque_nm),
      .temperature_c = static_cast<double>(word & 0xFFFFU) / 10.0};
}

}  // namespace geodesic::drivers::robstride
