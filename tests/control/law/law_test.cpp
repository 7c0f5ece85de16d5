// The laws and the friction compensation, joint by joint.
#include "control/law/law.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace geodesic::control {
namespace {

const Friction kFriction{0.4, 0.2, 0.1};

TEST(Friction, IsZeroWithZeroSlopeAtRest) {
  EXPECT_EQ(compensate(kFriction, 0.0), 0.0);
  EXPECT_EQ(compensate(kFriction, -0.0), 0.0);
  // tanh would give 4e-6 here; a second-order rise gives 4e-12.
  EXPECT_LT(compensate(kFriction, 1e-6) / 1e-6, 1e-3 * kFriction.coulomb / kFriction.velocity);
}

TEST(Friction, IsOddBoundedAndRising) {
  double last = 0.0;
  for (double v = 1e-4; v < 100.0; v *= 1.01) {
    const double torque = compensate(kFriction, v);
    EXPECT_EQ(torque, -compensate(kFriction, -v));
    EXPECT_GT(torque, last);
    EXPECT_LE(torque, kFriction.coulomb + kFriction.viscous * v);
    last = torque;
  }
  EXPECT_NEAR(compensate(kFriction, 50.0), 0.4 + 0.2 * 50.0, 1e-3);
}

TEST(Friction, IsSmoothWhereTheFormsMeet) {
  const double at = kFriction.velocity;
  const double below = std::nextafter(at, 0.0);
  const double above = std::nextafter(at, 1.0);
  EXPECT_NEAR(compensate(kFriction, below), compensate(kFriction, above), 1e-15);
  const double h = 1e-6;
  const double slope_below = (compensate(kFriction, at) - compensate(kFriction, at - h)) / h;
  const double slope_above = (compensate(kFriction, at + h) - compensate(kFriction, at)) / h;
  EXPECT_NEAR(slope_below, slope_above, 1e-4);
}

// True friction minus compensation always takes energy out, if no more than the true one is
// configured: the arm never gains by it.
TEST(Friction, NeverFeedsMoreThanFrictionTakes) {
  for (double v = -10.0; v <= 10.0; v += 0.001) {
    const double friction = -std::copysign(kFriction.coulomb, v) - kFriction.viscous * v;
    EXPECT_LE((friction + compensate(kFriction, v)) * v, 1e-15) << v;
  }
}

// Speed of a joint of 0.1 kg·m² after 20 s at rest, whose velocity is known only with noise, and
// whose true friction is merely viscous, 0.3 N·m·s/rad, though 0.4 N·m of Coulomb are compensated.
template <class Compensation>
double speed_from_noise(Compensation compensation) {
  double v = 0.0;
  unsigned random = 1;
  for (int i = 0; i < 20'000; ++i) {
    random = random * 1664525u + 1013904223u;
    const double noise = 0.01 * (static_cast<double>(random >> 8) / 16777216.0 - 0.5);
    v += (compensation(v + noise) - 0.3 * v) / 0.1 * 1e-3;
  }
  return std::abs(v);
}

TEST(Friction, NoiseAtRestDoesNotStartMotionWhereTanhWould) {
  const Friction friction{0.4, 0.0, 0.1};
  EXPECT_LT(speed_from_noise([&](double v) { return compensate(friction, v); }), 1e-3);
  EXPECT_GT(speed_from_noise([](double v) { return 0.4 * std::tanh(v / 0.1); }), 0.5);
}

TEST(Friction, IsFiniteForEveryFiniteVelocity) {
  for (const double v : {std::numeric_limits<double>::denorm_min(), 1e-310, 1e-200, 1e200,
                         std::numeric_limits<double>::max() / 2}) {
    EXPECT_TRUE(std::isfinite(compensate(kFriction, v))) << v;
    EXPECT_TRUE(std::isfinite(compensate(kFriction, -v))) << v;
  }
  EXPECT_EQ(compensate({0.0, 0.0, 0.1}, 3.0), 0.0);
}

JointTuning tuning() {
  JointTuning joint;
  joint.damping = 0.5;
  joint.hold_stiffness = 20.0;
  joint.hold_damping = 2.0;
  joint.stop_damping = 3.0;
  joint.coulomb_friction = 0.4;
  return joint;
}

TEST(Law, AtRestOnlyTheModelSpeaks) {
  const LawInput rest{0.7, 0.0, 5.0, 0.7};
  for (const LawKind law : {LawKind::kFloat, LawKind::kHold, LawKind::kDamp}) {
    EXPECT_EQ(law_torque(law, tuning(), rest), 5.0) << to_string(law);
  }
  EXPECT_EQ(law_torque(LawKind::kZero, tuning(), rest), 0.0);
}

TEST(Law, FloatDampsAndCompensatesFriction) {
  const LawInput input{0.0, 2.0, 5.0, 0.0};
  EXPECT_DOUBLE_EQ(float_torque(tuning(), input),
                   5.0 - 0.5 * 2.0 + compensate({0.4, 0.0, 0.1}, 2.0));
}

TEST(Law, HoldIsSpringAndDamperAboutTheEntry) {
  EXPECT_DOUBLE_EQ(hold_torque(tuning(), {0.3, 1.0, 5.0, 0.5}), 5.0 + 20.0 * 0.2 - 2.0);
}

TEST(Law, DampBrakesInBothDirections) {
  EXPECT_DOUBLE_EQ(damp_torque(tuning(), {0.0, 2.0, 5.0, 0.0}), 5.0 - 6.0);
  EXPECT_DOUBLE_EQ(damp_torque(tuning(), {0.0, -2.0, 5.0, 0.0}), 5.0 + 6.0);
}

}  // namespace
}  // namespace geodesic::control
