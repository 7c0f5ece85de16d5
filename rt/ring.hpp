// A queue of fixed capacity from one thread to one other, wait-free on both sides. It never
// overwrites: what does not fit is dropped and counted.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <type_traits>

namespace geodesic::rt {

/// Single producer, single consumer. The cells live in the object: put big rings on the heap before
/// the loop starts.
/// @tparam N  capacity, a power of two
template <class T, std::size_t N>
class Ring {
  static_assert(N > 0 && (N & (N - 1)) == 0, "the capacity must be a power of two");
  static_assert(std::is_nothrow_copy_assignable_v<T>, "a copy must neither throw nor allocate");

 public:
  Ring() = default;
  Ring(const Ring&) = delete;
  Ring& operator=(const Ring&) = delete;

  /// Producer: appends a copy. @return false if the ring is full: the value is dropped and counted.
  /// Real-time.
  bool push(const T& value) noexcept {
    const std::size_t head = head_.load(std::memory_order_relaxed);
    if (head - known_tail_ == N) {
      known_tail_ = tail_.load(std::memory_order_acquire);
      if (head - known_tail_ == N) {
        dropped_.store(dropped_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
        return false;
      }
    }
    cells_[head & kMask] = value;
    head_.store(head + 1, std::memory_order_release);
    return true;
  }

  /// Consumer: takes the oldest into `value`. @return false if the ring is empty. Real-time.
  bool pop(T& value) noexcept {
    const std::size_t tail = tail_.load(std::memory_order_relaxed);
    if (tail == known_head_) {
      known_head_ = head_.load(std::memory_order_acquire);
      if (tail == known_head_) return false;
    }
    value = cells_[tail & kMask];
    tail_.store(tail + 1, std::memory_order_release);
    return true;
  }

  static constexpr std::size_t capacity() noexcept { return N; }
  /// How many are waiting, as it was a moment ago. Any thread.
  std::size_t size() const noexcept {
    // The tail first: it only grows, so the difference cannot come out negative.
    const std::size_t tail = tail_.load(std::memory_order_acquire);
    const std::size_t waiting = head_.load(std::memory_order_acquire) - tail;
    return waiting < N ? waiting : N;
  }
  /// Values that push() could not place, since the start. Any thread.
  std::uint64_t dropped() const noexcept { return dropped_.load(std::memory_order_relaxed); }

 private:
  static constexpr std::size_t kMask = N - 1;
  static constexpr std::size_t kCacheLine = 64;

  // Each side keeps its own copy of the other's counter and looks at the shared one only when the
  // copy says full or empty: in steady state the two sides do not fight for cache lines.
  alignas(kCacheLine) std::atomic<std::size_t> head_{0};  // written by the producer
  std::size_t known_tail_ = 0;                            // producer's
  std::atomic<std::uint64_t> dropped_{0};                 // written by the producer
  alignas(kCacheLine) std::atomic<std::size_t> tail_{0};  // written by the consumer
  std::size_t known_head_ = 0;                            // consumer's
  alignas(kCacheLine) std::array<T, N> cells_{};
};

}  // namespace geodesic::rt
