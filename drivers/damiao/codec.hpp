// Damiao frames <-> numbers, for the host: pure functions, nothing remembered, nothing sent. Which
// frame is due when is the driver's business (driver.hpp).
// Real-time throughout. An encoder refuses what is not finite (reference encoders turn a NaN torque
// into full negative torque), clamps, and rounds to the nearest code.
#pragma once

#include <bit>
#include <cstdint>
#include <optional>

#include "drivers/bit_codec.hpp"
#include "drivers/bus/frame.hpp"
#include "drivers/damiao/layout.hpp"

namespace geodesic::drivers::damiao {

/// PMAX, VMAX, TMAX: a code spans +-each. All finite and above 0, as check() sees to.
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

struct StateReport {
  std::uint8_t status = 0;
  std::uint8_t motor = 0;  ///< low four bits of ESC_ID
  double position_rad = 0.0;
  double velocity_rad_s = 0.0;
  double torque_nm = 0.0;
  double mosfet_c = 0.0;
  double rotor_c = 0.0;
};

/// A register request or its answer; they look alike.
struct RegisterFrame {
  std::uint16_t id = 0;        ///< ESC_ID
  std::uint8_t operation = 0;  ///< an Operation, or what the bus carried in its place
  std::uint8_t number = 0;
  std::uint32_t raw = 0;  ///< value as it stands: a uint32 or the bits of a float32

  constexpr double real() const noexcept { return static_cast<double>(std::bit_cast<float>(raw)); }
  bool operator==(const RegisterFrame&) const = default;
};

struct PositionVelocityCommand {
  double position_rad = 0.0;
  double velocity_limit_rad_s = 0.0;
};

struct PositionForceCommand {
  double position_rad = 0.0;
  double velocity_limit_rad_s = 0.0;  ///< 0 to 100
  double current_limit = 0.0;         ///< 0 to 1, of the drive's maximum
};

/// MIT command. Never equal to a special frame: where it would be, damping loses one code.
/// Nothing if a number is not finite.
std::optional<Frame> encode_mit(std::uint32_t id, bool fd, const MitCommand& command,
                                const Ranges& ranges) noexcept;
/// Nothing if the frame is not eight bytes long or is a special frame.
std::optional<MitCommand> decode_mit(const Frame& frame, const Ranges& ranges) noexcept;

Frame encode_special(std::uint32_t id, bool fd, Special special) noexcept;
std::optional<Special> decode_special(const Frame& frame) noexcept;

/// Nothing if the frame is not eight bytes long.
std::optional<StateReport> decode_report(const Frame& frame, const Ranges& ranges) noexcept;

Frame encode_read(std::uint32_t id, bool fd, std::uint8_t number) noexcept;
Frame encode_write(std::uint32_t id, bool fd, std::uint8_t number, std::uint32_t raw) noexcept;
Frame encode_save(std::uint32_t id, bool fd) noexcept;
Frame encode_state_request(std::uint32_t id, bool fd) noexcept;
/// Reads any frame of eight bytes as a register frame; the caller knows whether it is one.
std::optional<RegisterFrame> decode_register(const Frame& frame) noexcept;

/// The other control modes, for whoever reads a bus; our driver commands in MIT mode only.
/// Each gives nothing if a number is not finite, or the frame has another length.
std::optional<Frame> encode_position_velocity(std::uint32_t id, bool fd,
                                              const PositionVelocityCommand& command) noexcept;
std::optional<PositionVelocityCommand> decode_position_velocity(const Frame& frame) noexcept;
std::optional<Frame> encode_velocity(std::uint32_t id, bool fd, double velocity_rad_s) noexcept;
std::optional<double> decode_velocity(const Frame& frame) noexcept;  ///< 4 bytes, or 8
std::optional<Frame> encode_position_force(std::uint32_t id, bool fd,
                                           const PositionForceCommand& command) noexcept;
std::optional<PositionForceCommand> decode_position_force(const Frame& frame) noexcept;

/// @return the identifier that commands of `mode` go to.
constexpr std::uint32_t command_id(std::uint32_t id, ControlMode mode) noexcept {
  return id + kModeOffset * (static_cast<std::uint32_t>(mode) - 1U);
}

}  // namespace geodesic::drivers::damiao
