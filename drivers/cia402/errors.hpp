// Names of what a CiA 402 drive complains about: emergency codes, and why it aborts a transfer.
#pragma once

#include <cstdint>

namespace geodesic::drivers::cia402 {

/// An emergency code has 16 bits, DriveState::error has 8: codes that matter at the bench have a
/// number of their own, others that of their class. 0: no error. Real-time.
std::uint8_t error_of(std::uint16_t emergency_code) noexcept;
/// A code of that number; vendor-specific (0xFF00 and up) where there is none.
std::uint16_t emergency_of(std::uint8_t error) noexcept;
/// In words, a literal; "unknown error" where there is none.
const char* error_name(std::uint8_t error);

/// Of a fault whose emergency has not been seen.
inline constexpr std::uint8_t kUnspecifiedFault = 1;

/// What the drive means by aborting a transfer with that code, and what to do; a literal.
/// Real-time.
const char* abort_meaning(std::uint32_t code) noexcept;

}  // namespace geodesic::drivers::cia402
