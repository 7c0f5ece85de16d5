// Problem 5. The metric in other coordinates.
//
// (a) Write the plane's metric and connection in polar coordinates. (b) Write the arm of problem 1
// in the absolute angles x1 = q1, x2 = q1 + q2 of its rods: metric, Coriolis covector, torques.
// Show that T is the same number, and that both coordinates describe the same motion.
//
// By hand. Under x = x(q) with Jacobian J and second derivatives H, velocities go by J, covectors
// by J^-T, the metric by J^-T M J^-1, and Gamma~ = (J Gamma - H)(J^-1 ., J^-1 .). (a) In Cartesian
// coordinates M = 1, Gamma = 0; in (r, t)
//
//     M = diag(1, r^2)      Gamma^r_tt = -r      Gamma^t_rt = Gamma^t_tr = 1/r
//
// all of it from H: the connection is no tensor. (b) v1 (v1 + v2) = x1' x2', so
//
//     M~ = ( alpha - delta    beta cos(x2 - x1) )     with alpha, beta, delta as in problem 1
//          ( beta cos(x2 - x1)      delta       )
//     C~ v~ = beta sin(x2 - x1) ( -x2'^2, x1'^2 )
//
// and <tau, v> = tau1 x1' + tau2 (x2' - x1') makes the torques tau1 - tau2 and tau2: the motor in
// the elbow pushes both rods, in opposite ways.
#include <gtest/gtest.h>

#include <cmath>

#include "control/geometry/chart_change.hpp"
#include "control/mechanism/dynamics.hpp"
#include "tests/control/mechanism/urdf_for_tests.hpp"

namespace geodesic::control::course {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

TEST(Course, Problem5ThePlaneInPolarCoordinates) {
  const auto polar = []<class S>(const Eigen::Matrix<S, 2, 1>& q) {
    using std::atan2;
    using std::hypot;
    return Eigen::Matrix<S, 2, 1>(hypot(q[0], q[1]), atan2(q[1], q[0]));
  };
  const double r = 1.7, t = 2.3;
  const Vector2d q(r * std::cos(t), r * std::sin(t));
  const auto change = *chart_change<2>(polar, q);
  EXPECT_LE(
      (change.metric(Matrix2d::Identity()) - Matrix2d(Vector2d(1.0, r * r).asDiagonal())).norm(),
      1e-14);
  const auto flat = ChartTensor3<2>::of([](int, int, int) { return 0.0; });
  const auto symbols = change.christoffel_second_kind(flat);
  EXPECT_NEAR(symbols(0, 1, 1), -r, 1e-14);
  EXPECT_NEAR(symbols(1, 0, 1), 1.0 / r, 1e-14);
  EXPECT_NEAR(symbols(1, 1, 0), 1.0 / r, 1e-14);
  EXPECT_NEAR(symbols(0, 0, 0), 0.0, 1e-14);
  EXPECT_NEAR(symbols(0, 0, 1), 0.0, 1e-14);
  EXPECT_NEAR(symbols(1, 0, 0), 0.0, 1e-14);
  EXPECT_NEAR(symbols(1, 1, 1), 0.0, 1e-14);
  // A straight line, seen in polar coordinates, is their geodesic.
  const Vector2d v(0.8, -0.5);
  EXPECT_LE((change.acceleration(v, Vector2d::Zero()) -
             geodesic_acceleration<2>(symbols, change.velocity(v)))
                .norm(),
            1e-14);
}

TEST(Course, Problem5TheArmInAbsoluteAngles) {
  const double m1 = 1.3, m2 = 0.9, l1 = 0.5, l2 = 0.4, r1 = 0.5 * l1, r2 = 0.5 * l2;
  const double i1 = m1 * l1 * l1 / 12.0, i2 = m2 * l2 * l2 / 12.0;
  const double alpha = i1 + i2 + m1 * r1 * r1 + m2 * (l1 * l1 + r2 * r2);
  const double beta = m2 * l1 * r2, delta = i2 + m2 * r2 * r2;
  const Mechanism arm(testing::read_urdf(GEODESIC_TEST_DATA "/oracles/planar2r.urdf"),
                      Eigen::Vector3d(0.0, -9.81, 0.0));
  Workspace workspace(arm);
  const auto absolute = [](const auto& q) {
    auto x = q;
    x[1] = q[0] + q[1];
    return x;
  };
  const Vector2d q(0.7, -1.9), v(1.1, 0.6), tau(1.5, -0.4);
  const auto change = *chart_change<2>(absolute, q);

  // The metric, and T.
  const Matrix2d m = metric(arm, workspace, q), fresh = change.metric(m);
  const Vector2d x = absolute(q), x_rate = change.velocity(v);
  Matrix2d by_hand;
  by_hand << alpha - delta, beta * std::cos(x[1] - x[0]), beta * std::cos(x[1] - x[0]), delta;
  EXPECT_LE((fresh - by_hand).norm(), 1e-15);
  EXPECT_NEAR(0.5 * x_rate.dot(fresh * x_rate), kinetic_energy(arm, workspace, q, v), 1e-15);

  // The connection, and the Coriolis covector it makes; the same as the tree's, as a covector.
  Christoffel numbers(arm);
  christoffel_symbols(arm, workspace, q, numbers);
  const auto symbols = change.christoffel_first_kind(ChartTensor3<2>::of(numbers), m);
  const double s = beta * std::sin(x[1] - x[0]);
  const Vector2d coriolis(-s * x_rate[1] * x_rate[1], s * x_rate[0] * x_rate[0]);
  EXPECT_LE((coriolis_matrix<2>(symbols, x_rate) * x_rate - coriolis).norm(), 1e-15);
  EXPECT_LE((change.covector(coriolis_matrix(arm, workspace, q, v) * v) - coriolis).norm(), 1e-15)
      << "the change is linear: H = 0, so even C v goes as a covector";

  // The torques, and the motion they cause: solved in x, it is the tree's own, seen in x.
  const Vector2d torque = change.covector(tau);
  EXPECT_LE((torque - Vector2d(tau[0] - tau[1], tau[1])).norm(), 1e-15);
  const Vector2d gradient = change.covector(gravity(arm, workspace, q));
  const Vector2d x_rate_rate = fresh.inverse() * (torque - coriolis - gradient);
  const Vector2d a = *forward_dynamics(arm, workspace, q, v, tau);
  EXPECT_LE((x_rate_rate - change.acceleration(v, a)).norm(), 1e-12);
}

}  // namespace
}  // namespace geodesic::control::course
