// From the kernel's wall-clock stamps to CLOCK_MONOTONIC, unharmed by steps of the wall clock. No
// sockets.
#pragma once

#include <algorithm>
#include <cstdint>

namespace geodesic::drivers {

/// A frame's age is bounded from both sides by what CLOCK_MONOTONIC alone knows: it is not from the
/// future, and it arrived after the queue was last seen empty. So a wall clock that steps by hours
/// moves a stamp by no more than the time between two reads. Real-time.
class StampClock {
 public:
  /// Both clocks, read together once a batch.
  void read(std::int64_t monotonic_ns, std::int64_t realtime_ns) noexcept {
    monotonic_ns_ = monotonic_ns;
    realtime_ns_ = realtime_ns;
  }

  /// @return arrival on CLOCK_MONOTONIC of a frame stamped `stamp_ns` on CLOCK_REALTIME.
  std::int64_t monotonic(std::int64_t stamp_ns) const noexcept {
    const std::int64_t age = realtime_ns_ - stamp_ns;
    return monotonic_ns_ - std::clamp<std::int64_t>(age, 0, monotonic_ns_ - empty_ns_);
  }

  /// The last batch left the queue empty: later frames are younger than it.
  void emptied() noexcept { empty_ns_ = monotonic_ns_; }

 private:
  std::int64_t monotonic_ns_ = 0;
  std::int64_t realtime_ns_ = 0;
  std::int64_t empty_ns_ = 0;
};

}  // namespace geodesic::drivers
