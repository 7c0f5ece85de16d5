// Where things stand in CANopen frames and in a CiA 402 drive's object dictionary: the one table
// that the codec and the simulated drive share. Facts only; each side computes for itself.
// Sources: README.md.
#pragma once

#include <array>
#include <cstdint>

namespace geodesic::drivers::cia402 {

/// CANopen identifiers; those above 0x080 carry the node in their low seven bits.
namespace cob {
inline constexpr std::uint32_t kNmt = 0x000;
inline constexpr std::uint32_t kSync = 0x080;
inline constexpr std::uint32_t kEmergency = 0x080;
inline constexpr std::uint32_t kTransmit1 = 0x180;  ///< TPDO1: drive to host
inline constexpr std::uint32_t kReceive1 = 0x200;   ///< RPDO1: host to drive
inline constexpr std::uint32_t kTransmit2 = 0x280;
inline constexpr std::uint32_t kStep = 0x100;  ///< from PDO n to PDO n + 1
inline constexpr std::uint32_t kSdoReply = 0x580;
inline constexpr std::uint32_t kSdoRequest = 0x600;
inline constexpr std::uint32_t kHeartbeat = 0x700;
inline constexpr std::uint32_t kInvalid = 0x80000000;  ///< in an object: the PDO is not in use
}  // namespace cob

inline constexpr std::uint32_t kLastNode = 127;

enum class NmtCommand : std::uint8_t {
  kStart = 0x01,
  kStop = 0x02,
  kPreOperational = 0x80,
  kResetNode = 0x81,
  kResetCommunication = 0x82,
};

/// As a heartbeat tells it.
enum class NmtState : std::uint8_t {
  kBootUp = 0x00,
  kStopped = 0x04,
  kOperational = 0x05,
  kPreOperational = 0x7F,
};

/// First byte of an SDO frame. Expedited transfers carry 4, 3, 2 or 1 bytes: what is unused stands
/// in bits 2 and 3.
namespace sdo {
inline constexpr std::uint8_t kRead = 0x40;
inline constexpr std::uint8_t kReadReply4 = 0x43;  ///< | unused << 2
inline constexpr std::uint8_t kWrite4 = 0x23;      ///< | unused << 2
inline constexpr std::uint8_t kWriteReply = 0x60;
inline constexpr std::uint8_t kAbort = 0x80;
inline constexpr std::uint8_t kUnusedShift = 2;
}  // namespace sdo

enum class Abort : std::uint32_t {
  kToggle = 0x05030000,
  kTimeOut = 0x05040000,
  kCommand = 0x05040001,
  kUnsupportedAccess = 0x06010000,
  kWriteOnly = 0x06010001,
  kReadOnly = 0x06010002,
  kNoObject = 0x06020000,
  kNotMappable = 0x06040041,
  kPdoTooLong = 0x06040042,
  kIncompatible = 0x06040043,
  kHardware = 0x06060000,
  kLength = 0x06070010,
  kTooLong = 0x06070012,
  kTooShort = 0x06070013,
  kNoSub = 0x06090011,
  kRange = 0x06090030,
  kTooHigh = 0x06090031,
  kTooLow = 0x06090032,
  kGeneral = 0x08000000,
  kNotStored = 0x08000020,
  kLocalControl = 0x08000021,
  kDeviceState = 0x08000022,
};

/// An object: index and sub-index, and how many bytes it has.
struct Object {
  std::uint16_t index = 0;
  std::uint8_t sub = 0;
  std::uint8_t bytes = 0;
  bool operator==(const Object&) const = default;
};

namespace object {
inline constexpr Object kDeviceType{0x1000, 0, 4};
inline constexpr Object kErrorRegister{0x1001, 0, 1};
inline constexpr Object kStoreAll{0x1010, 1, 4};
inline constexpr Object kConsumerHeartbeat{0x1016, 1, 4};
inline constexpr Object kProducerHeartbeat{0x1017, 0, 2};
inline constexpr Object kVendor{0x1018, 1, 4};
inline constexpr Object kProduct{0x1018, 2, 4};
inline constexpr Object kRevision{0x1018, 3, 4};
inline constexpr Object kErrorBehaviour{0x1029, 1, 1};
/// Of PDO 1; PDO n has n - 1 more in the index.
inline constexpr Object kReceiveId{0x1400, 1, 4};
inline constexpr Object kReceiveType{0x1400, 2, 1};
inline constexpr Object kReceiveTimer{0x1400, 5, 2};
inline constexpr Object kReceiveCount{0x1600, 0, 1};
inline constexpr Object kTransmitId{0x1800, 1, 4};
inline constexpr Object kTransmitType{0x1800, 2, 1};
inline constexpr Object kTransmitCount{0x1A00, 0, 1};
inline constexpr Object kAbortConnection{0x6007, 0, 2};
inline constexpr Object kErrorCode{0x603F, 0, 2};
inline constexpr Object kControlword{0x6040, 0, 2};
inline constexpr Object kStatusword{0x6041, 0, 2};
inline constexpr Object kQuickStop{0x605A, 0, 2};
inline constexpr Object kMode{0x6060, 0, 1};
inline constexpr Object kModeDisplay{0x6061, 0, 1};
inline constexpr Object kPosition{0x6064, 0, 4};
inline constexpr Object kVelocity{0x606C, 0, 4};
inline constexpr Object kTargetTorque{0x6071, 0, 2};
inline constexpr Object kMaxTorque{0x6072, 0, 2};
inline constexpr Object kRatedTorque{0x6076, 0, 4};
inline constexpr Object kActualTorque{0x6077, 0, 2};
inline constexpr Object kHomeOffset{0x607C, 0, 4};
inline constexpr Object kMaxSpeed{0x6080, 0, 4};  ///< [rpm] of the motor
inline constexpr Object kEncoderIncrements{0x608F, 1, 4};
inline constexpr Object kEncoderRevolutions{0x608F, 2, 4};
inline constexpr Object kGearMotor{0x6091, 1, 4};
inline constexpr Object kGearShaft{0x6091, 2, 4};
inline constexpr Object kSupportedModes{0x6502, 0, 4};
}  // namespace object

inline constexpr std::uint16_t kDeviceProfile = 0x0192;  ///< 402, low half of 0x1000
inline constexpr std::int8_t kCyclicTorque = 10;
inline constexpr std::uint32_t kCyclicTorqueBit = 1U << 9;  ///< in 0x6502
inline constexpr std::uint32_t kSave = 0x65766173;          ///< "save", to 0x1010

/// What is mapped, in this order.
inline constexpr std::array kMapReceive1 = {object::kControlword, object::kTargetTorque};
inline constexpr std::array kMapTransmit1 = {object::kStatusword, object::kPosition,
                                             object::kActualTorque};
inline constexpr std::array kMapTransmit2 = {object::kVelocity};

inline constexpr std::uint8_t kTypeEverySync = 1;  ///< transmission type
inline constexpr std::uint8_t kTypeAtOnce = 255;   ///< transmission type
inline constexpr std::uint8_t kTypeLastCyclic =
    240;  ///< transmission types 1 to this: every n-th SYNC

/// Controlword.
namespace control_word {
inline constexpr std::uint16_t kDisableVoltage = 0x0000;
inline constexpr std::uint16_t kQuickStop = 0x0002;
inline constexpr std::uint16_t kShutdown = 0x0006;
inline constexpr std::uint16_t kSwitchOn = 0x0007;
inline constexpr std::uint16_t kEnableOperation = 0x000F;
inline constexpr std::uint16_t kFaultReset = 0x0080;  ///< on its rising edge
}  // namespace control_word

/// A state is named by the bits of the statusword under a mask.
enum class PowerState : std::uint8_t {
  kNotReady,
  kSwitchOnDisabled,
  kReady,
  kSwitchedOn,
  kEnabled,
  kQuickStop,
  kFaultReaction,
  kFault,
};

struct PowerStateBits {
  PowerState state;
  std::uint16_t mask;
  std::uint16_t bits;
  const char* name;
};

inline constexpr std::array kPowerStates = {
    PowerStateBits{PowerState::kNotReady, 0x4F, 0x00, "not ready to switch on"},
    PowerStateBits{PowerState::kSwitchOnDisabled, 0x4F, 0x40, "switch on disabled"},
    PowerStateBits{PowerState::kReady, 0x6F, 0x21, "ready to switch on"},
    PowerStateBits{PowerState::kSwitchedOn, 0x6F, 0x23, "switched on"},
    PowerStateBits{PowerState::kEnabled, 0x6F, 0x27, "operation enabled"},
    PowerStateBits{PowerState::kQuickStop, 0x6F, 0x07, "quick stop active"},
    PowerStateBits{PowerState::kFaultReaction, 0x4F, 0x0F, "fault reaction active"},
    PowerStateBits{PowerState::kFault, 0x4F, 0x08, "fault"},
};

/// Further bits of the statusword.
inline constexpr std::uint16_t kVoltageEnabled = 1U << 4;
inline constexpr std::uint16_t kRemote = 1U << 9;
inline constexpr std::uint16_t kInternalLimit = 1U << 11;
inline constexpr std::uint16_t kFollows = 1U << 12;  ///< in cyclic modes

/// 0x6007.
enum class Reaction : std::uint8_t {
  kNothing = 0,
  kFault = 1,
  kDisableVoltage = 2,
  kQuickStop = 3
};

namespace emergency {
inline constexpr std::uint16_t kNone = 0x0000;
inline constexpr std::uint16_t kOverCurrent = 0x2310;
inline constexpr std::uint16_t kDriveTemperature = 0x4310;
inline constexpr std::uint16_t kHeartbeat = 0x8130;
inline constexpr std::uint16_t kPdoLength = 0x8210;
inline constexpr std::uint16_t kReceiveTimeOut = 0x8250;
}  // namespace emergency

}  // namespace geodesic::drivers::cia402
