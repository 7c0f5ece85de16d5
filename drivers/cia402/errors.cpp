// Names of errors; see errors.hpp. Sources: CiA 301 (emergency classes, abort codes), README.md.
#include "drivers/cia402/errors.hpp"

#include <array>
#include <cstddef>

#include "drivers/cia402/layout.hpp"

namespace geodesic::drivers::cia402 {

namespace {

struct ErrorFact {
  std::uint16_t code;
  std::uint16_t mask;
  const char* name;
};

/// Its place plus one is DriveState::error: new ones go to the end. Exact codes before classes.
constexpr std::array kErrors = {
    ErrorFact{0x1000, 0xFFFF, "fault of an unspecified kind"},
    ErrorFact{0x2310, 0xFFFF, "over-current (0x2310)"},
    ErrorFact{0x3210, 0xFFFF, "DC-link over-voltage (0x3210)"},
    ErrorFact{0x3220, 0xFFFF, "DC-link under-voltage (0x3220)"},
    ErrorFact{0x4210, 0xFFFF, "device over-temperature (0x4210)"},
    ErrorFact{0x4310, 0xFFFF, "drive over-temperature (0x4310)"},
    ErrorFact{0x7305, 0xFFFF, "encoder (0x7305)"},
    ErrorFact{0x8110, 0xFFFF, "CAN overrun (0x8110)"},
    ErrorFact{0x8120, 0xFFFF, "CAN error passive (0x8120)"},
    ErrorFact{0x8130, 0xFFFF, "this host's heartbeat was missed (0x8130: the drive's watchdog)"},
    ErrorFact{0x8140, 0xFFFF, "recovered from bus-off (0x8140)"},
    ErrorFact{0x8210, 0xFFFF, "PDO too short to be processed (0x8210)"},
    ErrorFact{0x8220, 0xFFFF, "PDO too long (0x8220)"},
    ErrorFact{0x8250, 0xFFFF, "torque frames were missed (0x8250: the drive's watchdog)"},
    ErrorFact{0x8611, 0xFFFF, "following error (0x8611)"},
    ErrorFact{0x2000, 0xF000, "current (class 0x2xxx)"},
    ErrorFact{0x3000, 0xF000, "voltage (class 0x3xxx)"},
    ErrorFact{0x4000, 0xF000, "temperature (class 0x4xxx)"},
    ErrorFact{0x5000, 0xF000, "device hardware (class 0x5xxx)"},
    ErrorFact{0x6000, 0xF000, "device software (class 0x6xxx)"},
    ErrorFact{0x7000, 0xF000, "additional modules (class 0x7xxx)"},
    ErrorFact{0x8000, 0xF000, "monitoring (class 0x8xxx)"},
    ErrorFact{0x9000, 0xF000, "external error (class 0x9xxx)"},
    ErrorFact{0xFF00, 0xFF00, "vendor-specific (0xFFxx): see the drive's manual"},
    ErrorFact{0xF000, 0xF000, "additional functions (class 0xFxxx)"},
    ErrorFact{0x1000, 0xF000, "generic error (class 0x1xxx)"},
};
static_assert(kErrors[kUnspecifiedFault - 1].code == 0x1000);

struct AbortFact {
  Abort code;
  const char* meaning;
};

constexpr std::array kAborts = {
    AbortFact{Abort::kToggle, "the drive aborts (0x05030000, toggle bit): try again"},
    AbortFact{Abort::kTimeOut, "the drive aborts (0x05040000, time-out): check the bus load"},
    AbortFact{Abort::kCommand, "the drive aborts (0x05040001, unknown command): is it CANopen?"},
    AbortFact{Abort::kUnsupportedAccess,
              "the drive aborts (0x06010000, access not supported): see its manual"},
    AbortFact{Abort::kWriteOnly, "the drive aborts (0x06010001, write only): see its manual"},
    AbortFact{Abort::kReadOnly,
              "the drive aborts (0x06010002, read only): set it with the maker's tool"},
    AbortFact{Abort::kNoObject,
              "the drive aborts (0x06020000, no such object): see its manual, and whether a "
              "setting of [joint.drive] does without it"},
    AbortFact{Abort::kNotMappable,
              "the drive aborts (0x06040041, not mappable): it cannot be driven by this family"},
    AbortFact{Abort::kPdoTooLong,
              "the drive aborts (0x06040042, PDO too long): its mapping was not cleared"},
    AbortFact{Abort::kIncompatible, "the drive aborts (0x06040043, incompatible): see its manual"},
    AbortFact{Abort::kHardware, "the drive aborts (0x06060000, hardware error): see its manual"},
    AbortFact{Abort::kLength,
              "the drive aborts (0x06070010, length): the object is of another size there"},
    AbortFact{Abort::kTooLong,
              "the drive aborts (0x06070012, too long): the object is of another size there"},
    AbortFact{Abort::kTooShort,
              "the drive aborts (0x06070013, too short): the object is of another size there"},
    AbortFact{Abort::kNoSub,
              "the drive aborts (0x06090011, no such sub-index): see its manual, and whether a "
              "setting of [joint.drive] does without it"},
    AbortFact{Abort::kRange, "the drive aborts (0x06090030, out of range): see its limits"},
    AbortFact{Abort::kTooHigh, "the drive aborts (0x06090031, too high): see its limits"},
    AbortFact{Abort::kTooLow, "the drive aborts (0x06090032, too low): see its limits"},
    AbortFact{Abort::kGeneral, "the drive aborts (0x08000000, general error): see its manual"},
    AbortFact{Abort::kNotStored, "the drive aborts (0x08000020, cannot be stored): see its manual"},
    AbortFact{Abort::kLocalControl,
              "the drive aborts (0x08000021, local control): release it in the maker's tool"},
    AbortFact{Abort::kDeviceState,
              "the drive aborts (0x08000022, wrong device state): power-cycle it, try again"},
};

}  // namespace

std::uint8_t error_of(std::uint16_t emergency_code) noexcept {
  if (emergency_code == emergency::kNone) {
    return 0;
  }
  for (std::size_t i = 0; i < kErrors.size(); ++i) {
    if ((emergency_code & kErrors[i].mask) == kErrors[i].code) {
      return static_cast<std::uint8_t>(i + 1);
    }
  }
  return kUnspecifiedFault;
}

std::uint16_t emergency_of(std::uint8_t error) noexcept {
  const bool known = error >= 1 && error <= kErrors.size();
  return known ? kErrors[error - 1U].code : static_cast<std::uint16_t>(0xFF00U | error);
}

const char* error_name(std::uint8_t error) {
  return error >= 1 && error <= kErrors.size() ? kErrors[error - 1U].name : "unknown error";
}

const char* abort_meaning(std::uint32_t code) noexcept {
  for (const AbortFact& fact : kAborts) {
    if (static_cast<std::uint32_t>(fact.code) == code) {
      return fact.meaning;
    }
  }
  return "the drive aborts with a code that CiA 301 does not name: see its manual";
}

}  // namespace geodesic::drivers::cia402
