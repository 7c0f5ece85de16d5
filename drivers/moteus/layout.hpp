// Numbers of the moteus register protocol: the one table that the codec and the simulated drive
// share. Facts only; how values become integers is computed by each side. Sources: README.md.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace geodesic::drivers::moteus {

/// 16 bits of source and destination; above them an optional prefix of 13 bits.
inline constexpr std::uint32_t kReplyWanted = 0x8000;
inline constexpr std::uint32_t kBroadcast = 0x7F;
inline constexpr std::uint32_t kLastId = 0x7E;
inline constexpr unsigned kSourceShift = 8;
inline constexpr unsigned kPrefixShift = 16;
inline constexpr std::uint32_t kLastPrefix = 0x1FFF;
/// Identifiers above it leave in an extended frame.
inline constexpr std::uint32_t kLastStandardId = 0x7FF;

/// How a value stands in a frame; the two bits above the count in a subframe's opcode.
enum class Resolution : std::uint8_t { kInt8 = 0, kInt16 = 1, kInt32 = 2, kFloat = 3 };

constexpr std::size_t bytes_of(Resolution resolution) noexcept {
  return resolution == Resolution::kInt8 ? 1 : (resolution == Resolution::kInt16 ? 2 : 4);
}

/// First byte of a subframe. Of the three register ones: bits 0 and 1 the count (0: a varuint
/// follows), bits 2 and 3 the Resolution.
namespace opcode {
inline constexpr std::uint8_t kWrite = 0x00;
inline constexpr std::uint8_t kRead = 0x10;
inline constexpr std::uint8_t kReply = 0x20;
inline constexpr std::uint8_t kWriteError = 0x30;  ///< varuint register, varuint error
inline constexpr std::uint8_t kReadError = 0x31;
inline constexpr std::uint8_t kClientToServer = 0x40;  ///< varuint channel, varuint count, bytes
inline constexpr std::uint8_t kServerToClient = 0x41;
inline constexpr std::uint8_t kClientPoll = 0x42;  ///< varuint channel, varuint most bytes
inline constexpr std::uint8_t kNop = 0x50;
}  // namespace opcode

inline constexpr std::uint32_t kDiagnosticChannel = 1;
/// Of opcode::kWriteError and opcode::kReadError.
inline constexpr std::uint32_t kUnknownRegister = 1;
inline constexpr std::uint32_t kNotWriteable = 2;

enum class Mode : std::uint8_t {
  kStopped = 0,  ///< written: clears faults and the position time-out
  kFault = 1,
  kEnabling = 2,
  kCalibrating = 3,
  kCalibrated = 4,
  kCurrent = 9,
  kPosition = 10,
  kPositionTimeout = 11,  ///< the drive's watchdog expired; only a stop leaves it
  kZeroVelocity = 12,
  kStayWithin = 13,
  kBrake = 15,
};
inline constexpr std::array<const char*, 16> kModeNames = {
    "stopped",       "fault",       "enabling",
    "calibrating",   "calibrated",  "PWM",
    "voltage",       "voltage FOC", "voltage DQ",
    "current",       "position",    "position time-out",
    "zero velocity", "stay within", "measure inductance",
    "brake"};

enum class Home : std::uint8_t { kRelative = 0, kRotor = 1, kOutput = 2 };

/// A fault code from here on tells in a running mode what limits the output.
inline constexpr std::uint8_t kFirstLimit = 96;

inline constexpr std::int32_t kRegisterMapVersion = 5;

/// What a register measures decides what one count of its integers is worth.
enum class Quantity : std::uint8_t {
  kInteger,  ///< as it stands; has no NaN
  kPosition,
  kVelocity,
  kTorque,
  kCurrent,
  kVoltage,
  kTemperature,
  kTime,
  kScale,
  kPower,
  kAcceleration,
};

struct Scale {
  double int8;
  double int16;
  double int32;
};
inline constexpr std::array<Scale, 11> kScales = {
    Scale{1.0, 1.0, 1.0},                                   // integer
    Scale{0.01, 0.0001, 0.00001},                           // rev
    Scale{0.1, 0.00025, 0.00001},                           // rev/s
    Scale{0.5, 0.01, 0.001},                                // N·m
    Scale{1.0, 0.1, 0.001},                                 // A
    Scale{0.5, 0.1, 0.001},                                 // V
    Scale{1.0, 0.1, 0.001},                                 // °C
    Scale{0.01, 0.001, 0.000001},                           // s
    Scale{1.0 / 127.0, 1.0 / 32767.0, 1.0 / 2147483647.0},  // of one
    Scale{10.0, 0.05, 0.0001},                              // W
    Scale{0.05, 0.001, 0.00001},                            // rev/s²
};

enum class Register : std::uint16_t {
  kMode = 0x000,
  kPosition = 0x001,
  kVelocity = 0x002,
  kTorque = 0x003,
  kQCurrent = 0x004,
  kMotorTemperature = 0x00A,
  kTrajectoryComplete = 0x00B,
  kHomeState = 0x00C,
  kVoltage = 0x00D,
  kTemperature = 0x00E,
  kFault = 0x00F,
  kCommandQCurrent = 0x01C,
  kCommandPosition = 0x020,
  kCommandVelocity = 0x021,
  kCommandTorque = 0x022,
  kCommandKpScale = 0x023,
  kCommandKdScale = 0x024,
  kCommandMaxTorque = 0x025,
  kCommandTimeout = 0x027,
  kCommandIlimitScale = 0x02B,
  kModel = 0x100,
  kFirmware = 0x101,
  kRegisterMap = 0x102,
  kSetOutputNearest = 0x130,
  kSetOutputExact = 0x131,
};

