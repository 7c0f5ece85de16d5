// What CANSimple frames are made of: commands, fields, values. With messages.hpp the one table that
// the codec and the simulated drive share. Facts only; how numbers become bytes is computed by each
// side for itself. Sources: README.md.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace geodesic::drivers::odrive {

enum class Firmware : std::uint8_t { k06, k05 };

/// Identifier: node << 5 | command, 11 bits.
inline constexpr unsigned kCommandBits = 5;
inline constexpr std::uint32_t kCommandMask = (1U << kCommandBits) - 1U;
inline constexpr std::uint32_t kLastNode = 62;  ///< 63: not addressed yet

enum class Command : std::uint8_t {
  kVersion = 0x00,  ///< 0.5 never answers it
  kHeartbeat = 0x01,
  kEstop = 0x02,
  kError = 0x03,    ///< 0.5: motor error
  kRxSdo = 0x04,    ///< 0.5: encoder error, sent by the drive
  kTxSdo = 0x05,    ///< 0.5: sensorless error
  kAddress = 0x06,  ///< 0.5: Set_Axis_Node_ID
  kAxisState = 0x07,
  kEstimates = 0x09,
  kEncoderCount = 0x0A,
  kControllerMode = 0x0B,
  kInputPosition = 0x0C,
  kInputVelocity = 0x0D,
  kInputTorque = 0x0E,
  kLimits = 0x0F,
  kAnticogging = 0x10,
  kTrajectoryVelocity = 0x11,
  kTrajectoryAcceleration = 0x12,
  kTrajectoryInertia = 0x13,
  kIq = 0x14,
  kTemperature = 0x15,  ///< 0.5: sensorless estimates
  kReboot = 0x16,
  kBus = 0x17,
  kClearErrors = 0x18,
  kAbsolutePosition = 0x19,  ///< 0.5: Set_Linear_Count
  kPositionGain = 0x1A,
  kVelocityGains = 0x1B,
  kTorques = 0x1C,  ///< 0.5: ADC voltage
  kPowers = 0x1D,   ///< 0.5: controller error
  kDfu = 0x1F,
};

enum class Type : std::uint8_t { kFlag, kU8, kU16, kU32, kI32, kU48, kU64, kF32, kI16Milli };

struct Field {
  const char* name = nullptr;
  const char* unit = "";
  std::uint8_t bit = 0;  ///< of the payload, little-endian
  Type type = Type::kU32;
};

constexpr unsigned bits_of(Type type) noexcept {
  switch (type) {
    case Type::kFlag:
      return 1;
    case Type::kU8:
      return 8;
    case Type::kU16:
    case Type::kI16Milli:
      return 16;
    case Type::kU32:
    case Type::kI32:
    case Type::kF32:
      return 32;
    case Type::kU48:
      return 48;
    case Type::kU64:
      return 64;
  }
  return 0;
}

inline constexpr std::size_t kMaxFields = 8;

struct Message {
  Command command;
  const char* name;
  bool report;  ///< the drive sends it: by its timer, or asked by a remote frame
  bool in_06;
  bool in_05;
  std::uint8_t length;  ///< bytes that we send; a drive takes more and ignores them
  std::array<Field, kMaxFields> fields{};

  constexpr std::size_t count() const noexcept {
    std::size_t n = 0;
    while (n < kMaxFields && fields[n].name != nullptr) {
      ++n;
    }
    return n;
  }
  constexpr bool in(Firmware firmware) const noexcept {
    return firmware == Firmware::k06 ? in_06 : in_05;
  }
};

// Values.
inline constexpr std::uint8_t kAxisUndefined = 0;
inline constexpr std::uint8_t kAxisIdle = 1;
inline constexpr std::uint8_t kAxisClosedLoop = 8;
inline constexpr std::uint32_t kTorqueControl = 1;
inline constexpr std::uint32_t kPassthrough = 1;
inline constexpr std::uint8_t kRebootAndSave = 1;
inline constexpr std::uint8_t kSdoRead = 0;
inline constexpr std::uint8_t kSdoWrite = 1;
inline constexpr std::uint32_t kWatchdog06 = 0x1000000;  ///< of the active errors
inline constexpr std::uint32_t kWatchdog05 = 0x800;      ///< of the axis errors

/// Parameters that are read, and where that is allowed written, by RxSdo; their endpoint ids differ
/// between firmware builds and come from the robot file.
enum class Parameter : std::uint8_t {
  kWatchdogTimeout,
  kEnableWatchdog,
  kEncoderRate,
  kTorqueRate,
  kHeartbeatRate,
  kTorqueConstant,
};
inline constexpr std::size_t kParameterCount = 6;
enum class ParameterType : std::uint8_t { kFloat, kBool, kU32 };
inline constexpr std::array<ParameterType, kParameterCount> kParameterTypes = {
    ParameterType::kFloat, ParameterType::kBool, ParameterType::kU32,
    ParameterType::kU32,   ParameterType::kU32,  ParameterType::kFloat};

}  // namespace geodesic::drivers::odrive
