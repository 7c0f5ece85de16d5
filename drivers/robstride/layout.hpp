// Where things stand in RobStride and CyberGear frames: the one table that the codec and the
// simulated drive share. Facts only; how numbers become codes is computed by each side for itself.
// Sources: README.md.
#pragma once

#include <array>
#include <cstdint>

namespace geodesic::drivers::robstride {

/// Identifiers have 29 bits: type (28 to 24), 16 bits of data (23 to 8), destination (7 to 0).
inline constexpr unsigned kTypeShift = 24;
inline constexpr unsigned kDataShift = 8;
inline constexpr std::uint32_t kTypeMask = 0x1F000000;
inline constexpr std::uint32_t kDestinationMask = 0xFF;

enum class Type : std::uint8_t {
  kGetId = 0,
  kControl = 1,   ///< data16: torque
  kFeedback = 2,  ///< data16: mode, fault bits, motor
  kEnable = 3,
  kStop = 4,  ///< byte 0 = 1 clears faults; bytes 00 C4 ask for the version
  kZero = 6,
  kSetId = 7,
  kRead = 17,   ///< answered by itself; data16 of the answer: failed, motor
  kWrite = 18,  ///< volatile; answered with feedback
  kFault = 21,
  kSave = 22,
  kBitRate = 23,
  kReport = 24,  ///< reports by its own timer, on or off
  kProtocol = 25,
};

/// Motors are 1 to 127; a motor that was switched on, or is asked for its id, tells 0xFE.
inline constexpr std::uint32_t kLastMotor = 127;
inline constexpr std::uint32_t kIdentityDestination = 0xFE;

/// Big-endian, 16 bits each; the first byte. In a command the torque stands in the identifier.
namespace control_bytes {
inline constexpr unsigned kPosition = 0;
inline constexpr unsigned kVelocity = 2;
inline constexpr unsigned kStiffness = 4;
inline constexpr unsigned kDamping = 6;
}  // namespace control_bytes

namespace feedback_bytes {
inline constexpr unsigned kPosition = 0;
inline constexpr unsigned kVelocity = 2;
inline constexpr unsigned kTorque = 4;
inline constexpr unsigned kTemperature = 6;  ///< in 0.1 °C
}  // namespace feedback_bytes

/// In the identifier of feedback.
inline constexpr unsigned kFaultShift = 16;
inline constexpr std::uint32_t kFaultBits = 6;
inline constexpr unsigned kModeShift = 22;

enum class Mode : std::uint8_t { kReset = 0, kCalibration = 1, kRun = 2 };

/// The version query: these two bytes to ask, these three before the four of the answer.
inline constexpr std::array<std::uint8_t, 2> kVersionQuery{0x00, 0xC4};
inline constexpr std::array<std::uint8_t, 3> kVersionAnswer{0x00, 0xC4, 0x56};

/// Types 22 to 25 carry these bytes first.
inline constexpr std::array<std::uint8_t, 8> kStaircase{1, 2, 3, 4, 5, 6, 7, 8};

/// One count of canTimeout is 1/20000 s; 0 there is no watchdog.
inline constexpr std::int64_t kTimeoutUnitNs = 50'000;

enum class Index : std::uint16_t {
  kCyberGearTimeout = 0x200C,
  kRunMode = 0x7005,
  kTorqueLimit = 0x700B,
  kPosition = 0x7019,  ///< not wrapped
  kVelocity = 0x701B,
  kTimeout = 0x7028,
  kZeroState = 0x7029,  ///< 0: 0 to 2 pi at power-on; 1: -pi to pi
};

enum class RunMode : std::uint8_t { kOperation = 0 };

enum class Value : std::uint8_t { kU8, kI16, kU16, kU32, kFloat };

struct Parameter {
  std::uint16_t index;
  const char* name;
  const char* unit;
  Value value;
  bool writable;
};

/// Type 17 and 18: index and value little-endian, at bytes 0 and 4.
inline constexpr std::array kParameters = {
    Parameter{0x200C, "CAN_TIMEOUT", "50 µs", Value::kU32, true},
    Parameter{0x7005, "run_mode", "", Value::kU8, true},
    Parameter{0x7006, "iq_ref", "A", Value::kFloat, true},
    Parameter{0x700A, "spd_ref", "rad/s", Value::kFloat, true},
    Parameter{0x700B, "limit_torque", "N·m", Value::kFloat, true},
    Parameter{0x7010, "cur_kp", "", Value::kFloat, true},
    Parameter{0x7011, "cur_ki", "", Value::kFloat, true},
    Parameter{0x7014, "cur_filt_gain", "", Value::kFloat, true},
    Parameter{0x7016, "loc_ref", "rad", Value::kFloat, true},
    Parameter{0x7017, "limit_spd", "rad/s", Value::kFloat, true},
    Parameter{0x7018, "limit_cur", "A", Value::kFloat, true},
    Parameter{0x7019, "mechPos", "rad", Value::kFloat, false},
    Parameter{0x701A, "iqf", "A", Value::kFloat, false},
    Parameter{0x701B, "mechVel", "rad/s", Value::kFloat, false},
    Parameter{0x701C, "VBUS", "V", Value::kFloat, false},
    Parameter{0x701D, "rotation", "", Value::kI16, false},
    Parameter{0x701E, "loc_kp", "", Value::kFloat, true},
    Parameter{0x701F, "spd_kp", "", Value::kFloat, true},
    Parameter{0x7020, "spd_ki", "", Value::kFloat, true},
    Parameter{0x7022, "acc_rad", "rad/s²", Value::kFloat, true},
    Parameter{0x7024, "vel_max", "rad/s", Value::kFloat, true},
    Parameter{0x7025, "acc_set", "rad/s²", Value::kFloat, true},
    Parameter{0x7026, "EPScan_time", "", Value::kU16, true},
    Parameter{0x7028, "canTimeout", "50 µs", Value::kU32, true},
    Parameter{0x7029, "zero_sta", "", Value::kU8, true},
    Parameter{0x702A, "damper", "", Value::kU8, true},
    Parameter{0x702B, "add_offset", "rad", Value::kFloat, true},
};

/// The parameter of that index; null if none is known.
constexpr const Parameter* find_parameter(std::uint16_t index) noexcept {
  for (const Parameter& parameter : kParameters) {
    if (parameter.index == index) {
      return &parameter;
    }
  }
  return nullptr;
}

/// CyberGear keeps its watchdog elsewhere, and knows neither zero_sta nor reports by a timer.
constexpr bool knows(std::uint16_t index, bool cybergear) noexcept {
  constexpr auto kRobstrideOnly = static_cast<std::uint16_t>(0x7026);
  return cybergear ? index < kRobstrideOnly
                   : index != static_cast<std::uint16_t>(Index::kCyberGearTimeout);
}

constexpr Index timeout_index(bool cybergear) noexcept {
  return cybergear ? Index::kCyberGearTimeout : Index::kTimeout;
}

/// DriveState::error: 1 to 6 a fault bit of feedback, counted from 1; 32 and on a fault bit of a
/// type 21 report, counted from 32; or one of these.
inline constexpr std::uint8_t kFirstReported = 32;
inline constexpr std::uint8_t kRebooted = 64;
inline constexpr std::uint8_t kLeftRunMode = 65;

}  // namespace geodesic::drivers::robstride
