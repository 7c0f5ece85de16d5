// The arithmetic of the histogram: which bucket, which value, which rank.
#include "rt/histogram.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace geodesic::rt {

void Histogram::add(std::int64_t ns) noexcept {
  // One writer: load and store need not be one step. The count is stored last, with release, so
  // that whoever acquires it finds at least that many samples, and min and max that cover them.
  const std::int64_t value = std::max<std::int64_t>(ns, 0);
  if (value < min_.load(std::memory_order_relaxed)) min_.store(value, std::memory_order_relaxed);
  if (value > max_.load(std::memory_order_relaxed)) max_.store(value, std::memory_order_relaxed);
  std::atomic<std::uint64_t>& bucket = buckets_[bucket_of(value)];
  bucket.store(bucket.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
  count_.store(count_.load(std::memory_order_relaxed) + 1, std::memory_order_release);
}

std::int64_t Histogram::min() const noexcept {
  return count() == 0 ? 0 : min_.load(std::memory_order_relaxed);
}

std::int64_t Histogram::max() const noexcept {
  return count() == 0 ? 0 : max_.load(std::memory_order_relaxed);
}

std::int64_t Histogram::percentile(double percent) const noexcept {
  const std::uint64_t samples = count();
  if (samples == 0) return 0;
  const double part = std::clamp(percent, 0.0, 100.0) / 100.0;
  // The tiny subtraction keeps 99.9 % of 1000 at rank 999, whatever the product rounds to.
  const double exact_rank = std::ceil(part * static_cast<double>(samples) * (1.0 - 1e-12));
  const std::uint64_t rank =
      std::clamp<std::uint64_t>(static_cast<std::uint64_t>(exact_rank), 1, samples);
  const std::int64_t lowest = min_.load(std::memory_order_relaxed);
  const std::int64_t highest = max_.load(std::memory_order_relaxed);
  if (rank == 1) return lowest;
  if (rank == samples) return highest;

  std::uint64_t below = 0;
  for (std::size_t bucket = 0; bucket < kBuckets; ++bucket) {
    below += buckets_[bucket].load(std::memory_order_relaxed);
    if (below >= rank) return std::clamp(middle_of(bucket), lowest, highest);
  }
  return highest;  // not reached: the buckets hold at least `samples`
}

std::size_t Histogram::bucket_of(std::int64_t ns) noexcept {
  const auto value = static_cast<std::uint64_t>(ns);
  if (value < kExact) return static_cast<std::size_t>(value);
  const int exponent = static_cast<int>(std::bit_width(value)) - 1;
  if (exponent >= kEndBits) return kBuckets - 1;
  const auto octave = static_cast<std::size_t>(exponent - kExactBits);
  const auto within = static_cast<std::size_t>(value >> (exponent - kSubBits)) - kSub;
  return kExact + octave * kSub + within;
}

std::int64_t Histogram::middle_of(std::size_t bucket) noexcept {
  if (bucket < kExact) return static_cast<std::int64_t>(bucket);
  const std::size_t octave = (bucket - kExact) / kSub;
  const std::size_t within = (bucket - kExact) % kSub;
  const std::size_t shift = octave + kExactBits - kSubBits;
  const std::uint64_t lower = std::uint64_t{kSub + within} << shift;
  const std::uint64_t half = (std::uint64_t{1} << shift) / 2;
  return static_cast<std::int64_t>(lower + half);
}

}  // namespace geodesic::rt
