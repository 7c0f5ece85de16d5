// When the cycles of a periodic loop are due: a grid of absolute deadlines that never moves. Pure
// arithmetic; reading the clock and sleeping are the caller's.
#pragma once

#include <cstdint>

namespace geodesic::rt {

/// The grid due = first + index * period. A cycle that ends after the next deadline costs whole
/// periods, which are counted; the deadlines stay where they were, so the phase against the drives
/// and the bus is kept for ever.
class Schedule {
 public:
  /// @param first_due_ns  deadline of index 0 [ns]    @param period_ns  [ns], > 0
  constexpr Schedule(std::int64_t first_due_ns, std::int64_t period_ns) noexcept
      : period_ns_(period_ns), due_ns_(first_due_ns) {}

  /// Place of the current cycle in the grid; skipped periods count, so indices may have gaps.
  constexpr std::int64_t index() const noexcept { return index_; }
  /// Deadline of the current cycle [ns].
  constexpr std::int64_t due_ns() const noexcept { return due_ns_; }
  /// Periods skipped between the last cycle and the current one.
  constexpr std::int64_t skipped() const noexcept { return skipped_; }

  /// The current cycle ended at `end_ns`: moves on to the first later deadline that is not past. A
  /// cycle that ends exactly on the next deadline is in time.
  /// @return whether the cycle overran, that is, ended after the next deadline. Real-time.
  constexpr bool finish(std::int64_t end_ns) noexcept {
    due_ns_ += period_ns_;
    ++index_;
    skipped_ = 0;
    const std::int64_t late_ns = end_ns - due_ns_;
    if (late_ns <= 0) return false;
    skipped_ = (late_ns - 1) / period_ns_ + 1;
    due_ns_ += skipped_ * period_ns_;
    index_ += skipped_;
    return true;
  }

 private:
  std::int64_t period_ns_;
  std::int64_t due_ns_;
  std::int64_t index_ = 0;
  std::int64_t skipped_ = 0;
};

}  // namespace geodesic::rt
