// A histogram of durations of fixed size, for one writer in real time and any number of readers.
// Knows nothing of what it measures.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

namespace geodesic::rt {

/// Log-linear: below 128 ns every value has a bucket, above it each octave has 64, so a percentile
/// is at most 0.8 % off; min, max and count are exact. Ends at 2^40 ns (18 minutes): what is longer
/// falls into the last bucket. 18 KB, of which a loop touches a few cache lines.
///
/// One thread may add(); any thread may read at the same time. A reader sees a count and at least
/// the samples that belong to it, never a torn number.
class Histogram {
 public:
  /// @param ns  duration [ns]; a negative one counts as 0. Real-time, O(1), writer only.
  void add(std::int64_t ns) noexcept;

  std::uint64_t count() const noexcept { return count_.load(std::memory_order_acquire); }
  /// Smallest and largest sample [ns]; 0 while there is none.
  std::int64_t min() const noexcept;
  std::int64_t max() const noexcept;

  /// The value that `percent` of 100 of the samples do not exceed (nearest rank), e.g. 99.9 [ns].
  /// 0 while there is no sample; `percent` beyond 0..100 reads as the nearer end. O(buckets).
  std::int64_t percentile(double percent) const noexcept;

 private:
  static constexpr int kSubBits = 6;    // 2^6 buckets an octave
  static constexpr int kExactBits = 7;  // below 2^7 a bucket is 1 ns wide
  static constexpr int kEndBits = 40;   // the last octave ends at 2^40 ns
  static constexpr std::size_t kExact = 1U << kExactBits;
  static constexpr std::size_t kSub = 1U << kSubBits;
  static constexpr std::size_t kBuckets = kExact + kSub * (kEndBits - kExactBits);

  static std::size_t bucket_of(std::int64_t ns) noexcept;
  static std::int64_t middle_of(std::size_t bucket) noexcept;

  std::atomic<std::uint64_t> count_{0};
  std::atomic<std::int64_t> min_{INT64_MAX};
  std::atomic<std::int64_t> max_{0};
  std::array<std::atomic<std::uint64_t>, kBuckets> buckets_{};
};

}  // namespace geodesic::rt
