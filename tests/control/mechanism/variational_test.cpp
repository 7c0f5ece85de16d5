// The variational integrator: what Noether's theorem promises it, energy, reversibility, order.
#include "control/mechanism/variational.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "control/mechanism/configuration.hpp"
#include "control/mechanism/geodesic_between.hpp"
#include "control/mechanism/kinematics.hpp"
#include "control/mechanism/munthe_kaas.hpp"
#include "rt/heap_counter.hpp"
#include "tests/control/mechanism/motion_trees.hpp"
#include "tests/control/mechanism/random_tree.hpp"

namespace geodesic::control {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;
using Vector6d = Eigen::Matrix<double, 6, 1>;
using testing::total_momentum;

const Vector3d kNoGravity = Vector3d::Zero();

Mechanism floating(const TreeDescription& tree, const Vector3d& gravity = kNoGravity) {
  return {tree, gravity, {Base::kFloating, {}}};
}

/// A planar, a spherical and a free joint among others, on a floating base or the world.
Mechanism of_every_kind(Base base, const Vector3d& gravity = kNoGravity) {
  const TreeDescription tree =
      testing::chain({JointKind::kPlanar, JointKind::kSpherical, JointKind::kRevolute,
                      JointKind::kFloating, JointKind::kPrismatic},
                     {Vector3d::UnitZ(), Vector3d::UnitX(), Vector3d::UnitY(), Vector3d::UnitX(),
                      Vector3d(0.0, 0.6, 0.8)});
  return {tree, gravity, {base, {}}};
}

struct Start {
  VectorXd q;
  VectorXd v;
};

Start start_of(const Mechanism& m, unsigned seed, double speed = 1.0) {
  testing::RandomArm random(seed);
  VectorXd q = neutral(m);
  integrate(m, q, random.vector(m.dof(), 0.8), 1.0, q);
  return {q, random.vector(m.dof(), speed)};
}

/// Largest distance of the two configurations in one factor's numbers.
double distance(const Mechanism& m, const VectorXd& a, const VectorXd& b) {
  return straight(m, a, b).cwiseAbs().maxCoeff();
}

TEST(Variational, FloatingArmKeepsMomentumAndEnergy) {
  const Mechanism m = floating(testing::arm());
  Workspace w(m);
  const Start s = start_of(m, 3);
  VariationalIntegrator motion(m);
  motion.start(s.q, s.v);
  const Vector6d before = total_momentum(m, w, s.q, s.v);
  const double energy = kinetic_energy(m, w, s.q, s.v);
  double linear = 0.0;
  double angular = 0.0;
  double early = 0.0;
  double late = 0.0;
  constexpr int kSteps = 100000;
  for (int k = 1; k <= kSteps; ++k) {
    ASSERT_TRUE(motion.step(1e-3));
    if (k % 100 != 0) continue;
    const VectorXd v = *motion.velocity();
    const Vector6d now = total_momentum(m, w, motion.q(), v);
    linear = std::max(linear, (now - before).head<3>().norm() / before.head<3>().norm());
    angular = std::max(angular, (now - before).tail<3>().norm() / before.tail<3>().norm());
    const double change = std::abs(kinetic_energy(m, w, motion.q(), v) / energy - 1.0);
    double& band = k <= kSteps / 4 ? early : late;
    band = std::max(band, change);
  }
  EXPECT_LE(linear, 1e-12);
  EXPECT_LE(angular, 1e-12);
  EXPECT_LE(early, 1e-5);
  EXPECT_LE(late, 2.0 * early) << "drift";
}

TEST(Variational, PlanarAndSphericalAndFreeRootsKeepMomentum) {
  // On SE(2): a planar joint on the world; its moment about the world's origin is no coordinate.
  TreeDescription plane = testing::chain({JointKind::kContinuous, JointKind::kContinuous},
                                         {Vector3d::UnitZ(), Vector3d::UnitZ()});
  plane.links.push_back({"ground", {}});
  plane.root_link = "ground";
  for (const JointKind kind : {JointKind::kPlanar, JointKind::kSpherical, JointKind::kFloating}) {
    TreeDescription tree = plane;
    tree.joints.push_back(testing::joint("root", kind, "ground", "base", Vector3d::UnitZ(), 0.0));
    const Mechanism m(tree, kNoGravity);
    Workspace w(m);
    const Start s = start_of(m, 5);
    VariationalIntegrator motion(m);
    motion.start(s.q, s.v);
    const Vector6d before = total_momentum(m, w, s.q, s.v);
    for (int k = 0; k < 5000; ++k) {
      ASSERT_TRUE(motion.step(2e-3));
    }
    const Vector6d change = total_momentum(m, w, motion.q(), *motion.velocity()) - before;
    const double scale = before.norm();
    if (kind == JointKind::kSpherical) {
      EXPECT_LE(change.tail<3>().norm(), 1e-12 * scale);
    } else if (kind == JointKind::kPlanar) {
      EXPECT_LE(change.head<2>().norm() + std::abs(change[5]), 1e-12 * scale);
    } else {
      EXPECT_LE(change.norm(), 1e-12 * scale);
    }
  }
}

TEST(Variational, WeightChangesMomentumAsItMust) {
  const Vector3d g(0.3, -0.2, -9.81);
  const Mechanism m = floating(testing::arm(), g);
  Workspace w(m);
  const Start s = start_of(m, 7);
  VariationalIntegrator motion(m);
  motion.start(s.q, s.v);
  const Vector6d before = total_momentum(m, w, s.q, s.v);
  for (int k = 0; k < 2000; ++k) {
    ASSERT_TRUE(motion.step(1e-3));
  }
  const Vector6d after = total_momentum(m, w, motion.q(), *motion.velocity());
  EXPECT_LE((after - before).head<3>().norm() - 2.0 * m.moving_mass() * g.norm(), 1e-11);
  EXPECT_LE(((after - before).head<3>() - 2.0 * m.moving_mass() * g).norm(), 1e-11);
}

TEST(Variational, RunsBackAsItCame) {
  for (const Base base : {Base::kFixed, Base::kFloating}) {
    const Mechanism m = of_every_kind(base, Vector3d(0.0, 0.0, -9.81));
    const Start s = start_of(m, 11, 0.5);
    VariationalIntegrator motion(m);
    motion.start(s.q, s.v);
    for (int k = 0; k < 200; ++k) {
      ASSERT_TRUE(motion.step(2e-3));
    }
    EXPECT_GT(distance(m, motion.q(), s.q), 0.1);
    for (int k = 0; k < 200; ++k) {
      ASSERT_TRUE(motion.step(-2e-3));
    }
    EXPECT_LE(distance(m, motion.q(), s.q), 1e-10);
    EXPECT_LE((*motion.velocity() - s.v).norm(), 1e-9);
  }
}

double error_after(const Mechanism& m, const Start& s, const VectorXd& force, const VectorXd& truth,
                   double until, int steps) {
  VariationalIntegrator motion(m);
  motion.start(s.q, s.v);
  for (int k = 0; k < steps; ++k) {
    EXPECT_TRUE(motion.step(until / steps, force));
  }
  return distance(m, motion.q(), truth);
}

TEST(Variational, IsOfOrderTwoOnEveryGroupForcedAndHeavy) {
  for (const Base base : {Base::kFixed, Base::kFloating}) {
    const Mechanism m = of_every_kind(base, Vector3d(0.5, 0.0, -9.81));
    const Start s = start_of(m, 13, 0.7);
    testing::RandomArm random(17);
    const VectorXd force = random.vector(m.dof(), 0.3);
    MuntheKaasIntegrator fine(m);
    fine.start(s.q, s.v);
    for (int k = 0; k < 800; ++k) {
      ASSERT_TRUE(fine.step(0.2 / 800, force));
    }
    const double coarse = error_after(m, s, force, fine.q(), 0.2, 100);
    const double half = error_after(m, s, force, fine.q(), 0.2, 200);
    const double quarter = error_after(m, s, force, fine.q(), 0.2, 400);
    EXPECT_NEAR(std::log2(coarse / half), 2.0, 0.1);
    EXPECT_NEAR(std::log2(half / quarter), 2.0, 0.05);
    EXPECT_LT(quarter, 1e-3);
  }
}

TEST(Variational, LargeStepsConverge) {
  const Mechanism m = floating(testing::arm());
  Workspace w(m);
  const Start s = start_of(m, 3, 2.0);
  VariationalIntegrator motion(m);
  motion.start(s.q, s.v);
  const Vector6d before = total_momentum(m, w, s.q, s.v);
  for (int k = 0; k < 200; ++k) {
    ASSERT_TRUE(motion.step(0.05)) << "step " << k;
  }
  const Vector6d after = total_momentum(m, w, motion.q(), *motion.velocity());
  EXPECT_LE((after - before).norm(), 1e-11 * before.norm());
}

TEST(Variational, AStepTooLargeLeavesTheStateAlone) {
  const Mechanism m = floating(testing::arm());
  const Start s = start_of(m, 3, 5.0);
  VariationalIntegrator motion(m);
  motion.start(s.q, s.v);
  const VectorXd q = motion.q();
  VectorXd force = VectorXd::Zero(m.dof());
  force[7] = std::nan("");
  EXPECT_FALSE(motion.step(1e-3, force));
  EXPECT_EQ(motion.q(), q);
  EXPECT_TRUE(motion.step(1e-3));
}

TEST(Variational, StraightLinesWhereTheMetricIsFlat) {
  const Mechanism m(testing::chain({JointKind::kPrismatic, JointKind::kPrismatic},
                                   {Vector3d::UnitX(), Vector3d(0.0, 0.6, 0.8)}),
                    kNoGravity);
  VariationalIntegrator motion(m);
  const VectorXd v = Eigen::Vector2d(0.25, -0.5);
  motion.start(VectorXd::Zero(2), v);
  for (int k = 0; k < 1000; ++k) {
    ASSERT_TRUE(motion.step(0.01));
  }
  EXPECT_LE((motion.q() - 10.0 * v).norm(), 1e-13);
}

TEST(Variational, AllocatesNothing) {
  const Mechanism m = of_every_kind(Base::kFloating, Vector3d(0.0, 0.0, -9.81));
  const Start s = start_of(m, 19, 0.5);
  VariationalIntegrator motion(m);
  MuntheKaasIntegrator other(m);
  const VectorXd force = VectorXd::Constant(m.dof(), 0.1);
  const std::uint64_t before = rt::heap_calls();
  motion.start(s.q, s.v);
  other.start(s.q, s.v);
  bool fine = true;
  for (int k = 0; k < 20; ++k) {
    fine = motion.step(k < 10 ? 1e-3 : 2e-2, force) && other.step(1e-3, force) && fine;
  }
  fine = motion.velocity() != nullptr && fine;
  const std::uint64_t after = rt::heap_calls();
  EXPECT_EQ(after - before, 0U);
  EXPECT_TRUE(fine);
}

}  // namespace
}  // namespace geodesic::control
