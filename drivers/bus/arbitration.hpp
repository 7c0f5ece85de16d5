// Who wins the bus: the order of waiting frames. No sockets, no time.
#pragma once

#include <cstdint>

#include "drivers/bus/frame.hpp"

namespace geodesic::drivers {

/// The smaller key wins: bits are compared as on the wire, dominant 0 first. So a lower identifier
/// wins; of equal ones data (RTR 0) before a remote frame (RTR 1), and either before a 29-bit one
/// with the same first 11 bits, which has two recessive bits (SRR, IDE) after them.
/// Source: Bosch CAN 2.0 (1991), part B, 3.1.1. Error frames wait for nobody.
inline std::uint32_t arbitration_key(const Frame& frame) noexcept {
  constexpr int kFirst = 21;  // where the first 11 bits begin
  constexpr std::uint32_t kRtrOrSrr = 1U << 20;
  constexpr std::uint32_t kIde = 1U << 19;
  constexpr std::uint32_t kLast18 = (1U << 18) - 1;
  if (frame.error) {
    return 0;
  }
  const std::uint32_t remote = frame.remote ? 1 : 0;
  if (!frame.extended) {
    return (frame.id & 0x7FFU) << kFirst | (frame.remote ? kRtrOrSrr : 0U);
  }
  return (frame.id >> 18 & 0x7FFU) << kFirst | kRtrOrSrr | kIde | (frame.id & kLast18) << 1 |
         remote;
}

}  // namespace geodesic::drivers
