// The drive's error words as one code and as text. What follows from an error: driver.hpp.
#pragma once

#include <cstdint>

#include "drivers/odrive/layout.hpp"

namespace geodesic::drivers::odrive {

/// Codes are 1 + bit of the word, each word with a base of its own.
inline constexpr std::uint8_t kActiveBase = 1;       ///< 0.6, 32 bits
inline constexpr std::uint8_t kAxisBase = 33;        ///< 0.5, 32 bits
inline constexpr std::uint8_t kEncoderBase = 65;     ///< 0.5, 32 bits
inline constexpr std::uint8_t kControllerBase = 97;  ///< 0.5, 32 bits
inline constexpr std::uint8_t kMotorBase = 129;      ///< 0.5, 64 bits
inline constexpr std::uint8_t kHeartbeatLost = 193;

/// Real-time. Code of the lowest bit set; 0: none is.
constexpr std::uint8_t code_of(std::uint64_t word, std::uint8_t base) noexcept {
  return word == 0 ? std::uint8_t{0} : static_cast<std::uint8_t>(base + __builtin_ctzll(word));
}

/// A literal; "unknown error" where there is none.
const char* error_name(std::uint8_t code);
/// A literal; "unknown state" where there is none.
const char* state_name(std::uint8_t state);
/// Firmware 0.6; a literal.
const char* result_name(std::uint8_t result);

}  // namespace geodesic::drivers::odrive
