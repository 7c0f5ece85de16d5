// Which turn a drive is in that forgets them: the band in which the joint may stand decides, or
// nobody does.
#include "drivers/turn_resolver.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

namespace geodesic::drivers {
namespace {

using Verdict = TurnResolver::Verdict;
constexpr double kTurn = 2.0 * std::numbers::pi;

TEST(TurnResolver, FindsTheOneTurnThatLiesInTheBand) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> band(-20.0, 20.0);
  std::uniform_real_distribution<double> part(0.001, 0.999);
  std::uniform_int_distribution<int> turns(-9, 9);
  for (int i = 0; i < 1000; ++i) {
    const double lower = band(random);
    const double width = part(random) * kTurn;
    const double truth = lower + part(random) * width;
    TurnResolver resolver(kTurn, lower, lower + width);
    const double reading = truth + turns(random) * kTurn;
    ASSERT_EQ(resolver.resolve(reading), Verdict::kUnique);
    EXPECT_NEAR(reading + resolver.shift(), truth, 1e-12 * 100.0);
  }
}

TEST(TurnResolver, RefusesWhatNoTurnBringsIntoTheBand) {
  TurnResolver resolver(kTurn, 0.0, 1.0);
  EXPECT_EQ(resolver.resolve(2.0), Verdict::kOutside);
  EXPECT_EQ(resolver.resolve(-kTurn + 0.5), Verdict::kUnique);
  EXPECT_EQ(resolver.resolve(std::numeric_limits<double>::quiet_NaN()), Verdict::kOutside);
}

TEST(TurnResolver, RefusesWhatTwoTurnsBringIntoTheBand) {
  TurnResolver resolver(kTurn, -4.0, 4.0);
  EXPECT_EQ(resolver.resolve(3.5), Verdict::kAmbiguous);
  EXPECT_EQ(resolver.resolve(0.0), Verdict::kUnique);
}

TEST(TurnResolver, LeavesAloneADriveThatKnowsItsTurnsOrAJointWithoutBand) {
  TurnResolver knows(0.0, -1.0, 1.0);
  EXPECT_EQ(knows.resolve(17.0), Verdict::kUnique);
  EXPECT_EQ(knows.shift(), 0.0);
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  TurnResolver anywhere(kTurn, -kInfinity, kInfinity);
  EXPECT_EQ(anywhere.resolve(17.0), Verdict::kUnique);
  EXPECT_EQ(anywhere.shift(), 0.0);
}

TEST(TurnResolver, ADriveThatWasNotOffKeepsItsTurns) {
  TurnResolver resolver(kTurn, -3.0, 3.0);
  ASSERT_EQ(resolver.resolve(kTurn + 1.0), Verdict::kUnique);
  EXPECT_TRUE(resolver.continues(kTurn + 1.2, 1.0));
  EXPECT_FALSE(resolver.continues(1.2, 1.0));  // it has lost a turn
}

}  // namespace
}  // namespace geodesic::drivers
