// The frame by which simulated time passes: the host ends each cycle on each bus with it, and the
// simulated arm ends its answers with the same. On virtual buses only; no drive knows it.
#pragma once

#include <cstdint>

#include "drivers/bus/frame.hpp"

namespace geodesic::drivers {

inline constexpr std::uint32_t kTickId = 0x1FFFFFFF;  ///< 29 bits; loses every arbitration

inline Frame tick_frame() noexcept {
  Frame frame;
  frame.id = kTickId;
  frame.extended = true;
  return frame;
}

constexpr bool is_tick(const Frame& frame) noexcept {
  return frame.extended && frame.id == kTickId && !frame.error;
}

}  // namespace geodesic::drivers
