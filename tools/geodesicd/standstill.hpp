// Notices that the real-time thread stands still, from its count of cycles. Pure: time is handed
// in.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>

namespace geodesic::tools {

class Standstill {
 public:
  using Milliseconds = std::chrono::milliseconds;

  explicit Standstill(Milliseconds limit) noexcept : limit_(limit) {}

  /// @param cycles   the count now; watching begins with the first cycle
  /// @param elapsed  since the last call. A long gap counts as kMost only: if this thread did not
  ///                 run either (the process was stopped, the machine slept), it proves nothing.
  /// @return true once the count has stood for longer than the limit, and for as long as it stands.
  bool update(std::uint64_t cycles, Milliseconds elapsed) noexcept {
    if (cycles == 0 || cycles != cycles_) {
      cycles_ = cycles;
      stood_ = Milliseconds::zero();
    } else {
      stood_ += std::min(elapsed, kMost);
    }
    return stood_ > limit_;
  }

 private:
  static constexpr Milliseconds kMost{50};

  Milliseconds limit_;
  Milliseconds stood_{0};
  std::uint64_t cycles_ = 0;
};

}  // namespace geodesic::tools
