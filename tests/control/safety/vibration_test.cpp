// The vibration detector on swings made here, and in a closed loop in closed form: one inertia,
// quantised velocity, a cycle and a half of delay.
#include "control/safety/vibration.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/control/planar_arm.hpp"

namespace geodesic::control {
namespace {

struct SwingBench {
  ControllerOptions options = testing::planar_options();
  std::array<BitSet, kMaxJoints> coupled{};
  Vibration detector{coupled};
  double t = 0.0;

  SwingBench() {
    coupled[0] = coupled[1] = 3U;
    detector = Vibration(coupled);
    options.joints[0].vibration_velocity = 0.3;
    options.joints[1].vibration_velocity = 0.3;
  }
  /// Swings joint 0; torque leads velocity by `lead` radians of phase (0: feeds it, pi: brakes it).
  /// @return largest set of vibrating joints seen.
  BitSet swing(double hz, double amplitude, double lead, double seconds, double drift = 0.0) {
    BitSet seen = 0;
    for (int i = 0; i < static_cast<int>(seconds * 1000.0); ++i) {
      t += 1e-3;
      const double angle = 2.0 * std::numbers::pi * hz * t;
      std::array<double, kMaxJoints> velocity{};
      std::array<double, kMaxJoints> torque{};
      velocity[0] = amplitude * std::sin(angle) + drift;
      torque[0] = 2.0 * std::sin(angle + lead) + 7.0;  // gravity does not count
      detector.update(options, velocity, torque, 3U, 1e-3);
      seen |= detector.vibrating();
    }
    return seen;
  }
};

TEST(Vibration, ASwingThatTheLoopFeedsLowersTheArmsGains) {
  for (const double hz : {8.0, 25.0, 60.0, 120.0}) {
    SwingBench bench;
    EXPECT_EQ(bench.swing(hz, 0.5, 0.3, 10.5 / hz + 0.1), 1U) << hz;
    EXPECT_LE(bench.detector.target(0), 0.5) << hz;
    EXPECT_EQ(bench.detector.target(1), bench.detector.target(0)) << hz;  // they share it
    EXPECT_NEAR(bench.detector.swing(0), 0.5, 0.1) << hz;
  }
}

TEST(Vibration, OtherMotionIsNone) {
  EXPECT_EQ(SwingBench{}.swing(25.0, 0.2, 0.3, 5.0), 0U);               // small
  EXPECT_EQ(SwingBench{}.swing(3.0, 2.0, 0.3, 5.0), 0U);                // slow: a hand
  EXPECT_EQ(SwingBench{}.swing(25.0, 0.5, std::numbers::pi, 5.0), 0U);  // braked: fed from outside
  EXPECT_EQ(SwingBench{}.swing(330.0, 0.5, 0.3, 5.0), 0U);              // faster than any loop
  SwingBench off;
  off.options.joints[0].vibration_velocity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(off.swing(25.0, 50.0, 0.3, 5.0), 0U);
}

TEST(Vibration, GainsFallSmoothlyStepByStepAndStayUntilSomebodyAsks) {
  SwingBench bench;
  double last = 1.0;
  for (int i = 0; i < 2000 && bench.detector.persistent() == 0; ++i) {
    bench.swing(40.0, 0.5, 0.0, 0.001);
    const double now = bench.detector.authority(0);
    EXPECT_LE(now, last);
    EXPECT_GE(now, last - 0.021);
    last = now;
  }
  EXPECT_EQ(bench.detector.persistent(), 1U);
  EXPECT_EQ(last, 0.125);
  bench.swing(40.0, 0.0, 0.0, 60.0);
  EXPECT_EQ(bench.detector.authority(0), 0.125);
  EXPECT_EQ(bench.detector.vibrating(), 0U);
  bench.detector.recover();
  EXPECT_EQ(bench.detector.persistent(), 0U);
  bench.swing(40.0, 0.0, 0.0, 0.1);
  EXPECT_NEAR(bench.detector.authority(0), 0.225, 0.01);  // not at once
  bench.swing(40.0, 0.0, 0.0, 1.0);
  EXPECT_EQ(bench.detector.authority(0), 1.0);
}

/// A joint under a damper that is too strong for its delay. @return the swing at the end.
double damped_joint(bool watched, Vibration& detector, const ControllerOptions& options) {
  constexpr double kInertia = 0.02;
  constexpr double kDamping = 25.0;  // delay * damping / inertia = 1.9 > pi / 2: unstable
  constexpr double kQuantum = 0.022;
  double v = 0.05;
  double commanded = 0.0;
  double acting = 0.0;
  double late = 0.0;
  for (int i = 0; i < 4000; ++i) {
    const double seen = std::floor(v / kQuantum) * kQuantum;
    std::array<double, kMaxJoints> velocity{};
    std::array<double, kMaxJoints> torque{};
    velocity[0] = seen;
    torque[0] = acting;
    detector.update(options, velocity, torque, 1U, 1e-3);
    acting = commanded;
    commanded = std::clamp(-(watched ? detector.authority(0) : 1.0) * kDamping * seen, -8.0, 8.0);
    v += (acting - 0.02 * v) / kInertia * 1e-3;
    late = i >= 3000 ? std::max(late, std::abs(v)) : 0.0;
  }
  return late;
}

TEST(Vibration, ADamperTooStrongForItsDelaySwingsWithoutAndSettlesWith) {
  SwingBench bench;
  EXPECT_GT(damped_joint(false, bench.detector, bench.options), 0.3);
  SwingBench other;
  EXPECT_LT(damped_joint(true, other.detector, other.options), 0.1);
  EXPECT_LT(other.detector.authority(0), 1.0);
  EXPECT_EQ(other.detector.persistent(), 0U);
}

}  // namespace
}  // namespace geodesic::control
