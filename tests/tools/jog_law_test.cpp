// The jog law by itself and on a simulated joint: bounds, dead-man, and everything that must end
// it.
#include "tools/geodesic/jog_law.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>

namespace geodesic::tools::test {
namespace {

using control::DriveCondition;
using control::DriveMode;

constexpr std::int64_t kMs = 1'000'000;

/// A joint that obeys: J dv/dt = torque + load - b v; the drive is enabled a cycle after the ask.
struct Joint {
  explicit Joint(double with_inertia = 0.01) : inertia(with_inertia) {
    options.torque = 0.5;
    options.velocity = 0.5;
    options.lower = -0.25;
    options.upper = 0.25;
    options.overrun = 0.025;
    law = JogLaw(options);
    state.condition = DriveCondition::kDisabled;
    state.temperature_c = 30.0;
  }

  void cycle(double asked, bool held = true) {
    now_ns += kMs;
    if (!silent) state.stamp_ns = now_ns;
    if (held) request = {asked, now_ns};
    const control::JointCommand command = law.update(now_ns, state, request);
    EXPECT_LE(std::abs(command.torque), options.torque);
    EXPECT_TRUE(command.mode == DriveMode::kEnable || command.torque == 0.0);
    EXPECT_EQ(command.stiffness, 0.0);
    EXPECT_EQ(command.damping, 0.0);
    peak = std::max(peak, std::abs(command.torque));
    const bool on = state.condition == DriveCondition::kEnabled;
    const double torque = on && command.mode == DriveMode::kEnable ? command.torque : 0.0;
    if (!stuck) {
      state.condition =
          command.mode == DriveMode::kEnable ? DriveCondition::kEnabled : DriveCondition::kDisabled;
    }
    state.velocity += (torque + load - 0.01 * state.velocity) / inertia * 1e-3;
    state.position += state.velocity * 1e-3;
    fastest = std::max(fastest, std::abs(state.velocity));
  }
  void run(int ms, double asked, bool held = true) {
    for (int i = 0; i < ms; ++i) cycle(asked, held);
  }

