// Problem 4. Noether's theorem on SE(2).
//
// A body floats in the plane, its centre of mass at (x, y), turned by t; hinged to it at distance d
// along its own first axis is a rod whose centre of mass is r from the hinge, at the angle f to the
// body. A motor in the hinge turns it. q = (x, y, t, f). Find the momenta that every motion
// conserves whatever the motor does, by the symmetry that causes them.
//
// By hand. The group SE(2) moves the whole plane: (x, y) -> R (x, y) + b, t -> t + angle of R, f
// stays. No distance changes, so L = T does not. Its generators, the velocities of such motions at
// q, are
//
//     xi_1 = (1, 0, 0, 0)       xi_2 = (0, 1, 0, 0)       xi_3 = (-y, x, 1, 0)
//
// and the momentum map is J_i = <dL/dv, xi_i>, which comes out as linear and angular momentum,
//
//     (J_1, J_2) = m0 x0' + m1 x1'           (x0, x1 the centres of mass)
//     J_3 = m0 x0 ^ x0' + m1 x1 ^ x1' + I0 t' + I1 (t' + f')        (about the origin)
//
// d/dt J_i = <tau, xi_i> is zero for the motor's torque tau = (0, 0, 0, u). Moved by a translation
// b, the system has J_3 + b ^ (J_1, J_2): momenta are covectors of the group, moved by Ad*. Gravity
// along -y leaves J_1 alone: a translation along x is what it does not see.
#include <gtest/gtest.h>

#include <cmath>

#include "control/geometry/symmetry.hpp"
#include "tests/control/geometry/course/runge_kutta.hpp"

namespace geodesic::control::course {
namespace {

using Eigen::Vector2d;
using Eigen::Vector4d;

constexpr double kM0 = 3.0, kI0 = 0.2, kM1 = 0.8, kI1 = 0.03, kD = 0.3, kR = 0.25;

/// L = T - V with gravity g along -y.
struct BodyAndRod {
  double gravity = 0.0;

