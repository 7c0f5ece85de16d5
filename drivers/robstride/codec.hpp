// RobStride and CyberGear frames <-> numbers, for the host: pure functions, nothing remembered,
// nothing sent. Which frame is due when is the driver's business (driver.hpp).
// Real-time throughout. An encoder refuses what is not finite, clamps, and rounds to the nearest
// code. Commands and feedback are big-endian, parameters little-endian.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <optional>

#include "drivers/bus/frame.hpp"
#include "drivers/robstride/layout.hpp"

namespace geodesic::drivers::robstride {

/// Who talks to whom.
struct Link {
  std::uint8_t motor = 0;
  std::uint8_t host = 0;
};

/// Codes of 16 bits span +-each of the first three, and 0 to each of the others. All above 0.
struct Ranges {
  double position_rad = 0.0;
  double velocity_rad_s = 0.0;
  double torque_nm = 0.0;
  double stiffness_nm_rad = 0.0;
  double damping_nm_s_rad = 0.0;
};

struct ControlCommand {
  double position_rad = 0.0;
  double velocity_rad_s = 0.0;
  double stiffness_nm_rad = 0.0;
  double damping_nm_s_rad = 0.0;
  double torque_nm = 0.0;
};

struct Feedback {
  Link link;
  std::uint8_t mode = 0;    ///< a Mode, or 3
  std::uint8_t faults = 0;  ///< kFaultBits bits
  bool at_end = false;      ///< the position is the first or last code: it may be beyond
  double position_rad = 0.0;
  double velocity_rad_s = 0.0;
  double torque_nm = 0.0;
  double temperature_c = 0.0;
};

/// The answer to a read.
struct ParameterAnswer {
  Link link;
  bool failed = false;  ///< the drive has no such parameter; the value says nothing
  std::uint16_t index = 0;
  std::uint32_t raw = 0;

  constexpr double real() const noexcept { return static_cast<double>(std::bit_cast<float>(raw)); }
};

struct FaultReport {
  Link link;
  std::uint32_t faults = 0;
  std::uint32_t warnings = 0;
};

constexpr std::uint32_t identifier(Type type, std::uint32_t data, std::uint32_t to) noexcept {
  return static_cast<std::uint32_t>(type) << kTypeShift | data << kDataShift | to;
}
constexpr Type type_of(std::uint32_t id) noexcept {
  return static_cast<Type>((id & kTypeMask) >> kTypeShift);
}

/// @return the code of `value` in [low, high], 16 bits: clamped, rounded to nearest.
inline std::uint16_t to_code(double value, double low, double high) noexcept {
  const double clamped = value < low ? low : (value > high ? high : value);
  return static_cast<std::uint16_t>(std::lround((clamped - low) / (high - low) * 65535.0));
}
/// @return what a drive takes `code` for.
constexpr double from_code(std::uint32_t code, double low, double high) noexcept {
  return static_cast<double>(code) / 65535.0 * (high - low) + low;
}

/// Type 1. Nothing if a number is not finite.
std::optional<Frame> encode_control(std::uint8_t motor, const ControlCommand& command,
                                    const Ranges& ranges) noexcept;
/// Each decoder gives nothing if the frame is of another type or has another length.
std::optional<ControlCommand> decode_control(const Frame& frame, const Ranges& ranges) noexcept;
std::optional<Feedback> decode_feedback(const Frame& frame, const Ranges& ranges) noexcept;
std::optional<ParameterAnswer> decode_parameter(const Frame& frame) noexcept;
std::optional<FaultReport> decode_fault_report(const Frame& frame) noexcept;
/// The motor that tells its identity (asked, or since it was switched on).
std::optional<std::uint8_t> decode_identity(const Frame& frame) noexcept;
/// Feedback that is the answer to a version query: a.b.c.d as a*10^6 + b*10^4 + c*100 + d.
std::optional<std::uint32_t> decode_version(const Frame& frame) noexcept;

Frame encode_get_id(const Link& link) noexcept;
Frame encode_enable(const Link& link) noexcept;
Frame encode_stop(const Link& link, bool clear_faults) noexcept;
Frame encode_version_query(const Link& link) noexcept;  ///< stops the motor, as encode_stop()
Frame encode_zero(const Link& link) noexcept;
Frame encode_set_id(const Link& link, std::uint8_t motor) noexcept;
Frame encode_read(const Link& link, std::uint16_t index) noexcept;
Frame encode_write(const Link& link, std::uint16_t index, std::uint32_t raw) noexcept;
Frame encode_save(const Link& link) noexcept;
Frame encode_reports(const Link& link, bool on) noexcept;

}  // namespace geodesic::drivers::robstride
