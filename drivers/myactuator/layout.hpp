// Where things stand in MyActuator frames: the one table that the codec and the simulated drive
// share. Facts only; each side computes for itself. Sources: README.md.
#pragma once

#include <cstddef>
#include <cstdint>

#include "drivers/bit_field.hpp"

namespace geodesic::drivers::myactuator {

inline constexpr std::uint32_t kRequestId = 0x140;        ///< + motor
inline constexpr std::uint32_t kReplyId = 0x240;          ///< + motor
inline constexpr std::uint32_t kBroadcastId = 0x280;      ///< all motors obey and answer
inline constexpr std::uint32_t kIdSettingId = 0x300;      ///< never sent by us
inline constexpr std::uint32_t kMotionRequestId = 0x400;  ///< + motor
inline constexpr std::uint32_t kMotionReplyId = 0x500;    ///< + motor
inline constexpr std::uint32_t kLastMotor = 32;
inline constexpr std::uint8_t kLength = 8;  ///< a shorter frame is ignored without a word

/// Byte 0 of a request, echoed in byte 0 of its answer. Integers are little-endian.
enum class Command : std::uint8_t {
  kFunction = 0x20,
  kZeroHere = 0x64,  ///< to ROM; effective after a restart, only while disabled
  kPower = 0x71,
  kReset = 0x76,  ///< not answered
  kReleaseBrake = 0x77,
  kLockBrake = 0x78,
  kShutdown = 0x80,
  kStop = 0x81,
  kAngle = 0x92,
  kStatus1 = 0x9A,
  kStatus2 = 0x9C,
  kStatus3 = 0x9D,
  kTorque = 0xA1,
  kSpeed = 0xA2,
  kPosition = 0xA4,
  kRunTime = 0xB1,
  kVersion = 0xB2,
  kWatchdog = 0xB3,
  kModel = 0xB5,
  kWatchdogExpired = 0xF1,  ///< from the drive, once a second while nobody speaks to it
};

/// Of the reply to A1, A2, A4 and 9C: byte 1 int8 [°C], then three int16.
inline constexpr std::size_t kTemperatureAt = 1;
inline constexpr std::size_t kCurrentAt = 2;
inline constexpr std::size_t kSpeedAt = 4;  ///< [deg/s]
inline constexpr std::size_t kAngleAt = 6;  ///< [deg]
/// Of status 1.
inline constexpr std::size_t kMosfetTemperatureAt = 2;
inline constexpr std::size_t kBrakeAt = 3;
inline constexpr std::size_t kVoltageAt = 4;  ///< uint16
inline constexpr std::size_t kErrorsAt = 6;   ///< uint16
/// int16 current of a torque command, and of others the int32 or uint32 value.
inline constexpr std::size_t kValueAt = 4;
inline constexpr std::size_t kSpeedLimitAt = 2;  ///< of A4, uint16 [deg/s]

inline constexpr double kCurrentUnit = 0.01;  ///< [A]
inline constexpr double kAngleUnit = 0.01;    ///< [deg], of 92 and A4
inline constexpr double kSpeedUnit = 0.01;    ///< [deg/s], of A2
inline constexpr double kVoltageUnit = 0.1;   ///< [V]

/// Motion mode.
namespace motion {
inline constexpr Field kPosition{0, 16};
inline constexpr Field kVelocity{16, 12};
inline constexpr Field kStiffness{28, 12};
inline constexpr Field kDamping{40, 12};
inline constexpr Field kTorque{52, 12};
inline constexpr Field kReplyMotor{0, 8};
inline constexpr Field kReplyPosition{8, 16};
inline constexpr Field kReplyVelocity{24, 12};
inline constexpr Field kReplyTorque{36, 12};
}  // namespace motion

/// Bits of status 1.
enum class Error : std::uint16_t {
  kStall = 0x0002,
  kUnderVoltage = 0x0004,
  kOverVoltage = 0x0008,
  kOverCurrent = 0x0010,
  kPowerOverrun = 0x0040,
  kCalibrationWrite = 0x0080,
  kOverSpeed = 0x0100,
  kBoardOverTemperature = 0x0800,
  kMotorOverTemperature = 0x1000,
  kEncoderCalibration = 0x2000,
  kEncoderData = 0x4000,
};

}  // namespace geodesic::drivers::myactuator
