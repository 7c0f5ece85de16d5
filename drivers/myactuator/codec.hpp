// MyActuator frames <-> numbers, for the host: pure functions, nothing remembered, nothing sent.
// Real-time throughout. An encoder refuses what is not finite, clamps, and rounds to nearest.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "drivers/bit_codec.hpp"
#include "drivers/bus/frame.hpp"
#include "drivers/drive.hpp"
#include "drivers/myactuator/layout.hpp"

namespace geodesic::drivers::myactuator {

/// Of the motion mode: position, velocity and torque span +-each, the others begin at 0. All finite
/// and above 0 where the motion mode is used, as check() sees to.
struct Ranges {
  double position_rad = 0.0;
  double velocity_rad_s = 0.0;
  double torque_nm = 0.0;
  double stiffness_nm_rad = 500.0;
  double damping_nm_s_rad = 5.0;
};
Ranges ranges_of(const DriveOptions& options) noexcept;

struct MotionCommand {
  double position_rad = 0.0;
  double velocity_rad_s = 0.0;
  double stiffness_nm_rad = 0.0;
  double damping_nm_s_rad = 0.0;
  double torque_nm = 0.0;
};

struct MotionReply {
  std::uint8_t motor = 0;
  double position_rad = 0.0;
  double velocity_rad_s = 0.0;
  double torque_nm = 0.0;
};

/// The reply to A1, A2, A4 and 9C.
struct LoopReply {
  double temperature_c = 0.0;
  double current_a = 0.0;
  double speed_deg_s = 0.0;
  double angle_deg = 0.0;
};

struct Status1 {
  double motor_c = 0.0;
  double mosfet_c = 0.0;  ///< 0 from older firmware
  bool brake_released = false;
  double voltage_v = 0.0;
  std::uint16_t errors = 0;
};

struct Status3 {
  double temperature_c = 0.0;
  std::array<double, 3> current_a{};
};

struct PositionCommand {
  double angle_deg = 0.0;
  double speed_limit_deg_s = 0.0;
};

/// A request without arguments.
Frame encode_request(std::uint32_t motor, Command command) noexcept;
/// A request with a uint32 in bytes 4 to 7 (B3), and of 20 its index.
Frame encode_value(std::uint32_t motor, Command command, std::uint32_t value,
                   std::uint8_t index = 0) noexcept;
/// Nothing if a number is not finite.
std::optional<Frame> encode_torque(std::uint32_t motor, double current_a) noexcept;
std::optional<Frame> encode_speed(std::uint32_t motor, double speed_deg_s) noexcept;
std::optional<Frame> encode_position(std::uint32_t motor, const PositionCommand& command) noexcept;
std::optional<Frame> encode_motion(std::uint32_t motor, const MotionCommand& command,
                                   const Ranges& ranges) noexcept;

/// Of a request or reply; nothing if the frame is not eight bytes long.
std::optional<std::uint8_t> command_of(const Frame& frame) noexcept;

/// Each gives nothing if the frame is not eight bytes long or byte 0 is another command.
std::optional<double> decode_torque(const Frame& frame) noexcept;  ///< [A]
std::optional<double> decode_speed(const Frame& frame) noexcept;   ///< [deg/s]
std::optional<PositionCommand> decode_position(const Frame& frame) noexcept;
std::optional<LoopReply> decode_loop_reply(const Frame& frame) noexcept;
std::optional<Status1> decode_status1(const Frame& frame) noexcept;
std::optional<Status3> decode_status3(const Frame& frame) noexcept;
std::optional<double> decode_angle(const Frame& frame) noexcept;  ///< [deg]
/// Bytes 4 to 7 of whatever command it is.
std::uint32_t decode_value(const Frame& frame) noexcept;
/// Of frames on the motion identifiers; nothing if not eight bytes long.
std::optional<MotionCommand> decode_motion(const Frame& frame, const Ranges& ranges) noexcept;
std::optional<MotionReply> decode_motion_reply(const Frame& frame, const Ranges& ranges) noexcept;

/// A frame whose bytes 1 to 7 are 0: as a reply it may be a request that the drive sent back.
bool is_bare(const Frame& frame) noexcept;

/// The lowest error bit counted from 1, as DriveState::error; 0: none.
std::uint8_t error_code(std::uint16_t errors) noexcept;

}  // namespace geodesic::drivers::myactuator
