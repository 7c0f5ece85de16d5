// Problem 1. The metric from the kinetic energy.
//
// A planar arm has two uniform rods of masses m1, m2 and lengths l1, l2; q1 is the angle of the
// first from the x axis, q2 that of the second from the first. Find the Riemannian metric M(q) with
// T = v' M(q) v / 2, show that it is one, and the momentum that belongs to a velocity.
//
// By hand. The centres of mass are at r1 = l1/2, r2 = l2/2 along the rods,
//
//     x1 = r1 (cos q1, sin q1)              x2 = l1 (cos q1, sin q1) + r2 (cos(q1+q2), sin(q1+q2))
//
// whose squared velocities are r1^2 v1^2 and l1^2 v1^2 + r2^2 (v1+v2)^2 + 2 l1 r2 cos(q2) v1
// (v1+v2). With the rotations, I = m l^2 / 12 about each centre, the coefficients of v1^2/2, v1 v2,
// v2^2/2 are
//
//     M11 = alpha + 2 beta cos q2     M12 = delta + beta cos q2     M22 = delta
//     alpha = I1 + I2 + m1 r1^2 + m2 (l1^2 + r2^2),  beta = m2 l1 r2,  delta = I2 + m2 r2^2
//
// (Murray, Li, Sastry 1994, "A Mathematical Introduction to Robotic Manipulation", chapter 4, 2.3.)
// It depends on q2 alone, since turning the whole arm changes no distance.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <filesystem>

#include "control/geometry/lagrangian.hpp"
#include "control/mechanism/dynamics.hpp"
#include "tests/control/mechanism/urdf_for_tests.hpp"

namespace geodesic::control::course {
namespace {

constexpr double kM1 = 1.3, kM2 = 0.9;                                    // [kg]
constexpr double kL1 = 0.5, kL2 = 0.4, kR1 = 0.5 * kL1, kR2 = 0.5 * kL2;  // [m]
constexpr double kI1 = kM1 * kL1 * kL1 / 12.0, kI2 = kM2 * kL2 * kL2 / 12.0;

/// The kinetic energy as one would say it: positions, and the rates they have when q moves at v.
/// Their derivatives are the library's to take.
struct KineticEnergy {
  template <class S>
  S operator()(const Eigen::Matrix<S, 2, 1>& q, const Eigen::Matrix<S, 2, 1>& v) const {
    using std::cos;
    using std::sin;
    const auto moving = along(q, v);
    const auto c1 = cos(moving[0]), s1 = sin(moving[0]);
    const auto c12 = cos(moving[0] + moving[1]), s12 = sin(moving[0] + moving[1]);
    const S x1 = (kR1 * c1).rate, y1 = (kR1 * s1).rate;
    const S x2 = (kL1 * c1 + kR2 * c12).rate, y2 = (kL1 * s1 + kR2 * s12).rate;
    const S turn1 = v[0], turn2 = v[0] + v[1];
    return 0.5 * (kM1 * (x1 * x1 + y1 * y1) + kI1 * turn1 * turn1) +
           0.5 * (kM2 * (x2 * x2 + y2 * y2) + kI2 * turn2 * turn2);
  }
};

Eigen::Matrix2d metric_by_hand(const Eigen::Vector2d& q) {
  const double alpha = kI1 + kI2 + kM1 * kR1 * kR1 + kM2 * (kL1 * kL1 + kR2 * kR2);
  const double beta = kM2 * kL1 * kR2, delta = kI2 + kM2 * kR2 * kR2;
  Eigen::Matrix2d m;
  m << alpha + 2.0 * beta * std::cos(q[1]), delta + beta * std::cos(q[1]),
      delta + beta * std::cos(q[1]), delta;
  return m;
}

TEST(Course, Problem1MetricFromKineticEnergy) {
  const auto arm = lagrangian<2>(KineticEnergy{});
  const Mechanism tree(testing::read_urdf(GEODESIC_TEST_DATA "/oracles/planar2r.urdf"),
                       Eigen::Vector3d::Zero());
  Workspace workspace(tree);
  const Eigen::Vector2d v(1.1, 0.6);
  for (const auto& q : {Eigen::Vector2d(0.7, -1.9), {0.0, 0.0}, {-2.0, 3.1}}) {
    // The metric: Hessian of T in v; by hand; and the same of the arm's URDF, as a tree of bodies.
    const Eigen::Matrix2d m = arm.metric(q);
    EXPECT_LE((m - metric_by_hand(q)).norm(), 1e-15);
    EXPECT_LE((m - metric(tree, workspace, q)).norm(), 1e-15);

    // It is a metric: T = v' M v / 2 for any v, symmetric, positive definite (even stretched out
    // and folded), and the same however the whole arm is turned.
    EXPECT_NEAR(KineticEnergy{}(q, v), 0.5 * v.dot(m * v), 1e-15);
    EXPECT_EQ(m, m.transpose());
    EXPECT_EQ(m.llt().info(), Eigen::Success);
    EXPECT_LE((arm.metric(q + Eigen::Vector2d(0.4, 0.0)) - m).norm(), 1e-15);

    // The momentum of v is the covector p = dT/dv = M v (flat); M^-1 takes it back (sharp); as a
    // covector on its velocity it gives 2 T.
    const Eigen::Vector2d p = arm.momentum(q, v);
    EXPECT_LE((p - m * v).norm(), 1e-15);
    EXPECT_LE((m.llt().solve(p) - v).norm(), 1e-13);
    EXPECT_NEAR(p.dot(v), 2.0 * kinetic_energy(tree, workspace, q, v), 1e-15);
  }
}

}  // namespace
}  // namespace geodesic::control::course
