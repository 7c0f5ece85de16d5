// Hard limits, walls and the last bounds of one joint.
#include "control/safety/limits.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace geodesic::control {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

JointTuning tuning() {
  JointTuning joint;
  joint.position_lower = -1.0;
  joint.position_upper = 2.0;
  joint.position_tolerance = 0.01;
  joint.soft_margin = 0.2;
  joint.wall_stiffness = 100.0;
  joint.wall_damping = 10.0;
  joint.torque_limit = 5.0;
  joint.torque_rate_limit = 1000.0;
  return joint;
}

TEST(Limits, OutsideIsBeyondTheTolerance) {
  EXPECT_FALSE(outside_limits(tuning(), 2.009));
  EXPECT_TRUE(outside_limits(tuning(), 2.011));
  EXPECT_FALSE(outside_limits(tuning(), -1.009));
  EXPECT_TRUE(outside_limits(tuning(), -1.011));
  EXPECT_TRUE(outside_limits(tuning(), kNan));
  EXPECT_FALSE(outside_limits(JointTuning{}, 1e9));
  EXPECT_EQ(nearest_limit(tuning(), 2.3), 2.0);
  EXPECT_EQ(nearest_limit(tuning(), -1.3), -1.0);
}

TEST(Walls, DoNothingInsideNorWithoutLimits) {
  EXPECT_EQ(wall_torque(tuning(), 1.79, 3.0), 0.0);
  EXPECT_EQ(wall_torque(tuning(), -0.79, -3.0), 0.0);
  JointTuning endless = tuning();
  endless.position_lower = -kInfinity;
  endless.position_upper = kInfinity;
  EXPECT_EQ(wall_torque(endless, 1e6, 1e6), 0.0);
}

TEST(Walls, PushBackAndNeverPull) {
  for (double depth = 0.001; depth < 0.3; depth += 0.001) {
    for (double v = -5.0; v <= 5.0; v += 0.5) {
      EXPECT_LT(wall_torque(tuning(), 1.8 + depth, v), 0.0);
      EXPECT_GT(wall_torque(tuning(), -0.8 - depth, v), 0.0);
    }
  }
  // On the way out the damper lets go.
  EXPECT_DOUBLE_EQ(wall_torque(tuning(), 1.9, -5.0), -100.0 * (1.9 - 1.8));
  EXPECT_LT(wall_torque(tuning(), 1.9, 1.0), -100.0 * (1.9 - 1.8) - 9.99);
}

TEST(Walls, AreContinuousWhereTheyBegin) {
  EXPECT_GT(wall_torque(tuning(), 1.8 + 1e-9, 5.0), -1e-5);
}

TEST(Walls, StopGrowingBehindTheHardLimit) {
  EXPECT_DOUBLE_EQ(wall_torque(tuning(), 50.0, 0.0), -100.0 * 0.21);
}

TEST(Walls, NeverMeetInANarrowRange) {
  JointTuning finger = tuning();
  finger.position_lower = 0.0;
  finger.position_upper = 0.04;
  EXPECT_EQ(wall_torque(finger, 0.02, 1.0), 0.0);
  EXPECT_GT(wall_torque(finger, 0.001, 0.0), 0.0);
}

// A mass thrown at a wall, at the cycle time of a real arm: it never comes back faster than it
// came.
TEST(Walls, GiveBackNoMoreThanTheyTook) {
  for (const double speed : {0.05, 0.5, 2.0, 5.0}) {
    for (const double damping : {0.0, 10.0}) {
      JointTuning joint = tuning();
      joint.wall_damping = damping;
      const double mass = 0.5;
      const double step_s = 1e-5;
      double q = 1.5;
      double v = speed;
      double work_by_wall = 0.0;
      for (int i = 0; i < 2'000'000 && q >= 1.5; ++i) {
        const double torque = wall_torque(joint, q, v);
        const double v_next = v + torque / mass * step_s;
        const double q_next = q + 0.5 * (v + v_next) * step_s;
        work_by_wall += torque * (q_next - q);
        q = q_next;
        v = v_next;
      }
      EXPECT_LE(work_by_wall, 1e-3 * 0.5 * mass * speed * speed) << speed << " " << damping;
      EXPECT_LE(std::abs(v), speed * 1.001);
      if (damping > 0.0) {
        EXPECT_LT(std::abs(v), speed * (speed < 0.1 ? 0.98 : 0.9));
      }
    }
  }
}

TEST(Bound, ClampsTorque) {
  const BoundedTorque bounded = bound_torque(tuning(), 8.0, 5.0, 1e-3);
  EXPECT_EQ(bounded.torque, 5.0);
  EXPECT_TRUE(bounded.saturated);
  EXPECT_TRUE(bounded.finite);
  EXPECT_FALSE(bound_torque(tuning(), 4.9, 4.5, 1e-3).saturated);
}

TEST(Bound, LimitsTheRateFromWhatLeftBefore) {
  EXPECT_DOUBLE_EQ(bound_torque(tuning(), 5.0, 0.0, 1e-3).torque, 1.0);
  EXPECT_DOUBLE_EQ(bound_torque(tuning(), -5.0, 0.5, 1e-3).torque, -0.5);
  EXPECT_DOUBLE_EQ(bound_torque(tuning(), 0.7, 0.5, 1e-3).torque, 0.7);
}

TEST(Bound, LetsNothingOutThatIsNoNumber) {
  for (const double wanted : {kNan, kInfinity, -kInfinity}) {
    const BoundedTorque bounded = bound_torque(tuning(), wanted, 4.0, 1e-3);
    EXPECT_EQ(bounded.torque, 0.0);
    EXPECT_FALSE(bounded.finite);
  }
  EXPECT_TRUE(bound_torque(JointTuning{}, 1e300, 0.0, 1e-3).finite);
  const double denormal = std::numeric_limits<double>::denorm_min();
  EXPECT_EQ(bound_torque(tuning(), denormal, 0.0, 1e-3).torque, denormal);
}

}  // namespace
}  // namespace geodesic::control
