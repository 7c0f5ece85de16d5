// Positions and velocities at a common instant.
#include "control/estimate.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/control/planar_arm.hpp"

namespace geodesic::control {
namespace {

using testing::kPeriod;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

ArmState measured(std::int64_t cycle, double position, double velocity) {
  ArmState state;
  state.joints = 2;
  state.tick_ns = cycle * kPeriod;
  for (std::size_t i = 0; i < 2; ++i) {
    JointState& joint = state.joint[i];
    joint.position = position;
    joint.velocity = velocity;
    joint.stamp_ns = state.tick_ns + 100'000 + static_cast<std::int64_t>(i) * 200'000;
    joint.fresh = true;
  }
  return state;
}

TEST(Estimate, BringsJointsToTheNewestStamp) {
  Estimator estimator(testing::planar_options());
  const Estimate& estimate = estimator.update(measured(1, 0.5, 2.0), kPeriod);
  EXPECT_EQ(estimate.instant_ns, kPeriod + 300'000);
  EXPECT_DOUBLE_EQ(estimate.position[0], 0.5 + 2.0 * 200e-6);
  EXPECT_DOUBLE_EQ(estimate.position[1], 0.5);
  EXPECT_EQ(estimate.known, 3u);
}

TEST(Estimate, VelocityBeginsAtItsFirstMeasurement) {
  Estimator estimator(testing::planar_options());
  EXPECT_EQ(estimator.update(measured(1, 0.5, 2.0), kPeriod).velocity[0], 2.0);
}

TEST(Estimate, LowPassHasTheConfiguredTimeConstant) {
  ControllerOptions options = testing::planar_options();
  options.velocity_filter_hz = 10.0;
  Estimator estimator(options);
  estimator.update(measured(0, 0.0, 0.0), kPeriod);
  double velocity = 0.0;
  for (int i = 1; i <= 16; ++i) {  // one time constant: 1 / (2 pi 10 Hz) = 15.9 ms
    velocity = estimator.update(measured(i, 0.0, 1.0), kPeriod).velocity[0];
  }
  EXPECT_NEAR(velocity, 1.0 - std::exp(-1.0), 0.03);
  options.velocity_filter_hz = 0.0;
  Estimator raw(options);
  raw.update(measured(0, 0.0, 0.0), kPeriod);
  EXPECT_EQ(raw.update(measured(1, 0.0, 1.0), kPeriod).velocity[0], 1.0);
}

TEST(Estimate, ExtrapolatesAMissingJointForAFewPeriodsOnly) {
  ControllerOptions options = testing::planar_options();
  options.velocity_filter_hz = 0.0;
  Estimator estimator(options);
  ArmState state = measured(0, 0.5, 1.0);
  estimator.update(state, kPeriod);
  for (int i = 1; i < 20; ++i) {
    state = measured(i, 0.5 + 1e-3 * i, 1.0);
    state.joint[1].fresh = false;
    const Estimate& estimate = estimator.update(state, kPeriod);
    EXPECT_LE(std::abs(estimate.position[1] - 0.5), 3e-3 + 1e-12);
    EXPECT_EQ(estimate.velocity[1], i <= SafetyOptions{}.carry_on_cycles ? 1.0 : 0.0);
    EXPECT_EQ(estimate.fresh, 1u);
  }
}

TEST(Estimate, TimePassesWithoutAnyAnswer) {
  Estimator estimator(testing::planar_options());
  estimator.update(measured(0, 0.5, 1.0), kPeriod);
  ArmState nothing;
  nothing.joints = 2;
  const double before = estimator.update(nothing, kPeriod).position[1];
  EXPECT_NEAR(before, 0.501, 1e-12);
}

TEST(Estimate, FindsAStepThatVelocityDoesNotExplain) {
  Estimator estimator(testing::planar_options());
  estimator.update(measured(0, 0.5, 1.0), kPeriod);
  EXPECT_EQ(estimator.update(measured(1, 0.9, 1.0), kPeriod).jumped, 0u);
  EXPECT_EQ(estimator.update(measured(2, 0.3, 1.0), kPeriod).jumped, 3u);
  EXPECT_EQ(estimator.update(measured(3, 0.3, 1.0), kPeriod).jumped, 0u);
  // A velocity that no joint of this kind can have excuses no step.
  EXPECT_EQ(estimator.update(measured(4, 0.9, 1e5), kPeriod).jumped, 3u);
}

TEST(Estimate, FirstMeasurementAfterResetIsNoStep) {
  Estimator estimator(testing::planar_options());
  estimator.update(measured(0, 0.5, 1.0), kPeriod);
  estimator.reset();
  const Estimate& estimate = estimator.update(measured(1, -1.5, 0.0), kPeriod);
  EXPECT_EQ(estimate.jumped, 0u);
  EXPECT_EQ(estimate.position[1], -1.5);
}

TEST(Estimate, TakesInNothingThatIsNoMeasurement) {
  for (const double bad :
       {kNan, std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::max(), 2e6}) {
    for (double JointState::*field : {&JointState::position, &JointState::velocity,
                                      &JointState::torque, &JointState::temperature_c}) {
      Estimator estimator(testing::planar_options());
      estimator.update(measured(0, 0.5, 0.0), kPeriod);
      ArmState state = measured(1, 0.5, 0.0);
      state.joint[1].*field = bad;
      const Estimate& estimate = estimator.update(state, kPeriod);
      EXPECT_EQ(estimate.not_finite, 2u);
      EXPECT_EQ(estimate.fresh, 1u);
      EXPECT_EQ(estimate.position[1], 0.5);
    }
  }
}

TEST(Estimate, StampsFromNowhereDoNoHarm) {
  Estimator estimator(testing::planar_options());
  ArmState state = measured(1, 0.5, 1.0);
  for (const std::int64_t stamp :
       {std::numeric_limits<std::int64_t>::min(), std::numeric_limits<std::int64_t>::max(),
        std::int64_t{0}, std::int64_t{-5}}) {
    state.joint[0].stamp_ns = stamp;
    const Estimate& estimate = estimator.update(state, kPeriod);
    EXPECT_NEAR(estimate.position[0], 0.5, 3.1e-3);
    EXPECT_NEAR(estimate.position[1], 0.5, 3.1e-3);
    EXPECT_TRUE(std::isfinite(estimate.velocity[0]));
  }
}

}  // namespace
}  // namespace geodesic::control