struct RegisterFact {
  std::uint16_t number;
  const char* name;
  const char* unit;
  Quantity quantity;
};

inline constexpr std::array kRegisters = {
    RegisterFact{0x000, "mode", "", Quantity::kInteger},
    RegisterFact{0x001, "position", "rev", Quantity::kPosition},
    RegisterFact{0x002, "velocity", "rev/s", Quantity::kVelocity},
    RegisterFact{0x003, "torque", "N·m", Quantity::kTorque},
    RegisterFact{0x004, "q current", "A", Quantity::kCurrent},
    RegisterFact{0x005, "d current", "A", Quantity::kCurrent},
    RegisterFact{0x006, "absolute position", "rev", Quantity::kPosition},
    RegisterFact{0x007, "power", "W", Quantity::kPower},
    RegisterFact{0x00A, "motor temperature", "°C", Quantity::kTemperature},
    RegisterFact{0x00B, "trajectory complete", "", Quantity::kInteger},
    RegisterFact{0x00C, "home state", "", Quantity::kInteger},
    RegisterFact{0x00D, "voltage", "V", Quantity::kVoltage},
    RegisterFact{0x00E, "temperature", "°C", Quantity::kTemperature},
    RegisterFact{0x00F, "fault", "", Quantity::kInteger},
    RegisterFact{0x01C, "q current command", "A", Quantity::kCurrent},
    RegisterFact{0x01D, "d current command", "A", Quantity::kCurrent},
    RegisterFact{0x020, "position command", "rev", Quantity::kPosition},
    RegisterFact{0x021, "velocity command", "rev/s", Quantity::kVelocity},
    RegisterFact{0x022, "feed-forward torque", "N·m", Quantity::kTorque},
    RegisterFact{0x023, "kp scale", "", Quantity::kScale},
    RegisterFact{0x024, "kd scale", "", Quantity::kScale},
    RegisterFact{0x025, "maximum torque", "N·m", Quantity::kTorque},
    RegisterFact{0x026, "stop position", "rev", Quantity::kPosition},
    RegisterFact{0x027, "watchdog timeout", "s", Quantity::kTime},
    RegisterFact{0x028, "velocity limit", "rev/s", Quantity::kVelocity},
    RegisterFact{0x029, "acceleration limit", "rev/s²", Quantity::kAcceleration},
    RegisterFact{0x02A, "fixed voltage", "V", Quantity::kVoltage},
    RegisterFact{0x02B, "ilimit scale", "", Quantity::kScale},
    RegisterFact{0x02C, "fixed current", "A", Quantity::kCurrent},
    RegisterFact{0x02D, "ignore position bounds", "", Quantity::kInteger},
    RegisterFact{0x030, "proportional torque", "N·m", Quantity::kTorque},
    RegisterFact{0x031, "integral torque", "N·m", Quantity::kTorque},
    RegisterFact{0x032, "derivative torque", "N·m", Quantity::kTorque},
    RegisterFact{0x033, "feed-forward part", "N·m", Quantity::kTorque},
    RegisterFact{0x034, "total control torque", "N·m", Quantity::kTorque},
    RegisterFact{0x038, "control position", "rev", Quantity::kPosition},
    RegisterFact{0x039, "control velocity", "rev/s", Quantity::kVelocity},
    RegisterFact{0x03A, "control torque", "N·m", Quantity::kTorque},
    RegisterFact{0x03B, "position error", "rev", Quantity::kPosition},
    RegisterFact{0x03C, "velocity error", "rev/s", Quantity::kVelocity},
    RegisterFact{0x03D, "torque error", "N·m", Quantity::kTorque},
    RegisterFact{0x050, "encoder 0 position", "rev", Quantity::kPosition},
    RegisterFact{0x051, "encoder 0 velocity", "rev/s", Quantity::kVelocity},
    RegisterFact{0x052, "encoder 1 position", "rev", Quantity::kPosition},
    RegisterFact{0x053, "encoder 1 velocity", "rev/s", Quantity::kVelocity},
    RegisterFact{0x054, "encoder 2 position", "rev", Quantity::kPosition},
    RegisterFact{0x055, "encoder 2 velocity", "rev/s", Quantity::kVelocity},
    RegisterFact{0x058, "encoder validity", "", Quantity::kInteger},
    RegisterFact{0x070, "millisecond counter", "", Quantity::kInteger},
    RegisterFact{0x100, "model number", "", Quantity::kInteger},
    RegisterFact{0x101, "firmware version", "", Quantity::kInteger},
    RegisterFact{0x102, "register map version", "", Quantity::kInteger},
    RegisterFact{0x130, "set output nearest", "rev", Quantity::kPosition},
    RegisterFact{0x131, "set output exact", "rev", Quantity::kPosition},
    RegisterFact{0x132, "require reindex", "", Quantity::kInteger},
    RegisterFact{0x133, "recapture position and velocity", "", Quantity::kInteger},
};

/// The register of that number; null if none is known.
constexpr const RegisterFact* find_register(std::uint32_t number) noexcept {
  for (const RegisterFact& fact : kRegisters) {
    if (fact.number == number) {
      return &fact;
    }
  }
  return nullptr;
}

}  // namespace geodesic::drivers::moteus
