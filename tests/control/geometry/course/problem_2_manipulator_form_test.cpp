// Problem 2. The manipulator form from the Lagrangian.
//
// The arm of problem 1 stands upright, gravity g along -y. Bring its Euler-Lagrange equations
// d/dt dL/dv - dL/dq = tau to the form M(q) a + C(q, v) v + dV(q) = tau with C made of the metric's
// Christoffel symbols, and show that dM/dt - 2 C is skew-symmetric: C v does no work of its own.
//
// By hand. Of M only M11 and M12 change, with q2: dM11/dq2 = -2 beta s, dM12/dq2 = -beta s, where
// beta = m2 l1 r2 and s = sin q2. The symbols of the first kind that are not zero,
// Gamma_i,jk = (dM_ij/dq_k + dM_ik/dq_j - dM_jk/dq_i) / 2, are
//
//     Gamma_1,12 = Gamma_1,21 = dM11/dq2 / 2 = -beta s         Gamma_1,22 = dM12/dq2 = -beta s
//     Gamma_2,11 = -dM11/dq2 / 2 = beta s
//
// so that, with C_ij = Gamma_i,jk v_k,
//
//     C = beta s ( -v2   -(v1+v2) )      dM/dt - 2 C = beta s (      0       2 v1 + v2 )
//                (  v1      0     )                           ( -2 v1 - v2       0     )
//
// and V = (m1 r1 + m2 l1) g sin q1 + m2 r2 g sin(q1+q2) gives
//
//     dV = ( (m1 r1 + m2 l1) g cos q1 + m2 r2 g cos(q1+q2),  m2 r2 g cos(q1+q2) ).
#include <gtest/gtest.h>

#include <cmath>

#include "control/geometry/lagrangian.hpp"
#include "control/mechanism/dynamics.hpp"
#include "tests/control/mechanism/urdf_for_tests.hpp"

namespace geodesic::control::course {
namespace {

constexpr double kM1 = 1.3, kM2 = 0.9, kG = 9.81;                         // [kg], [m/s²]
constexpr double kL1 = 0.5, kL2 = 0.4, kR1 = 0.5 * kL1, kR2 = 0.5 * kL2;  // [m]
constexpr double kI1 = kM1 * kL1 * kL1 / 12.0, kI2 = kM2 * kL2 * kL2 / 12.0;

/// L = T - V.
struct Arm {
  template <class S>
  S operator()(const Eigen::Matrix<S, 2, 1>& q, const Eigen::Matrix<S, 2, 1>& v) const {
    using std::cos;
    using std::sin;
    const S first = v[0], second = v[0] + v[1];
    const S square1 = kR1 * kR1 * first * first;  // of the centres' velocities
    const S square2 = kL1 * kL1 * first * first + kR2 * kR2 * second * second +
                      2.0 * kL1 * kR2 * cos(q[1]) * first * second;
    const S kinetic =
        0.5 * (kM1 * square1 + kI1 * first * first) + 0.5 * (kM2 * square2 + kI2 * second * second);
    const S height1 = kR1 * sin(q[0]), height2 = kL1 * sin(q[0]) + kR2 * sin(q[0] + q[1]);
    return kinetic - kG * (kM1 * height1 + kM2 * height2);
  }
};

TEST(Course, Problem2ManipulatorForm) {
  const Eigen::Vector2d q(0.7, -1.9), v(1.1, 0.6), a(2.0, -3.0);
  const double s = std::sin(q[1]), beta = kM2 * kL1 * kR2;
  Eigen::Matrix2d c;
  c << -v[1], -(v[0] + v[1]), v[0], 0.0;
  c *= beta * s;
  const double fore = kM2 * kR2 * kG * std::cos(q[0] + q[1]);
  const Eigen::Vector2d dv((kM1 * kR1 + kM2 * kL1) * kG * std::cos(q[0]) + fore, fore);

  // From the Lagrangian.
  const auto arm = lagrangian<2>(Arm{});
  const auto symbols = arm.christoffel_first_kind(q);
  EXPECT_NEAR(symbols(0, 0, 1), -beta * s, 1e-15);
  EXPECT_NEAR(symbols(0, 1, 0), -beta * s, 1e-15);
  EXPECT_NEAR(symbols(0, 1, 1), -beta * s, 1e-15);
  EXPECT_NEAR(symbols(1, 0, 0), beta * s, 1e-15);
  EXPECT_NEAR(symbols(0, 0, 0), 0.0, 1e-15);
  EXPECT_NEAR(symbols(1, 0, 1), 0.0, 1e-15);
  EXPECT_NEAR(symbols(1, 1, 1), 0.0, 1e-15);
  EXPECT_LE((arm.coriolis_matrix(q, v) - c).norm(), 1e-15);
  EXPECT_LE((arm.potential_differential(q) - dv).norm(), 1e-14);

  // d/dt dL/dv - dL/dq, taken of L at once, is the manipulator form.
  const Eigen::Vector2d tau = arm.metric(q) * a + c * v + dv;
  EXPECT_LE((arm.euler_lagrange(q, v, a) - tau).norm(), 1e-14);
  EXPECT_LE((*arm.forward_dynamics(q, v, tau) - a).norm(), 1e-13);

  // From the tree of bodies: what the daemon computes a thousand times a second.
  const Mechanism tree(testing::read_urdf(GEODESIC_TEST_DATA "/oracles/planar2r.urdf"),
                       Eigen::Vector3d(0.0, -kG, 0.0));
  Workspace workspace(tree);
  EXPECT_LE((coriolis_matrix(tree, workspace, q, v) - c).norm(), 1e-15);
  EXPECT_LE((gravity(tree, workspace, q) - dv).norm(), 1e-14);
  EXPECT_LE((bias(tree, workspace, q, v) - c * v - dv).norm(), 1e-14);
  EXPECT_LE((inverse_dynamics(tree, workspace, q, v, a) - tau).norm(), 1e-14);

  // dM/dt - 2 C is skew, so the power of M a + C v is the rate of T: nothing is lost to C v.
  Eigen::Matrix2d skew;
  skew << 0.0, 2.0 * v[0] + v[1], -2.0 * v[0] - v[1], 0.0;
  EXPECT_LE((metric_rate(tree, workspace, q, v) - 2.0 * c - beta * s * skew).norm(), 1e-15);
  const double power = v.dot(tau);
  const auto energy_at = [&](double t) {
    return arm.energy(q + t * v + 0.5 * t * t * a, v + t * a);
  };
  EXPECT_NEAR((energy_at(1e-4) - energy_at(-1e-4)) / 2e-4, power, 1e-6);
}

}  // namespace
}  // namespace geodesic::control::course
