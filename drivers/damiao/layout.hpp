// Where things stand in Damiao frames: the one table that the codec and the simulated drive share.
// Facts only; how numbers become codes is computed by each side for itself. Sources: README.md.
#pragma once

#include <array>
#include <cstdint>

#include "drivers/bit_field.hpp"

namespace geodesic::drivers::damiao {

/// MIT command, to ESC_ID.
namespace mit {
inline constexpr Field kPosition{0, 16};
inline constexpr Field kVelocity{16, 12};
inline constexpr Field kStiffness{28, 12};
inline constexpr Field kDamping{40, 12};
inline constexpr Field kTorque{52, 12};
inline constexpr double kMaxStiffness = 500.0;  ///< [N·m/rad]; the least is 0
inline constexpr double kMaxDamping = 5.0;      ///< [N·m·s/rad]; the least is 0
}  // namespace mit

/// State report, to MST_ID. Position, velocity and torque span +-PMAX, +-VMAX, +-TMAX.
namespace report {
inline constexpr Field kStatus{0, 4};
inline constexpr Field kMotor{4, 4};  ///< low four bits of ESC_ID
inline constexpr Field kPosition{8, 16};
inline constexpr Field kVelocity{24, 12};
inline constexpr Field kTorque{36, 12};
inline constexpr Field kMosfetTemperature{48, 8};  ///< [°C]
inline constexpr Field kRotorTemperature{56, 8};   ///< [°C]
}  // namespace report

/// Register frame: byte 0, 1 ESC_ID; byte 2 operation; byte 3 register; bytes 4 to 7 value, all
/// little-endian. Requests go to kRegisterId, answers come to MST_ID.
inline constexpr std::uint32_t kRegisterId = 0x7FF;

enum class Operation : std::uint8_t {
  kRead = 0x33,
  kWrite = 0x55,  ///< volatile
  kSave = 0xAA,   ///< all registers to flash, only while disabled
  kState = 0xCC,  ///< asks for a state report
};

/// Seven bytes 0xFF and one of these, to ESC_ID.
enum class Special : std::uint8_t {
  kClearError = 0xFB,
  kEnable = 0xFC,
  kDisable = 0xFD,
  kSetZero = 0xFE,
};

enum class ControlMode : std::uint8_t {
  kMit = 1,
  kPositionVelocity = 2,
  kVelocity = 3,
  kPositionForce = 4,
};
/// Commands of mode m go to ESC_ID + kModeOffset * (m - 1).
inline constexpr std::uint32_t kModeOffset = 0x100;

/// Status nibble. Others than these are not documented.
enum class Status : std::uint8_t {
  kDisabled = 0,
  kEnabled = 1,
  kOverVoltage = 8,
  kUnderVoltage = 9,
  kOverCurrent = 10,
  kMosfetOverTemperature = 11,
  kRotorOverTemperature = 12,
  kCommunicationLost = 13,
  kOverload = 14,
};

/// One count of the TIMEOUT register; 0 there is no watchdog.
inline constexpr std::int64_t kTimeoutUnitNs = 50'000;

enum class Register : std::uint8_t {
  kOverTemperature = 2,
  kReplyId = 7,
  kId = 8,
  kTimeout = 9,
  kControlMode = 10,
  kHardware = 13,
  kFirmware = 14,
  kPositionRange = 21,
  kVelocityRange = 22,
  kTorqueRange = 23,
  kBitRate = 35,
  kSubVersion = 36,
};

struct RegisterFact {
  std::uint8_t number;
  const char* name;
  const char* unit;
  bool integer;  ///< uint32; else float32
  bool writable;
};

inline constexpr std::array kRegisters = {
    RegisterFact{0, "UV_Value", "V", false, true},
    RegisterFact{1, "KT_Value", "N·m/A", false, true},
    RegisterFact{2, "OT_Value", "°C", false, true},
    RegisterFact{3, "OC_Value", "p.u.", false, true},
    RegisterFact{4, "ACC", "rad/s²", false, true},
    RegisterFact{5, "DEC", "rad/s²", false, true},
    RegisterFact{6, "MAX_SPD", "rad/s", false, true},
    RegisterFact{7, "MST_ID", "", true, true},
    RegisterFact{8, "ESC_ID", "", true, true},
    RegisterFact{9, "TIMEOUT", "50 µs", true, true},
    RegisterFact{10, "CTRL_MODE", "", true, true},
    RegisterFact{11, "Damp", "", false, false},
    RegisterFact{12, "Inertia", "", false, false},
    RegisterFact{13, "hw_ver", "", true, false},
    RegisterFact{14, "sw_ver", "", true, false},
    RegisterFact{15, "SN", "", true, false},
    RegisterFact{16, "NPP", "", true, false},
    RegisterFact{17, "Rs", "Ω", false, false},
    RegisterFact{18, "Ls", "H", false, false},
    RegisterFact{19, "Flux", "Wb", false, false},
    RegisterFact{20, "Gr", "", false, false},
    RegisterFact{21, "PMAX", "rad", false, true},
    RegisterFact{22, "VMAX", "rad/s", false, true},
    RegisterFact{23, "TMAX", "N·m", false, true},
    RegisterFact{24, "I_BW", "", false, true},
    RegisterFact{25, "KP_ASR", "", false, true},
    RegisterFact{26, "KI_ASR", "", false, true},
    RegisterFact{27, "KP_APR", "", false, true},
    RegisterFact{28, "KI_APR", "", false, true},
    RegisterFact{29, "OV_Value", "V", false, true},
    RegisterFact{30, "GREF", "", false, true},
    RegisterFact{31, "Deta", "", false, true},
    RegisterFact{32, "V_BW", "", false, true},
    RegisterFact{33, "IQ_c1", "", false, true},
    RegisterFact{34, "VL_c1", "", false, true},
    RegisterFact{35, "can_br", "", true, true},
    RegisterFact{36, "sub_ver", "", true, false},
    RegisterFact{50, "u_off", "", false, false},
    RegisterFact{51, "v_off", "", false, false},
    RegisterFact{52, "k1", "", false, false},
    RegisterFact{53, "k2", "", false, false},
    RegisterFact{54, "m_off", "", false, false},
    RegisterFact{55, "dir", "", false, false},
    RegisterFact{80, "p_m", "rad", false, false},
    RegisterFact{81, "xout", "rad", false, false},
};

/// The register of that number; null if none is known.
constexpr const RegisterFact* find_register(std::uint8_t number) noexcept {
  for (const RegisterFact& fact : kRegisters) {
    if (fact.number == number) {
      return &fact;
    }
  }
  return nullptr;
}

}  // namespace geodesic::drivers::damiao