  double inertia;
  JogOptions options;
  JogLaw law{JogOptions{}};
  control::JointState state;
  JogRequest request;
  std::int64_t now_ns = 1'000'000'000;
  double load = 0.0;
  double peak = 0.0;
  double fastest = 0.0;
  bool stuck = false;
  bool silent = false;
};

TEST(JogLaw, PushesWithinItsBoundsAndStopsAtTheEndOfTravel) {
  for (const double inertia : {0.002, 0.01, 0.1}) {
    Joint joint(inertia);
    joint.run(10000, 0.5);
    EXPECT_NE(joint.law.phase(), JogPhase::kFault) << inertia << ": " << joint.law.reason();
    EXPECT_LE(joint.fastest, 1.05 * joint.options.velocity) << inertia;
    EXPECT_NEAR(joint.state.position, 0.25, 0.01) << inertia;
    joint.run(10000, -0.5);
    EXPECT_NEAR(joint.state.position, -0.25, 0.01) << inertia;
    EXPECT_LE(joint.peak, 0.5);
  }
}

TEST(JogLaw, LetsGoOfWhatIsTooHeavyToStopInTime) {
  Joint joint(2.0);
  joint.run(10000, 0.5);
  EXPECT_EQ(joint.law.phase(), JogPhase::kFault);
  EXPECT_NE(joint.law.reason().find("beyond the travel"), std::string::npos) << joint.law.reason();
  EXPECT_LE(joint.fastest, joint.options.velocity);
}

TEST(JogLaw, BeginsSoftly) {
  Joint joint;
  joint.run(5, 0.5);
  ASSERT_EQ(joint.law.phase(), JogPhase::kPushing);
  EXPECT_LT(joint.law.torque(), 0.5 * 0.03);
  joint.state.velocity = 0.0;
  joint.run(20, 0.5);
  EXPECT_LT(joint.law.torque(), 0.5 * 0.15);
}

TEST(JogLaw, LetsGoWhenNobodyAsksAnyMore) {
  Joint joint;
  joint.run(100, 0.5);
  ASSERT_EQ(joint.law.phase(), JogPhase::kPushing);
  joint.run(199, 0.0, false);
  EXPECT_EQ(joint.law.phase(), JogPhase::kPushing) << joint.law.reason();
  joint.run(2, 0.0, false);
  EXPECT_EQ(joint.law.phase(), JogPhase::kIdle);
  EXPECT_EQ(joint.law.torque(), 0.0);
  EXPECT_EQ(joint.state.condition, DriveCondition::kDisabled);
  joint.run(2000, 0.0, false);
  EXPECT_EQ(joint.law.phase(), JogPhase::kIdle);
  joint.state.velocity = 0.0;
  joint.state.position = 0.0;
  joint.run(50, 0.5);  // asked for again: it begins softly again
  EXPECT_EQ(joint.law.phase(), JogPhase::kPushing);
  EXPECT_LT(joint.law.torque(), 0.5 * 0.3);
  joint.run(1, 0.0);  // let go by a word
  EXPECT_EQ(joint.law.phase(), JogPhase::kIdle);
}

TEST(JogLaw, NeverBeginsUnaskedOrByNonsense) {
  Joint joint;
  joint.run(500, 0.0);
  joint.run(10, std::nan(""));
  joint.run(10, INFINITY);
  EXPECT_EQ(joint.law.phase(), JogPhase::kIdle);
  EXPECT_EQ(joint.peak, 0.0);
  joint.run(100, 50.0);  // more than the bound is the bound
  EXPECT_LE(joint.peak, 0.5);
  EXPECT_GT(joint.peak, 0.0);
}

TEST(JogLaw, BrakesWhatFallsAndGivesUpWhenItCannot) {
  Joint light;
  light.load = 0.3;  // less than the bound: braked, though it cannot be held
  light.run(300, 0.5);
  EXPECT_LT(light.fastest, 1.0);
  EXPECT_NE(light.law.phase(), JogPhase::kFault) << light.law.reason();
  Joint heavy(0.05);
  heavy.load = 2.0;
  heavy.run(3000, 0.5);
  EXPECT_EQ(heavy.law.phase(), JogPhase::kFault);
  EXPECT_EQ(heavy.law.torque(), 0.0);
}

std::string fault_after(const std::function<void(Joint&)>& happens, int ms = 10) {
  Joint joint;
  joint.run(150, 0.5);
  EXPECT_EQ(joint.law.phase(), JogPhase::kPushing);
  happens(joint);
  joint.run(ms, 0.5);
  EXPECT_EQ(joint.law.phase(), JogPhase::kFault);
  // Whatever is asked for afterwards, it stays out.
  const std::string reason = joint.law.reason();
  joint.state.condition = DriveCondition::kDisabled;
  joint.state.velocity = 0.0;
  joint.state.position = 0.0;
  joint.stuck = false;
  joint.silent = false;
  const double peak = joint.peak;
  joint.run(300, 0.0);
  joint.run(300, 0.5);
  EXPECT_EQ(joint.law.phase(), JogPhase::kFault);
  EXPECT_EQ(joint.law.torque(), 0.0);
  EXPECT_EQ(joint.peak, peak);
  EXPECT_EQ(joint.law.reason(), reason);
  return reason;
}

bool has(const std::string& text, const char* part) {
  return text.find(part) != std::string::npos;
}

TEST(JogLaw, EndsForGoodByWhateverIsWrong) {
  EXPECT_TRUE(has(fault_after([](Joint& j) { j.state.velocity = -1.2; }, 1), "the bound of 0.5"));
  EXPECT_TRUE(has(fault_after([](Joint& j) { j.state.position = 0.3; }, 1), "beyond the travel"));
  EXPECT_TRUE(has(fault_after([](Joint& j) { j.state.position = std::nan(""); }, 1), "no number"));
  EXPECT_TRUE(has(fault_after([](Joint& j) { j.state.velocity = std::nan(""); }, 1), "no number"));
  EXPECT_TRUE(has(fault_after([](Joint& j) { j.state.temperature_c = 90.0; }, 1), "90"));
  EXPECT_TRUE(has(fault_after([](Joint& j) { j.silent = true; }, 25), "silent"));
  EXPECT_TRUE(has(fault_after([](Joint& j) { j.now_ns += 60 * kMs; }, 1), "held up"));
  const auto becomes = [](DriveCondition condition) {
    return [condition](Joint& j) {
      j.state.condition = condition;
      j.stuck = true;
    };
  };
  EXPECT_TRUE(has(fault_after(becomes(DriveCondition::kError), 1), "error"));
  EXPECT_TRUE(has(fault_after(becomes(DriveCondition::kRefused), 1), "contradicts"));
  EXPECT_TRUE(has(fault_after(becomes(DriveCondition::kDisabled), 1), "by itself"));
  EXPECT_TRUE(has(fault_after([](Joint& j) { j.law.fail("another drive"); }, 1), "another drive"));
}

TEST(JogLaw, GivesUpADriveThatDoesNotFollow) {
  Joint never;
  never.stuck = true;
  never.run(1100, 0.5);
  EXPECT_EQ(never.law.phase(), JogPhase::kFault);
  EXPECT_TRUE(has(never.law.reason(), "does not become enabled"));
  EXPECT_EQ(never.peak, 0.0);
  Joint stays;
  stays.run(100, 0.5);
  stays.stuck = true;
  stays.run(800, 0.0);
  EXPECT_EQ(stays.law.phase(), JogPhase::kFault);
  EXPECT_TRUE(has(stays.law.reason(), "does not become disabled"));
}

}  // namespace
}  // namespace geodesic::tools::test