  template <class S>
  S operator()(const Eigen::Matrix<S, 4, 1>& q, const Eigen::Matrix<S, 4, 1>& v) const {
    using std::cos;
    using std::sin;
    const S body = q[2], rod = q[2] + q[3], body_rate = v[2], rod_rate = v[2] + v[3];
    const S height = q[1] + kD * sin(body) + kR * sin(rod);
    const S x_rate = v[0] - kD * sin(body) * body_rate - kR * sin(rod) * rod_rate;
    const S y_rate = v[1] + kD * cos(body) * body_rate + kR * cos(rod) * rod_rate;
    return 0.5 * kM0 * (v[0] * v[0] + v[1] * v[1]) + 0.5 * kI0 * body_rate * body_rate +
           0.5 * kM1 * (x_rate * x_rate + y_rate * y_rate) + 0.5 * kI1 * rod_rate * rod_rate -
           gravity * (kM0 * q[1] + kM1 * height);
  }
};

constexpr auto kAlongX = []<class S>(const Eigen::Matrix<S, 4, 1>&) {
  return Eigen::Matrix<S, 4, 1>(S(1.0), S(0.0), S(0.0), S(0.0));
};
constexpr auto kAlongY = []<class S>(const Eigen::Matrix<S, 4, 1>&) {
  return Eigen::Matrix<S, 4, 1>(S(0.0), S(1.0), S(0.0), S(0.0));
};
constexpr auto kTurn = []<class S>(const Eigen::Matrix<S, 4, 1>& q) {
  return Eigen::Matrix<S, 4, 1>(-q[1], q[0], S(1.0), S(0.0));
};

/// (J_1, J_2, J_3) by the library.
template <class System>
Eigen::Vector3d momenta(const System& system, const Vector4d& q, const Vector4d& v) {
  return {momentum_map<4>(system, kAlongX, q, v), momentum_map<4>(system, kAlongY, q, v),
          momentum_map<4>(system, kTurn, q, v)};
}

double wedge(const Vector2d& a, const Vector2d& b) {
  return a[0] * b[1] - a[1] * b[0];
}

Eigen::Vector3d momenta_by_hand(const Vector4d& q, const Vector4d& v) {
  const double rod = q[2] + q[3], rod_rate = v[2] + v[3];
  const Vector2d x0 = q.head<2>(), x0_rate = v.head<2>();
  const Vector2d x1 = x0 + kD * Vector2d(std::cos(q[2]), std::sin(q[2])) +
                      kR * Vector2d(std::cos(rod), std::sin(rod));
  const Vector2d x1_rate = x0_rate + kD * v[2] * Vector2d(-std::sin(q[2]), std::cos(q[2])) +
                           kR * rod_rate * Vector2d(-std::sin(rod), std::cos(rod));
  const Vector2d linear = kM0 * x0_rate + kM1 * x1_rate;
  return {linear[0], linear[1],
          kM0 * wedge(x0, x0_rate) + kM1 * wedge(x1, x1_rate) + kI0 * v[2] + kI1 * rod_rate};
}

TEST(Course, Problem4MomentumMapOfSe2) {
  const auto system = lagrangian<4>(BodyAndRod{});
  const Vector4d q(0.4, -0.9, 0.6, 1.3), v(0.5, -0.2, 1.7, -2.4);
  const Eigen::Vector3d j = momenta(system, q, v);
  EXPECT_LE((j - momenta_by_hand(q, v)).norm(), 1e-14);

  // L does not change along the generators: they are symmetries.
  EXPECT_NEAR(invariance_defect<4>(system, kAlongX, q, v), 0.0, 1e-14);
  EXPECT_NEAR(invariance_defect<4>(system, kAlongY, q, v), 0.0, 1e-14);
  EXPECT_NEAR(invariance_defect<4>(system, kTurn, q, v), 0.0, 1e-14);

  // Ad*: the same motion elsewhere.
  const Vector2d b(2.0, -1.0);
  Vector4d moved = q;
  moved.head<2>() += b;
  const Eigen::Vector3d there = momenta(system, moved, v);
  EXPECT_LE((there.head<2>() - j.head<2>()).norm(), 1e-14);
  EXPECT_NEAR(there[2], j[2] + wedge(b, j.head<2>()), 1e-14);
}

TEST(Course, Problem4MomentaStayWhateverTheMotorDoes) {
  const auto system = lagrangian<4>(BodyAndRod{});
  const auto driven = [&](const Vector4d& q, const Vector4d& v) -> Vector4d {
    const double u = 0.7 * std::cos(3.0 * q[3]) - 0.2 * v[3];
    return *system.forward_dynamics(q, v, Vector4d(0.0, 0.0, 0.0, u));
  };
  const State<4> start{{0.4, -0.9, 0.6, 1.3}, {0.5, -0.2, 0.3, -1.0}};
  const auto end = integrate<4>(driven, start, 1e-3, 2000);
  EXPECT_LE((momenta(system, end.q, end.v) - momenta(system, start.q, start.v)).norm(), 1e-11);
  // The motor did something all the while.
  EXPECT_GT(std::abs(system.energy(end.q, end.v) - system.energy(start.q, start.v)), 1e-2);
}

TEST(Course, Problem4GravityLeavesTheMomentumAcrossIt) {
  const auto system = lagrangian<4>(BodyAndRod{9.81});
  const Vector4d q(0.4, -0.9, 0.6, 1.3), v(0.5, -0.2, 1.7, -2.4);
  const Vector4d a = *system.forward_dynamics(q, v, Vector4d::Zero());
  const auto rate_of = [&](int i) {  // d/dt J_i along the free motion
    const double h = 1e-4;
    const auto at = [&](double t) {
      return momenta(system, q + t * v + 0.5 * t * t * a, v + t * a)[i];
    };
    return (at(h) - at(-h)) / (2.0 * h);
  };
  const double weight = (kM0 + kM1) * 9.81;
  EXPECT_NEAR(invariance_defect<4>(system, kAlongX, q, v), 0.0, 1e-13);
  EXPECT_NEAR(invariance_defect<4>(system, kAlongY, q, v), -weight, 1e-13);
  EXPECT_NEAR(rate_of(0), 0.0, 1e-6);
  EXPECT_NEAR(rate_of(1), -weight, 1e-6);
  EXPECT_NEAR(rate_of(2), invariance_defect<4>(system, kTurn, q, v), 1e-6);
}

}  // namespace
}  // namespace geodesic::control::course
