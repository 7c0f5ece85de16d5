// "Latest value": hands the newest of a series of values from one thread to one other, wait-free on
// both sides. Values in between are lost by design; where none may be lost, use Ring.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>

namespace geodesic::rt {

/// Triple buffer. The writer fills back() and publishes; the reader calls update() and reads
/// front(), which stays as it is until the next update(). Neither ever waits or allocates.
template <class T>
class LatestValue {
 public:
  LatestValue() = default;
  /// All three buffers begin as copies of `initial`, so that back() is whole before the first
  /// write.
  explicit LatestValue(const T& initial) : slots_{Slot{initial}, Slot{initial}, Slot{initial}} {}
  LatestValue(const LatestValue&) = delete;
  LatestValue& operator=(const LatestValue&) = delete;

  /// Writer: the buffer to fill. After publish() it holds an older value: write every field that
  /// matters, each time. Real-time.
  T& back() noexcept { return slots_[back_].value; }

  /// Writer: what back() holds becomes the latest value. Real-time, one atomic exchange.
  void publish() noexcept {
    back_ = middle_.exchange(back_ | kFresh, std::memory_order_acq_rel) & kIndex;
  }

  /// Reader: takes the latest value if there is one not seen yet. @return whether front() changed.
  /// Real-time, at most one atomic exchange.
  bool update() noexcept {
    // Only the writer sets kFresh and only this thread clears it: a stale look costs one call, the
    // exchange below does the ordering.
    if ((middle_.load(std::memory_order_relaxed) & kFresh) == 0) return false;
    front_ = middle_.exchange(front_, std::memory_order_acq_rel) & kIndex;
    return true;
  }

  /// Reader: the value taken by the last update(), or the initial one. Real-time.
  const T& front() const noexcept { return slots_[front_].value; }

 private:
  static constexpr unsigned kFresh = 4;
  static constexpr unsigned kIndex = 3;
  static constexpr std::size_t kCacheLine = 64;

  struct alignas(kCacheLine) Slot {
    T value{};
  };
  std::array<Slot, 3> slots_{};
  alignas(kCacheLine) unsigned back_ = 0;                // writer's
  alignas(kCacheLine) std::atomic<unsigned> middle_{1};  // shared: an index, with or without kFresh
  alignas(kCacheLine) unsigned front_ = 2;               // reader's
};

}  // namespace geodesic::rt
