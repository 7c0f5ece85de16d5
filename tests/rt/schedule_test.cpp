// The schedule's promise: deadlines keep phase whatever a cycle takes. Pure logic, no clock.
#include "rt/schedule.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <random>

namespace geodesic::rt {
namespace {

constexpr std::int64_t kPeriod = 1'000'000;
constexpr std::int64_t kFirst = 123'456'789;

TEST(Schedule, CyclesInTimeFollowEachOtherByOnePeriod) {
  Schedule schedule(kFirst, kPeriod);
  for (std::int64_t k = 0; k < 1000; ++k) {
    EXPECT_EQ(schedule.index(), k);
    EXPECT_EQ(schedule.due_ns(), kFirst + k * kPeriod);
    EXPECT_EQ(schedule.skipped(), 0);
    EXPECT_FALSE(schedule.finish(schedule.due_ns() + k * kPeriod / 1000));
  }
}

struct Overrun {
  std::int64_t length_ns;  // from due to the end of the cycle
  std::int64_t skipped;
};

class ScheduleOverrun : public testing::TestWithParam<Overrun> {};

TEST_P(ScheduleOverrun, SkipsWholePeriodsAndKeepsPhase) {
  const auto [length_ns, skipped] = GetParam();
  Schedule schedule(kFirst, kPeriod);
  schedule.finish(kFirst);
  const std::int64_t due_ns = schedule.due_ns();
  const std::int64_t end_ns = due_ns + length_ns;
  EXPECT_EQ(schedule.finish(end_ns), skipped > 0);
  EXPECT_EQ(schedule.skipped(), skipped);
  EXPECT_EQ(schedule.due_ns(), due_ns + (1 + skipped) * kPeriod);
  EXPECT_EQ(schedule.index(), 2 + skipped);
  EXPECT_FALSE(schedule.finish(schedule.due_ns()));
  EXPECT_EQ(schedule.skipped(), 0) << "skipped periods are told once";
}

INSTANTIATE_TEST_SUITE_P(Lengths, ScheduleOverrun,
                         testing::Values(Overrun{0, 0}, Overrun{1, 0}, Overrun{kPeriod - 1, 0},
                                         Overrun{kPeriod, 0}, Overrun{kPeriod + 1, 1},
                                         Overrun{2 * kPeriod - 1, 1}, Overrun{2 * kPeriod, 1},
                                         Overrun{2 * kPeriod + 1, 2}, Overrun{10 * kPeriod, 9},
                                         Overrun{10 * kPeriod + kPeriod / 2, 10},
                                         Overrun{3'600'000 * kPeriod, 3'599'999}));

TEST(Schedule, NeverLeavesItsGridNorGoesBack) {
  std::mt19937_64 random(1);
  std::exponential_distribution<double> length(1.0);
  Schedule schedule(kFirst, kPeriod);
  std::int64_t skipped = 0;
  for (std::int64_t cycle = 0; cycle < 100'000; ++cycle) {
    const std::int64_t due_ns = schedule.due_ns();
    ASSERT_EQ(due_ns, kFirst + schedule.index() * kPeriod);
    ASSERT_EQ(schedule.index(), cycle + skipped);
    const auto end_ns = due_ns + static_cast<std::int64_t>(length(random) * 2.0 * kPeriod);
    const bool overran = schedule.finish(end_ns);
    ASSERT_GT(schedule.due_ns(), due_ns);
    ASSERT_GE(schedule.due_ns(), end_ns);
    ASSERT_EQ(overran, schedule.skipped() > 0);
    // Not one period more than needed.
    if (overran) {
      ASSERT_LT(schedule.due_ns() - end_ns, kPeriod);
    }
    skipped += schedule.skipped();
  }
  EXPECT_GT(skipped, 0);
}

}  // namespace
}  // namespace geodesic::rt
