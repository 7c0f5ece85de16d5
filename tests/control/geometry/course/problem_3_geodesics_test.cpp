// Problem 3. Free motion is along geodesics.
//
// A system with two coordinates (x, y) has the metric diag(1 + y^2, 1), no potential and no torque
// (a bead of unit mass on a helicoid, x the angle, y the distance from its axis). Find the
// connection, the geodesics, and the curvature. Show that the arm of problem 1, weightless, does
// likewise: its free motion has no covariant acceleration, its speed stays, and its path does not
// depend on speed.
//
// By hand. The only derivative is dM11/dy = 2 y, so
//
//     Gamma_1,12 = Gamma_1,21 = y,  Gamma_2,11 = -y                           (first kind)
//     Gamma^1_12 = Gamma^1_21 = y / (1 + y^2),  Gamma^2_11 = -y               (second kind)
//     x'' = -2 y x' y' / (1 + y^2)          y'' = y x'^2                      (geodesics)
//     K = -(sqrt(1 + y^2))'' / sqrt(1 + y^2) = -1 / (1 + y^2)^2               (curvature)
//
// x does not occur in T, so its momentum c = (1 + y^2) x' stays (Clairaut), and so does 2 T. The
// lines x = const, c = 0, are geodesics. So is the spiral with 2 T = c^2 = 1, where
// y'^2 = 1 - 1 / (1 + y^2): x' = 1 / (1 + y^2), y' = y / sqrt(1 + y^2), which integrates to
//
//     x + asinh(1/y) = const                sqrt(1 + y^2) - asinh(1/y) - t = const.
#include <gtest/gtest.h>

#include <cmath>

#include "control/geometry/lagrangian.hpp"
#include "control/mechanism/dynamics.hpp"
#include "tests/control/geometry/course/runge_kutta.hpp"
#include "tests/control/mechanism/urdf_for_tests.hpp"

namespace geodesic::control::course {
namespace {

using Eigen::Vector2d;

const auto kBead = lagrangian<2>([](const auto& q, const auto& v) {
  return 0.5 * ((1.0 + q[1] * q[1]) * v[0] * v[0] + v[1] * v[1]);
});

Vector2d free_bead(const Vector2d& q, const Vector2d& v) {
  return geodesic_acceleration<2>(*kBead.christoffel_second_kind(q), v);
}

TEST(Course, Problem3ConnectionAndCurvature) {
  const Vector2d q(0.3, 0.8), v(1.2, -0.7);
  const double y = q[1], w = 1.0 + y * y;
  const auto first = kBead.christoffel_first_kind(q);
  const auto second = *kBead.christoffel_second_kind(q);
  EXPECT_NEAR(first(0, 0, 1), y, 1e-15);
  EXPECT_NEAR(first(1, 0, 0), -y, 1e-15);
  EXPECT_NEAR(second(0, 0, 1), y / w, 1e-15);
  EXPECT_NEAR(second(1, 0, 0), -y, 1e-15);
  EXPECT_LE((free_bead(q, v) - Vector2d(-2.0 * y * v[0] * v[1] / w, y * v[0] * v[0])).norm(),
            1e-15);
  EXPECT_NEAR(*kBead.sectional_curvature(q, {1.0, 0.0}, {0.0, 1.0}), -1.0 / (w * w), 1e-15);
}

TEST(Course, Problem3GeodesicsOfTheHelicoid) {
  // Straight along the line x = const.
  const auto line = integrate<2>(free_bead, {{0.4, -1.0}, {0.0, 0.5}}, 0.01, 200);
  EXPECT_LE((line.q - Vector2d(0.4, 0.0)).norm(), 1e-12);

  // Along the spiral with 2 T = c^2 = 1.
  const double y = 0.5, w = 1.0 + y * y, t = 3.0;
  const State<2> start{{0.0, y}, {1.0 / w, y / std::sqrt(w)}};
  const auto end = integrate<2>(free_bead, start, 1e-3, 3000);
  const double y_end = end.q[1];
  EXPECT_NEAR(end.q[0] + std::asinh(1.0 / y_end), std::asinh(1.0 / y), 1e-12);
  EXPECT_NEAR(std::sqrt(1.0 + y_end * y_end) - std::asinh(1.0 / y_end) - t,
              std::sqrt(w) - std::asinh(1.0 / y), 1e-12);
  EXPECT_NEAR(2.0 * kBead.kinetic_energy(end.q, end.v), 1.0, 1e-12);
  EXPECT_NEAR(kBead.momentum(end.q, end.v)[0], 1.0, 1e-12);

  // Twice as fast, it is at the same place in half the time, and twice as fast.
  const auto fast = integrate<2>(free_bead, {start.q, 2.0 * start.v}, 5e-4, 3000);
  EXPECT_LE((fast.q - end.q).norm(), 1e-12);
  EXPECT_LE((fast.v - 2.0 * end.v).norm(), 1e-12);
}

TEST(Course, Problem3AWeightlessArmFloatsAlongGeodesics) {
  const Mechanism arm(testing::read_urdf(GEODESIC_TEST_DATA "/oracles/planar2r.urdf"),
                      Eigen::Vector3d::Zero());
  Workspace workspace(arm);
  const auto free = [&](const Vector2d& q, const Vector2d& v) -> Vector2d {
    return *forward_dynamics(arm, workspace, q, v, Vector2d::Zero());
  };
  const State<2> start{{0.3, -0.8}, {1.5, 1.0}};

  // Newton's equation without torque says: the covariant derivative of v along itself is zero.
  Christoffel numbers(arm);
  christoffel_symbols(arm, workspace, start.q, numbers);
  const auto inverse = *invert<2>(metric(arm, workspace, start.q));
  const auto symbols = christoffel_second_kind<2>(inverse, ChartTensor3<2>::of(numbers));
  const Vector2d a = free(start.q, start.v);
  EXPECT_LE(covariant_derivative<2>(symbols, start.v, start.v, a).norm(), 1e-13);

  // Speed in the metric stays, and so does the momentum of turning the whole arm.
  const auto end = integrate<2>(free, start, 1e-3, 2000);
  EXPECT_NEAR(kinetic_energy(arm, workspace, end.q, end.v),
              kinetic_energy(arm, workspace, start.q, start.v), 1e-11);
  const double turning = (metric(arm, workspace, start.q) * start.v)[0];
  EXPECT_NEAR((metric(arm, workspace, end.q) * end.v)[0], turning, 1e-11);

  // Twice as fast, the same path.
  const auto fast = integrate<2>(free, {start.q, 2.0 * start.v}, 5e-4, 2000);
  EXPECT_LE((fast.q - end.q).norm(), 1e-11);
}

}  // namespace
}  // namespace geodesic::control::course
