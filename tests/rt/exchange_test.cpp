// LatestValue and Ring between two threads: nothing torn, nothing out of order, losses counted.
#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <thread>

#include "rt/latest_value.hpp"
#include "rt/ring.hpp"

namespace geodesic::rt {
namespace {

/// Large enough that a torn copy would show: every word follows from the first.
struct Record {
  std::array<std::uint64_t, 32> words{};

  void fill(std::uint64_t number) {
    for (std::size_t i = 0; i < words.size(); ++i) words[i] = number * (2 * i + 1);
  }
  bool whole() const {
    for (std::size_t i = 0; i < words.size(); ++i) {
      if (words[i] != words[0] * (2 * i + 1)) return false;
    }
    return true;
  }
};

TEST(LatestValue, NothingNewUntilPublished) {
  LatestValue<int> value(7);
  EXPECT_FALSE(value.update());
  EXPECT_EQ(value.front(), 7);
  EXPECT_EQ(value.back(), 7);
  value.back() = 8;
  EXPECT_FALSE(value.update());
  value.publish();
  EXPECT_EQ(value.front(), 7) << "front() stays until the reader updates";
  EXPECT_TRUE(value.update());
  EXPECT_EQ(value.front(), 8);
  EXPECT_FALSE(value.update());
  EXPECT_EQ(value.front(), 8);
}

TEST(LatestValue, ReaderGetsTheNewestOfMany) {
  LatestValue<int> value;
  for (int i = 1; i <= 10; ++i) {
    value.back() = i;
    value.publish();
  }
  EXPECT_TRUE(value.update());
  EXPECT_EQ(value.front(), 10);
  EXPECT_FALSE(value.update());
}

TEST(LatestValue, TwoThreadsSeeWholeValuesInOrderAndTheLastOne) {
  constexpr std::uint64_t kLast = 200'000;
  LatestValue<Record> value;
  std::thread writer([&value] {
    for (std::uint64_t number = 1; number <= kLast; ++number) {
      value.back().fill(number);
      value.publish();
      if (number % 1000 == 0) std::this_thread::yield();
    }
  });
  std::uint64_t seen = 0;
  std::uint64_t torn = 0;
  std::uint64_t back_in_time = 0;
  while (seen < kLast) {
    if (!value.update()) {
      std::this_thread::yield();
      continue;
    }
    torn += value.front().whole() ? 0 : 1;
    back_in_time += value.front().words[0] > seen ? 0 : 1;
    seen = value.front().words[0];
  }
  writer.join();
  EXPECT_EQ(torn, 0U);
  EXPECT_EQ(back_in_time, 0U);
  EXPECT_FALSE(value.update());
}

TEST(Ring, FirstInFirstOutAcrossTheSeam) {
  Ring<int, 4> ring;
  int out = 0;
  EXPECT_FALSE(ring.pop(out));
  for (int i = 0; i < 1000; ++i) {
    EXPECT_TRUE(ring.push(2 * i));
    EXPECT_TRUE(ring.push(2 * i + 1));
    EXPECT_EQ(ring.size(), 2U);
    EXPECT_TRUE(ring.pop(out));
    EXPECT_EQ(out, 2 * i);
    EXPECT_TRUE(ring.pop(out));
    EXPECT_EQ(out, 2 * i + 1);
  }
  EXPECT_FALSE(ring.pop(out));
  EXPECT_EQ(ring.dropped(), 0U);
}

TEST(Ring, DropsAndCountsWhatDoesNotFit) {
  Ring<int, 4> ring;
  EXPECT_EQ(ring.capacity(), 4U);
  for (int i = 0; i < 4; ++i) EXPECT_TRUE(ring.push(i));
  EXPECT_FALSE(ring.push(4));
  EXPECT_FALSE(ring.push(5));
  EXPECT_EQ(ring.dropped(), 2U);
  EXPECT_EQ(ring.size(), 4U);
  int out = -1;
  EXPECT_TRUE(ring.pop(out));
  EXPECT_EQ(out, 0) << "the oldest are kept";
  EXPECT_TRUE(ring.push(6));
  for (const int expected : {1, 2, 3, 6}) {
    EXPECT_TRUE(ring.pop(out));
    EXPECT_EQ(out, expected);
  }
  EXPECT_EQ(ring.size(), 0U);
}

TEST(Ring, TwoThreadsLoseNothingButWhatIsCounted) {
  constexpr std::uint64_t kLast = 200'000;
  const auto ring = std::make_unique<Ring<Record, 64>>();
  std::atomic<bool> done{false};
  std::thread producer([&] {
    Record record;
    for (std::uint64_t number = 1; number <= kLast; ++number) {
      record.fill(number);
      ring->push(record);
      if (number % 100 == 0) std::this_thread::yield();
    }
    done.store(true, std::memory_order_release);
  });
  std::uint64_t received = 0;
  std::uint64_t torn = 0;
  std::uint64_t out_of_order = 0;
  std::uint64_t before = 0;
  Record record;
  while (true) {
    const bool was_done = done.load(std::memory_order_acquire);
    if (ring->pop(record)) {
      ++received;
      torn += record.whole() ? 0 : 1;
      out_of_order += record.words[0] > before ? 0 : 1;
      before = record.words[0];
    } else if (was_done) {
      break;
    } else {
      std::this_thread::yield();
    }
    ASSERT_LE(ring->size(), ring->capacity());
  }
  producer.join();
  EXPECT_EQ(torn, 0U);
  EXPECT_EQ(out_of_order, 0U);
  EXPECT_EQ(received + ring->dropped(), kLast);
}

}  // namespace
}  // namespace geodesic::rt
