// CubeMars frames <-> numbers, for the host: pure functions, nothing remembered, nothing sent.
// Real-time throughout. An encoder refuses what is not finite, clamps, and rounds to nearest (the
// vendor's sample code scales with 2^n and overflows into the next field).
#pragma once

#include <cstdint>
#include <optional>

#include "drivers/bit_codec.hpp"
#include "drivers/bus/frame.hpp"
#include "drivers/cubemars/layout.hpp"

namespace geodesic::drivers::cubemars {

/// A code spans +-each. All finite and above 0, as check() sees to.
struct Ranges {
  double position_rad = 0.0;
  double velocity_rad_s = 0.0;
  double torque_nm = 0.0;
};

struct MitCommand {
  double position_rad = 0.0;
  double velocity_rad_s = 0.0;
  double stiffness_nm_rad = 0.0;
  double damping_nm_s_rad = 0.0;
  double torque_nm = 0.0;
};

struct MitReply {
  std::uint8_t motor = 0;
  double position_rad = 0.0;
  double velocity_rad_s = 0.0;
  double torque_nm = 0.0;
  std::optional<double> voltage_v = {};  ///< replies of 7 bytes
  std::optional<std::uint8_t> temperature_raw =
      {};                  ///< replies of 8 bytes; see temperature_offset_c
  std::uint8_t error = 0;  ///< replies of 8 bytes
};

/// Servo mode, as the bus carries it: degrees, electrical rpm, ampere of the motor's phases.
struct ServoStatus {
  double position_deg = 0.0;
  double speed_erpm = 0.0;
  double current_a = 0.0;
  double temperature_c = 0.0;
  std::uint8_t error = 0;
};

/// Of kDuty, kCurrent [A], kBrakeCurrent [A], kSpeed [erpm], kPosition [deg] and kOrigin.
struct ServoCommand {
  Function function = Function::kCurrent;
  double value = 0.0;
};

struct PositionSpeedCommand {
  double position_deg = 0.0;
  double speed_erpm = 0.0;
  double acceleration_erpm_s = 0.0;
};

/// Never equal to a special frame: where it would be, damping loses one code.
/// Nothing if a number is not finite.
std::optional<Frame> encode_mit(std::uint32_t id, const MitCommand& command,
                                const Ranges& ranges) noexcept;
/// Nothing if the frame is not eight bytes long or is a special frame.
std::optional<MitCommand> decode_mit(const Frame& frame, const Ranges& ranges) noexcept;

Frame encode_special(std::uint32_t id, Special special) noexcept;
std::optional<Special> decode_special(const Frame& frame) noexcept;

/// Nothing if the frame is not 6, 7 or 8 bytes long.
std::optional<MitReply> decode_reply(const Frame& frame, const Ranges& ranges) noexcept;

/// Nothing if the value is not finite or the function has another form.
std::optional<Frame> encode_servo(std::uint32_t motor, const ServoCommand& command) noexcept;
std::optional<ServoCommand> decode_servo(const Frame& frame) noexcept;
std::optional<Frame> encode_position_speed(std::uint32_t motor,
                                           const PositionSpeedCommand& command) noexcept;
std::optional<PositionSpeedCommand> decode_position_speed(const Frame& frame) noexcept;
/// Nothing if the frame is not eight bytes long; the caller knows its identifier.
std::optional<ServoStatus> decode_status(const Frame& frame) noexcept;

}  // namespace geodesic::drivers::cubemars
