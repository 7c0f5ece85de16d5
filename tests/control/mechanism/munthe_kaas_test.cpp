// Runge-Kutta-Munthe-Kaas: its order, a top in closed form, and plain Runge-Kutta where one chart
// will do.
#include "control/mechanism/munthe_kaas.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "control/geometry/so3.hpp"
#include "control/mechanism/configuration.hpp"
#include "control/mechanism/forward_dynamics.hpp"
#include "control/mechanism/geodesic_between.hpp"
#include "control/mechanism/kinematics.hpp"
#include "control/mechanism/variational.hpp"
#include "tests/control/mechanism/motion_trees.hpp"
#include "tests/control/mechanism/random_tree.hpp"

namespace geodesic::control {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

VectorXd run(const Mechanism& m, const VectorXd& q, const VectorXd& v, double until, int steps) {
  MuntheKaasIntegrator motion(m);
  motion.start(q, v);
  for (int k = 0; k < steps; ++k) {
    EXPECT_TRUE(motion.step(until / steps));
  }
  return motion.q();
}

TEST(MuntheKaas, IsOfOrderFourOnEveryGroup) {
  const TreeDescription tree =
      testing::chain({JointKind::kPlanar, JointKind::kSpherical, JointKind::kRevolute,
                      JointKind::kFloating, JointKind::kPrismatic},
                     {Vector3d::UnitZ(), Vector3d::UnitX(), Vector3d::UnitY(), Vector3d::UnitX(),
                      Vector3d::UnitY()});
  const Mechanism m(tree, Vector3d(0.0, 0.5, -9.81), {Base::kFloating, {}});
  testing::RandomArm random(23);
  const VectorXd q = neutral(m);
  const VectorXd v = random.vector(m.dof(), 1.5);
  const VectorXd truth = run(m, q, v, 0.4, 800);
  const auto error = [&](int steps) {
    return straight(m, run(m, q, v, 0.4, steps), truth).cwiseAbs().maxCoeff();
  };
  const double coarse = error(25);
  const double half = error(50);
  const double quarter = error(100);
  EXPECT_NEAR(std::log2(coarse / half), 4.0, 0.35);
  EXPECT_NEAR(std::log2(half / quarter), 4.0, 0.2);
}

TEST(MuntheKaas, ASymmetricTopTurnsAsInTheTextbooks) {
  // In the resting frame the top turns about its momentum L at |L| / I1 while it spins back about
  // its own axis at (I3 - I1) / I1 w3 (Landau, Lifshitz 1976, section 33). In large steps, so that
  // dexp^-1 counts: both integrators converge to it with their orders.
  TreeDescription tree;
  tree.name = "top";
  tree.root_link = "top";
  LinkDescription link{"top", {}};
  link.inertia.mass_kg = 2.0;
  link.inertia.inertia_kg_m2 = Vector3d(0.3, 0.3, 0.5).asDiagonal();
  tree.links = {link};
  const Mechanism m(tree, Vector3d::Zero(), {Base::kFloating, {}});
  VectorXd v(6);
  v << 0.3, -0.1, 0.2, 0.8, -0.4, 1.5;
  const Vector3d momentum = Vector3d(0.3, 0.3, 0.5).cwiseProduct(Vector3d(v.tail<3>()));
  const double t = 4.0;
  const Eigen::Matrix3d truth =
      exp(Vector3d(t * momentum / 0.3)) * exp(Vector3d(0.0, 0.0, -t * (0.5 - 0.3) / 0.3 * v[5]));
  const auto turn_error = [&](const VectorXd& q) {
    const Eigen::Quaterniond found(q[6], q[3], q[4], q[5]);
    return (found.toRotationMatrix() - truth).cwiseAbs().maxCoeff();
  };
  const VectorXd q0 = neutral(m);
  const double coarse = turn_error(run(m, q0, v, t, 40));
  const double half = turn_error(run(m, q0, v, t, 80));
  EXPECT_NEAR(std::log2(coarse / half), 4.0, 0.4);
  EXPECT_LE(turn_error(run(m, q0, v, t, 2000)), 1e-10);
  const VectorXd end = run(m, q0, v, t, 400);
  EXPECT_LE((end.head<3>() - t * v.head<3>()).norm(), 1e-6) << "the centre of mass goes straight";

  double last = 0.0;
  for (const int steps : {400, 800}) {
    VariationalIntegrator motion(m);
    motion.start(q0, v);
    for (int k = 0; k < steps; ++k) {
      ASSERT_TRUE(motion.step(t / steps));
    }
    const double error = turn_error(motion.q());
    if (last > 0.0) {
      EXPECT_NEAR(std::log2(last / error), 2.0, 0.05);
    }
    last = error;
    EXPECT_LE((motion.q().head<3>() - t * v.head<3>()).norm(), 1e-12);
  }
}

TEST(MuntheKaas, IsPlainRungeKuttaInOneChart) {
  testing::RandomArm random(29);
  testing::RandomTreeOptions shape;
  shape.joints = 5;
  shape.mimic_joints = 2;
  const Mechanism m(random.tree(shape), Vector3d(0.0, 0.0, -9.81));
  Workspace w(m);
  const VectorXd none = VectorXd::Zero(m.dof());
  VectorXd q = random.vector(m.dof());
  VectorXd v = random.vector(m.dof());
  const VectorXd found = run(m, q, v, 0.1, 20);
  const double h = 0.005;
  for (int k = 0; k < 20; ++k) {
    const VectorXd a1 = *forward_dynamics(m, w, q, v, none);
    const VectorXd v2 = v + 0.5 * h * a1;
    const VectorXd a2 = *forward_dynamics(m, w, VectorXd(q + 0.5 * h * v), v2, none);
    const VectorXd v3 = v + 0.5 * h * a2;
    const VectorXd a3 = *forward_dynamics(m, w, VectorXd(q + 0.5 * h * v2), v3, none);
    const VectorXd v4 = v + h * a3;
    const VectorXd a4 = *forward_dynamics(m, w, VectorXd(q + h * v3), v4, none);
    q += h / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4);
    v += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
  }
  EXPECT_LE((found - q).norm(), 1e-11 * (1.0 + q.norm()));
}

}  // namespace
}  // namespace geodesic::control
