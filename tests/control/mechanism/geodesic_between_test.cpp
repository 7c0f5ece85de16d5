// Geodesics between two configurations: closed forms (flat metric, sphere), symmetry, minimality,
// conjugate points, refusals.
#include "control/mechanism/geodesic_between.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "control/mechanism/configuration.hpp"
#include "control/mechanism/kinematics.hpp"
#include "control/mechanism/munthe_kaas.hpp"
#include "control/mechanism/variational.hpp"
#include "tests/control/mechanism/motion_trees.hpp"
#include "tests/control/mechanism/random_tree.hpp"

namespace geodesic::control {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

const Vector3d kNoGravity = Vector3d::Zero();

TEST(Geodesic, KeepsItsEnergy) {
  for (unsigned seed = 0; seed < 4; ++seed) {
    testing::RandomArm random(seed);
    testing::RandomTreeOptions shape;
    shape.joints = 4;
    const Mechanism m(random.tree(shape), kNoGravity,
                      {seed % 2 == 0 ? Base::kFixed : Base::kFloating, {}});
    const VectorXd v = random.vector(m.dof(), 0.5);
    const Action action = geodesic_action(m, random.configuration(m), v, 0.5, 1000);
    EXPECT_LE(action.highest_energy - action.lowest_energy, 1e-7 * action.highest_energy);
    EXPECT_NEAR(action.length, std::sqrt(2.0 * action.action * 0.5), 1e-7 * action.length);
  }
}

TEST(Geodesic, IsAGreatCircleOnTheSphere) {
  const Mechanism m(testing::sphere(), kNoGravity);
  const VectorXd q = Vector2d(0.3, 0.4);
  const VectorXd v = Vector2d(0.7, 0.5);
  const Vector3d at = testing::on_sphere(q);
  const Vector3d moved = testing::on_sphere(q + 1e-6 * v) - testing::on_sphere(q - 1e-6 * v);
  const Vector3d along = moved.normalized();
  const double speed = std::hypot(std::cos(q[1]) * v[0], v[1]);
  MuntheKaasIntegrator fine(m);
  VariationalIntegrator steady(m);
  fine.start(q, v);
  steady.start(q, v);
  for (int k = 1; k <= 2000; ++k) {
    ASSERT_TRUE(fine.step(1e-3) && steady.step(1e-3));
    const double angle = speed * 1e-3 * k;
    const Vector3d truth = std::cos(angle) * at + std::sin(angle) * along;
    EXPECT_LE((testing::on_sphere(fine.q()) - truth).norm(), 1e-9);
    EXPECT_LE((testing::on_sphere(steady.q()) - truth).norm(), 1e-5);
  }
}

TEST(GeodesicBetween, OnTheSphereHasTheGreatCirclesLength) {
  const Mechanism m(testing::sphere(), kNoGravity);
  const VectorXd from = Vector2d(0.2, 0.6);
  const VectorXd to = Vector2d(1.9, 0.8);
  GeodesicOptions options;
  options.duration_s = 2.0;
  const GeodesicBetween found = geodesic_between(m, from, to, options);
  ASSERT_EQ(found.outcome, GeodesicOutcome::kFound);
  EXPECT_LE(found.miss, 1e-10);
  EXPECT_FALSE(found.conjugate_s.has_value());
  const double angle = std::acos(testing::on_sphere(from).dot(testing::on_sphere(to)));
  const Action action = geodesic_action(m, from, found.start_velocity, 2.0, 400);
  EXPECT_NEAR(action.length, angle, 1e-9);
  EXPECT_NEAR(action.action, 0.5 * angle * angle / 2.0, 1e-9);
  EXPECT_GT(straight_action(m, from, to, 2.0, 400).action, 1.02 * action.action);
}

TEST(GeodesicBetween, NamesTheConjugatePointBeyondHalfTheSphere) {
  const Mechanism m(testing::sphere(), kNoGravity);
  GeodesicOptions options;
  options.steps = 1000;
  const GeodesicBetween beyond =
      geodesic_between(m, Vector2d(0.0, 0.0), Vector2d(3.5, 0.0), options);
  ASSERT_EQ(beyond.outcome, GeodesicOutcome::kFound);
  ASSERT_TRUE(beyond.conjugate_s.has_value());
  EXPECT_NEAR(*beyond.conjugate_s, std::numbers::pi / 3.5, 2e-3);
}

TEST(GeodesicBetween, SaysHowFarItCameWhereTheChartEnds) {
  // The great circle from here to there leads over the pole, where the two axes are one and M is
  // singular: no motion of the joints passes exactly there.
  const Mechanism m(testing::sphere(), kNoGravity);
  GeodesicOptions options;
  options.steps = 100;
  options.most_shots = 60;
  const GeodesicBetween found =
      geodesic_between(m, Vector2d(0.0, 0.0), Vector2d(std::numbers::pi, 0.3), options);
  EXPECT_NE(found.outcome, GeodesicOutcome::kFound);
  EXPECT_GT(found.solved, 0.9);
  EXPECT_LT(found.solved, 1.0);
  EXPECT_GT(found.miss, 1e-3);
}

TEST(GeodesicBetween, IsStraightWhereTheMetricIsFlat) {
  const Mechanism m(testing::chain({JointKind::kPrismatic, JointKind::kPrismatic},
                                   {Vector3d::UnitX(), Vector3d(0.0, 0.6, 0.8)}),
                    kNoGravity);
  const VectorXd from = Vector2d(-0.3, 0.2);
  const VectorXd to = Vector2d(0.5, 0.9);
  const GeodesicBetween found = geodesic_between(m, from, to);
  ASSERT_EQ(found.outcome, GeodesicOutcome::kFound);
  EXPECT_LE((found.start_velocity - (to - from)).norm(), 1e-9);
}

TEST(GeodesicBetween, IsTheSameBackwardsAndNoneIsCheaperBesideIt) {
  const Mechanism m(testing::arm(), kNoGravity);
  const VectorXd from = Vector3d(0.1, -0.4, 0.3);
  const VectorXd to = Vector3d(1.2, 0.7, -0.8);
  const GeodesicBetween there = geodesic_between(m, from, to);
  const GeodesicBetween back = geodesic_between(m, to, from);
  ASSERT_EQ(there.outcome, GeodesicOutcome::kFound);
  ASSERT_EQ(back.outcome, GeodesicOutcome::kFound);
  const double action = geodesic_action(m, from, there.start_velocity, 1.0, 400).action;
  EXPECT_NEAR(action, geodesic_action(m, to, back.start_velocity, 1.0, 400).action, 1e-9 * action);
  EXPECT_LT(action, straight_action(m, from, to, 1.0, 400).action);
  EXPECT_FALSE(there.conjugate_s.has_value());
}

TEST(GeodesicBetween, LeadsAFloatingArmToAPose) {
  const Mechanism m(testing::arm(), kNoGravity, {Base::kFloating, {}});
  testing::RandomArm random(31);
  const VectorXd from = neutral(m);
  VectorXd to = from;
  integrate(m, from, random.vector(m.dof(), 0.6), 1.0, to);
  GeodesicOptions options;
  options.steps = 100;
  const GeodesicBetween found = geodesic_between(m, from, to, options);
  ASSERT_EQ(found.outcome, GeodesicOutcome::kFound);
  MuntheKaasIntegrator motion(m);
  motion.start(from, found.start_velocity);
  for (int k = 0; k < 400; ++k) {
    ASSERT_TRUE(motion.step(1.0 / 400));
  }
  EXPECT_LE(straight(m, motion.q(), to).cwiseAbs().maxCoeff(), 1e-6);
  EXPECT_LT(geodesic_action(m, from, found.start_velocity, 1.0, 100).action,
            straight_action(m, from, to, 1.0, 100).action);
}

TEST(GeodesicBetween, StraightIsTheInverseOfIntegrate) {
  const Mechanism m(testing::chain({JointKind::kSpherical, JointKind::kFloating},
                                   {Vector3d::UnitX(), Vector3d::UnitX()}),
                    kNoGravity, {Base::kFloating, {}});
  testing::RandomArm random(37);
  for (const double size : {1e-9, 1e-3, 0.1, 1.0, 1.7}) {
    const VectorXd q = random.configuration(m);
    const VectorXd v = random.vector(m.dof(), size);
    VectorXd to = q;
    integrate(m, q, v, 1.0, to);
    EXPECT_LE((straight(m, q, to) - v).norm(), 1e-14 + 2e-14 * size) << size;
  }
}

TEST(GeodesicBetween, RefusesGravityAndNonsense) {
  const Mechanism heavy(testing::arm(), Vector3d(0.0, 0.0, -9.81));
  const Mechanism light(testing::arm(), kNoGravity);
  const VectorXd q = VectorXd::Zero(3);
  EXPECT_THROW(geodesic_between(heavy, q, q), std::invalid_argument);
  EXPECT_THROW(geodesic_between(light, VectorXd::Zero(2), q), std::invalid_argument);
  GeodesicOptions options;
  options.duration_s = 0.0;
  EXPECT_THROW(geodesic_between(light, q, q, options), std::invalid_argument);
  EXPECT_EQ(geodesic_between(light, q, q).outcome, GeodesicOutcome::kFound);
}

}  // namespace
}  // namespace geodesic::control
