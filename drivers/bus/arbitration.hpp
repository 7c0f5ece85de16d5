// Who wins the bus: the order of waiting frames. No sockets, no time.
#pragma once

#include <cstdint>

#include "drivers/bus/frame.hpp"

namespace geodesic::drivers {

/// The smaller key wins: bits are compared as on the wire, dominant 0 first, so a lower identifier
/// wins and an 11-bit one wins over a 29-bit one with the same first 11 bits (its IDE bit is 0).
/// Source: Bosch CAN 2.0 (1991), part B, 3.1.1. Error frames wait for nobody.
inline std::uint32_t arbitration_key(const Frame& frame) noexcept {
  constexpr std::uint32_t kIde = 1U << 18;
  if (frame.error) {
    return 0;
  }
  if (!frame.extended) {
    return (frame.id & 0x7FFU) << 19;
  }
  return (frame.id >> 18 & 0x7FFU) << 19 | kIde | (frame.id & (kIde - 1));
}

}  // namespace geodesic::drivers
