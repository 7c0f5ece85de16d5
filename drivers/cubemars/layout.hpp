// Where things stand in CubeMars AK frames: the one table that the codec and the simulated drive
// share. Facts only; each side computes codes for itself. Sources: README.md.
#pragma once

#include <cstdint>

#include "drivers/bit_field.hpp"

namespace geodesic::drivers::cubemars {

/// MIT command, to the motor's identifier (11 bits).
namespace mit {
inline constexpr Field kPosition{0, 16};
inline constexpr Field kVelocity{16, 12};
inline constexpr Field kStiffness{28, 12};
inline constexpr Field kDamping{40, 12};
inline constexpr Field kTorque{52, 12};
inline constexpr double kMaxStiffness = 500.0;  ///< [N·m/rad]; the least is 0
inline constexpr double kMaxDamping = 5.0;      ///< [N·m·s/rad]; the least is 0
}  // namespace mit

/// MIT reply, of 6, 7 or 8 bytes, to the host's identifier (11 bits; the motor's stands in byte 0).
namespace reply {
inline constexpr Field kMotor{0, 8};
inline constexpr Field kPosition{8, 16};
inline constexpr Field kVelocity{24, 12};
inline constexpr Field kTorque{36, 12};
inline constexpr Field kVoltage{48, 8};      ///< replies of 7 bytes
inline constexpr Field kTemperature{48, 8};  ///< replies of 8 bytes
inline constexpr Field kError{56, 8};        ///< replies of 8 bytes
inline constexpr double kMaxVoltage = 40.0;  ///< [V]; the least is 0
inline constexpr std::uint8_t kShort = 6;    ///< bytes
inline constexpr std::uint8_t kWithVoltage = 7;
inline constexpr std::uint8_t kWithError = 8;
}  // namespace reply

/// Seven bytes 0xFF and one of these, to the motor's identifier.
enum class Special : std::uint8_t {
  kEnter = 0xFC,
  kExit = 0xFD,
  kSetZero = 0xFE,
};

/// Servo mode: identifiers of 29 bits, function << 8 | motor; integers big-endian.
enum class Function : std::uint8_t {
  kDuty = 0,
  kCurrent = 1,
  kBrakeCurrent = 2,
  kSpeed = 3,
  kPosition = 4,
  kOrigin = 5,
  kPositionSpeed = 6,
  kMit = 8,
  kStartUp = 0x09,    ///< from the drive: switched on
  kStatus = 0x29,     ///< from the drive, by its own timer
  kServoMode = 0x2C,  ///< from the drive: it is in servo mode
};

namespace servo {
inline constexpr double kDutyUnit = 1e-5;
inline constexpr double kCurrentUnit = 1e-3;       ///< [A]
inline constexpr double kPositionUnit = 1e-4;      ///< [deg]
inline constexpr double kSpeedUnit = 1.0;          ///< [erpm], in a speed command
inline constexpr double kProfileSpeedUnit = 10.0;  ///< [erpm], [erpm/s], in position-speed commands
inline constexpr double kStatusPositionUnit = 0.1;  ///< [deg]
inline constexpr double kStatusSpeedUnit = 10.0;    ///< [erpm]
inline constexpr double kStatusCurrentUnit = 0.01;  ///< [A]
inline constexpr std::uint8_t kPermanent = 1;       ///< set origin: kept, with two encoders
}  // namespace servo

/// Byte 7 of a reply or status. Others than these are not documented.
enum class Error : std::uint8_t {
  kNone = 0,
  kMotorOverTemperature = 1,
  kOverCurrent = 2,
  kOverVoltage = 3,
  kUnderVoltage = 4,
  kEncoder = 5,
  kMosfetOverTemperature = 6,
  kStall = 7,
};

constexpr std::uint32_t servo_id(Function function, std::uint32_t motor) noexcept {
  return static_cast<std::uint32_t>(function) << 8U | motor;
}

}  // namespace geodesic::drivers::cubemars
