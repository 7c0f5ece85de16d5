// The histogram against exact percentiles of the sorted samples, and under a concurrent reader.
#include "rt/histogram.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <memory>
#include <random>
#include <thread>
#include <vector>

namespace geodesic::rt {
namespace {

std::int64_t nearest_rank(const std::vector<std::int64_t>& sorted, std::int64_t per_mille) {
  const auto size = static_cast<std::int64_t>(sorted.size());
  const std::int64_t rank = std::max<std::int64_t>((per_mille * size + 999) / 1000, 1);
  return sorted[static_cast<std::size_t>(rank - 1)];
}

void expect_matches(std::vector<std::int64_t> samples) {
  const auto histogram = std::make_unique<Histogram>();
  for (const std::int64_t sample : samples) histogram->add(sample);
  std::sort(samples.begin(), samples.end());
  EXPECT_EQ(histogram->count(), samples.size());
  EXPECT_EQ(histogram->min(), samples.front());
  EXPECT_EQ(histogram->max(), samples.back());
  for (const std::int64_t per_mille : {0, 1, 10, 100, 250, 500, 750, 900, 990, 999, 1000}) {
    const auto exact = static_cast<double>(nearest_rank(samples, per_mille));
    const auto found =
        static_cast<double>(histogram->percentile(static_cast<double>(per_mille) / 10.0));
    EXPECT_LE(std::abs(found - exact), 0.01 * exact) << per_mille << " of 1000";
  }
}

TEST(Histogram, EmptyReadsZero) {
  const Histogram histogram;
  EXPECT_EQ(histogram.count(), 0U);
  EXPECT_EQ(histogram.min(), 0);
  EXPECT_EQ(histogram.max(), 0);
  EXPECT_EQ(histogram.percentile(50.0), 0);
}

TEST(Histogram, OneSampleIsEveryPercentile) {
  Histogram histogram;
  histogram.add(123'456'789);
  for (const double percent : {-1.0, 0.0, 50.0, 99.9, 100.0, 200.0}) {
    EXPECT_EQ(histogram.percentile(percent), 123'456'789) << percent;
  }
}

TEST(Histogram, SmallValuesAreExact) {
  Histogram histogram;
  for (std::int64_t value = 0; value < 100; ++value) histogram.add(value);
  EXPECT_EQ(histogram.percentile(50.0), 49);
  EXPECT_EQ(histogram.percentile(99.0), 98);
}

TEST(Histogram, EveryMagnitudeIsWithinOnePercent) {
  for (std::int64_t value = 1; value < std::int64_t{1} << 40; value += value / 97 + 1) {
    Histogram histogram;
    histogram.add(0);
    histogram.add(value);
    histogram.add(INT64_MAX);
    const std::int64_t found = histogram.percentile(50.0);
    ASSERT_LE(std::abs(found - value) * 100, value) << value;
  }
}

TEST(Histogram, DistributionsMatchSortedSamples) {
  std::mt19937_64 random(2);
  std::vector<std::int64_t> samples(20'000);

  std::uniform_int_distribution<std::int64_t> uniform(0, 1'000'000);
  for (auto& sample : samples) sample = uniform(random);
  expect_matches(samples);

  std::lognormal_distribution<double> tailed(std::log(5000.0), 1.5);
  for (auto& sample : samples) sample = static_cast<std::int64_t>(tailed(random));
  expect_matches(samples);

  std::bernoulli_distribution outlier(0.001);
  for (auto& sample : samples) sample = outlier(random) ? 8'000'000 : 3700;
  expect_matches(samples);
}

TEST(Histogram, WhatIsOutOfRangeIsKeptAtTheEnds) {
  Histogram histogram;
  histogram.add(-5);
  histogram.add(1000);
  histogram.add(INT64_MAX);
  EXPECT_EQ(histogram.count(), 3U);
  EXPECT_EQ(histogram.min(), 0);
  EXPECT_EQ(histogram.max(), INT64_MAX);
  EXPECT_EQ(histogram.percentile(100.0), INT64_MAX);
}

TEST(Histogram, ReaderNeverSeesNonsenseWhileTheWriterWrites) {
  Histogram histogram;
  std::atomic<bool> done{false};
  std::thread writer([&] {
    for (std::int64_t i = 0; i < 300'000; ++i) histogram.add(1000 + i % 1000);
    done.store(true, std::memory_order_release);
  });
  std::uint64_t before = 0;
  while (!done.load(std::memory_order_acquire)) {
    const std::uint64_t count = histogram.count();
    ASSERT_GE(count, before);
    before = count;
    if (count == 0) continue;
    const std::int64_t median = histogram.percentile(50.0);
    ASSERT_GE(median, 1000);
    ASSERT_LE(median, 2000);
    ASSERT_LE(histogram.min(), histogram.max());
  }
  writer.join();
  EXPECT_EQ(histogram.count(), 300'000U);
}

}  // namespace
}  // namespace geodesic::rt
