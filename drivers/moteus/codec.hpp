// What this host says to a moteus drive and what the drive's replies tell: pure functions, nothing
// remembered, nothing sent. Bytes are subframes.hpp's; which frame is due when, driver.hpp's.
// Real-time throughout. Angles in revolutions of the output, as the protocol has them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "drivers/bus/frame.hpp"
#include "drivers/moteus/layout.hpp"
#include "drivers/moteus/subframes.hpp"

namespace geodesic::drivers::moteus {

/// How the registers of one drive travel, decided once by their ranges.
struct Formats {
  Resolution position = Resolution::kFloat;
  Resolution velocity = Resolution::kFloat;
  Resolution torque = Resolution::kFloat;
  Resolution scale = Resolution::kFloat;  ///< of kp, kd
  bool voltage = true;                    ///< is asked for as well
};

/// Host and drive.
struct Link {
  std::uint32_t host = 0;
  std::uint32_t drive = 1;
  std::uint32_t prefix = 0;

  Address command() const noexcept { return {host, drive, true, prefix}; }
  Address reply() const noexcept { return {drive, host, false, prefix}; }
};

struct PositionCommand {
  std::optional<double> position_rev;  ///< nothing: where it is
  double velocity_rev_s = 0.0;
  double torque_nm = 0.0;
  double kp_scale = 0.0;
  double kd_scale = 0.0;
  double max_torque_nm = 0.0;
  std::int64_t watchdog_ns = 0;
};

/// What a drive says of itself; nothing where the reply does not hold it.
struct StateReport {
  std::optional<std::uint8_t> mode;
  std::optional<std::uint8_t> fault;
  std::optional<double> position_rev;
  std::optional<double> velocity_rev_s;
  std::optional<double> torque_nm;
  std::optional<double> temperature_c;
  std::optional<double> motor_c;
  bool saturated = false;  ///< position or velocity stand at their integer's end
};

/// Position mode with every register that matters, and the query. Position without stiffness leaves
/// as NaN. Nothing if a number is not finite.
/// @param read_back  asks for maximum torque and watchdog as well
std::optional<Frame> encode_position(const Link& link, const Formats& formats,
                                     const PositionCommand& command, bool read_back) noexcept;
/// Mode 0: no torque, clears fault and position time-out; and the query.
Frame encode_stop(const Link& link, const Formats& formats) noexcept;
/// Commands nothing and feeds no watchdog.
Frame encode_query(const Link& link, const Formats& formats) noexcept;
/// Bytes of a reply to a query, as it leaves.
std::size_t reply_length(const Formats& formats) noexcept;
/// Bytes of a position frame without position and velocity, as it leaves.
std::size_t command_length(const Formats& formats, std::int64_t watchdog_ns) noexcept;

/// The value of register 0x027 as it leaves for that time [s].
double watchdog_s(std::int64_t watchdog_ns) noexcept;

/// A line for the drive's console, at most 48 characters, and the request for what it says.
Frame encode_text(const Link& link, std::string_view line) noexcept;
Frame encode_poll(const Link& link) noexcept;

/// All that a reply says of the drive's state.
StateReport decode_report(const Frame& frame) noexcept;

}  // namespace geodesic::drivers::moteus
