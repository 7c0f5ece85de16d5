// The options that this family alone has, and what they say of a drive in SI units. Read by the
// host's side; the simulated drive reads the settings too and computes for itself.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "drivers/cia402/layout.hpp"
#include "drivers/drive.hpp"
#include "drivers/drive_setting.hpp"

namespace geodesic::drivers::cia402 {

/// Places in kSettings.
enum class Setting : std::uint8_t {
  kHostNode,
  kEncoderIncrements,
  kEncoderRevolutions,
  kEncoderAt,
  kEncoderTurns,
  kEncoderCheck,
  kGearMotor,
  kGearShaft,
  kGearCheck,
  kRatedTorque,
  kRatedTorqueAt,
  kRatedTorqueCheck,
  kVelocityUnit,
  kReceiveType,
  kReceiveTimer,
  kConnectionLost,
  kQuickStop,
  kHeartbeat,
  kReset,
  kVendor,
  kProduct,
  kLeastRevision,
};

enum class Side : std::uint8_t { kMotor, kOutput };
enum class Turns : std::uint8_t { kLost, kKept };
enum class Check : std::uint8_t { kDrive, kManual };
enum class VelocityUnit : std::uint8_t {
  kFromPosition,
  kIncrementsPerSecond,
  kRpm,
  kTenthRpm,
  kMilliRpm,
};
enum class ReceiveType : std::uint8_t { kSync, kAtOnce };
enum class ReceiveTimer : std::uint8_t { kIfThere, kRequired, kOff };
enum class ConnectionLost : std::uint8_t { kFault, kDisableVoltage, kQuickStop };
/// 0x605A is the index of the choice; the last is not written.
enum class QuickStop : std::uint8_t {
  kDisable,
  kSlowRamp,
  kQuickRamp,
  kCurrentLimit,
  kVoltageLimit,
  kAsItIs,
};
enum class Reset : std::uint8_t { kCommunication, kNode, kNone };

std::span<const DriveSetting> settings() noexcept;

inline double number(const DriveOptions& options, Setting setting) noexcept {
  return options.settings.get(settings(), static_cast<std::size_t>(setting));
}
inline std::uint32_t integer(const DriveOptions& options, Setting setting) noexcept {
  return static_cast<std::uint32_t>(number(options, setting));
}
template <class Choice>
Choice choice(const DriveOptions& options, Setting setting) noexcept {
  return static_cast<Choice>(integer(options, setting));
}

/// How often a host says that it is alive: well within the shortest watchdog that check() allows.
inline constexpr std::int64_t kHostHeartbeatNs = 10'000'000;
inline constexpr std::int64_t kLeastWatchdogNs = 30'000'000;

/// A drive's numbers in SI, at its output shaft. Host's side.
struct Units {
  /// @param options  must pass check().
  explicit Units(const DriveOptions& options) noexcept;

  double gear = 1.0;                      ///< motor turns for one of the shaft
  double rad_per_increment = 0;           ///< of 0x6064
  double rad_s_per_velocity = 0;          ///< of 0x606C; 0: velocity comes from positions
  double rated_nm = 0;                    ///< 1000 per mille of 0x6071
  std::uint16_t max_torque_permille = 0;  ///< what 0x6072 is set to
  std::uint16_t watchdog_ms = 0;
};

}  // namespace geodesic::drivers::cia402
