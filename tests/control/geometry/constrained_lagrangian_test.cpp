// Constrained systems whose motion is known: a disk that rolls, the Chaplygin sleigh, a pendulum
// in Cartesian coordinates; and what holds for any.
#include "control/geometry/constrained_lagrangian.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "rt/heap_counter.hpp"

namespace geodesic::control {
namespace {

using Eigen::Matrix3d;
using Eigen::Matrix4d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector4d;

constexpr double kMass = 1.4, kRadius = 0.3, kSpin = 0.09, kTurn = 0.05;

/// A disk upright on a plane, q = [contact x, y, heading, roll]: dx = r cos(heading) droll, dy = r
/// sin(heading) droll.
auto rolling_disk() {
  const auto free = lagrangian<4>([](const auto& q, const auto& v) {
    (void)q;
    return 0.5 * (kMass * (v[0] * v[0] + v[1] * v[1]) + kTurn * v[2] * v[2] + kSpin * v[3] * v[3]);
  });
  return constrained<2>(free, []<class S>(const Eigen::Matrix<S, 4, 1>& q) {
    using std::cos;
    using std::sin;
    Eigen::Matrix<S, 2, 4> a = Eigen::Matrix<S, 2, 4>::Zero();
    a(0, 0) = a(1, 1) = 1.0;
    a(0, 3) = -kRadius * cos(q[2]);
    a(1, 3) = -kRadius * sin(q[2]);
    return a;
  });
}

/// As in Bullo, Lewis 2005, section 4.5: (I + m r^2) d2roll = torque, J d2heading = torque,
/// and the ground's force is m times the contact's acceleration.
TEST(ConstrainedLagrangian, RollingDisk) {
  const auto disk = rolling_disk();
  const Vector4d q(0.2, -0.4, 0.7, 1.9);
  const double turn = 1.3, roll = -2.1, c = std::cos(q[2]), s = std::sin(q[2]);
  const Vector4d v(kRadius * c * roll, kRadius * s * roll, turn, roll);
  const Vector4d tau(0.0, 0.0, 0.4, 0.7);
  const auto motion = *disk.forward_dynamics(q, v, tau);
  const double roll_rate = tau[3] / (kSpin + kMass * kRadius * kRadius);
  EXPECT_NEAR(motion.acceleration[2], tau[2] / kTurn, 1e-13);
  EXPECT_NEAR(motion.acceleration[3], roll_rate, 1e-13);
  const Vector2d contact(kRadius * (c * roll_rate - s * turn * roll),
                         kRadius * (s * roll_rate + c * turn * roll));
  EXPECT_LE((motion.acceleration.head<2>() - contact).norm(), 1e-13);
  EXPECT_LE((motion.multipliers - kMass * contact).norm(), 1e-13);
  // Free, it circles at constant speed.
  const auto free = *disk.forward_dynamics(q, v, Vector4d::Zero());
  EXPECT_LE(free.acceleration.tail<2>().norm(), 1e-14);
  EXPECT_NEAR(free.acceleration.head<2>().norm(), std::abs(kRadius * roll * turn), 1e-13);
}

/// A blade at distance a behind the centre of mass of a sled, q = [blade x, y, heading]; u the
/// speed along the blade: du = a w^2, (I + m a^2) dw = -m a u w (Chaplygin 1911).
TEST(ConstrainedLagrangian, ChaplyginSleigh) {
  const double a = 0.25, inertia = 0.07;
  const auto sled =
      constrained<1>(lagrangian<3>([=](const auto& q, const auto& v) {
                       using std::cos;
                       using std::sin;
                       const auto x = v[0] - a * sin(q[2]) * v[2];
                       const auto y = v[1] + a * cos(q[2]) * v[2];
                       return 0.5 * kMass * (x * x + y * y) + 0.5 * inertia * v[2] * v[2];
                     }),
                     []<class S>(const Eigen::Matrix<S, 3, 1>& q) {
                       using std::cos;
                       using std::sin;
                       Eigen::Matrix<S, 1, 3> row;
                       row << -sin(q[2]), cos(q[2]), S(0.0);
                       return row;
                     });
  const Vector3d q(1.0, -2.0, 0.6);
  const double u = 0.8, w = -1.5, c = std::cos(q[2]), s = std::sin(q[2]);
  const auto motion = *sled.forward_dynamics(q, {u * c, u * s, w}, Vector3d::Zero());
  const double along_blade = c * motion.acceleration[0] + s * motion.acceleration[1];
  EXPECT_NEAR(along_blade, a * w * w, 1e-14);
  EXPECT_NEAR(motion.acceleration[2], -kMass * a * u * w / (inertia + kMass * a * a), 1e-14);
}

/// x^2 + y^2 = l^2 with gravity along -y: d2angle = -g / l sin(angle), and lambda carries the
/// weight and the centripetal force.
TEST(ConstrainedLagrangian, PendulumInCartesianCoordinates) {
  const double g = 9.81, l = 0.6;
  const auto mass = lagrangian<2>(
      [=](const auto& q, const auto& v) { return 0.5 * kMass * v.dot(v) - kMass * g * q[1]; });
  const auto pendulum =
      constrained<1>(mass, differential<1>([]<class S>(const Eigen::Matrix<S, 2, 1>& q) {
                       return Eigen::Matrix<S, 1, 1>(0.5 * q.dot(q));
                     }));
  const double angle = 0.9, rate = 2.2;
  const Vector2d outward(std::sin(angle), -std::cos(angle));
  const Vector2d onward(std::cos(angle), std::sin(angle));
  const auto motion = *pendulum.forward_dynamics(l * outward, l * rate * onward, Vector2d::Zero());
  EXPECT_NEAR(onward.dot(motion.acceleration), -g * std::sin(angle), 1e-14);
  EXPECT_NEAR(outward.dot(motion.acceleration), -l * rate * rate, 1e-14);
  const double pull = kMass * (g * std::cos(angle) + l * rate * rate);
  EXPECT_NEAR(motion.multipliers[0], -pull / l, 1e-13);
  EXPECT_LE((pendulum.constraint(l * outward) - l * outward.transpose()).norm(), 1e-15);
}

TEST(ConstrainedLagrangian, WhatHoldsForAny) {
  // A dense metric under one constraint that is not integrable.
  const auto free = lagrangian<3>([](const auto& q, const auto& v) {
    using std::cos;
    using std::sin;
    const auto a = v[0] + sin(q[1]) * v[2];
    const auto b = (2.0 + cos(q[0])) * v[1] - q[2] * v[0];
    return 0.5 * (a * a + b * b + 0.3 * v.dot(v)) - sin(q[0]) * q[1] + 0.5 * q[2] * v[0];
  });
  const auto system = constrained<1>(free, []<class S>(const Eigen::Matrix<S, 3, 1>& q) {
    using std::exp;
    Eigen::Matrix<S, 1, 3> row;
    row << q[1], -1.0 + q[0] * q[2], exp(0.2 * q[0]);
    return row;
  });
  const Vector3d q(0.4, -0.8, 1.1), tau(0.3, -0.2, 0.9), any(1.0, 0.7, -0.4);
  const Matrix3d p = *system.projection(q), m = free.metric(q);
  EXPECT_LE((p * p - p).norm(), 1e-14);
  EXPECT_LE((system.constraint(q) * p).norm(), 1e-14);
  EXPECT_LE((m * p - (m * p).transpose()).norm(), 1e-14);
  EXPECT_NEAR(p.trace(), 2.0, 1e-14);
  const Vector3d v = p * any;
  const auto motion = *system.forward_dynamics(q, v, tau);
  // The law, and the constraint's rate along the motion by finite differences.
  const Vector3d force = system.constraint(q).transpose() * motion.multipliers;
  EXPECT_LE((free.euler_lagrange(q, v, motion.acceleration) - tau - force).norm(), 1e-14);
  EXPECT_NEAR(force.dot(v), 0.0, 1e-14) << "constraints do no work";
  const double h = 1e-4;
  const auto kept = [&](double t) -> double {
    return (system.constraint(q + t * v + 0.5 * t * t * motion.acceleration) *
            (v + t * motion.acceleration))[0];
  };
  EXPECT_NEAR((kept(h) - kept(-h)) / (2.0 * h), 0.0, 1e-7);
  // Gauss 1829: of all accelerations that the constraint allows, the nearest to the free one.
  const Vector3d pull = motion.acceleration - *free.forward_dynamics(q, v, tau);
  EXPECT_NEAR(pull.dot(m * p * any), 0.0, 1e-14);
}

TEST(ConstrainedLagrangian, AConstraintTwiceIsSaidNotSolved) {
  const auto free = lagrangian<2>([](const auto& q, const auto& v) {
    (void)q;
    return 0.5 * v.dot(v);
  });
  const auto twice = constrained<2>(free, []<class S>(const Eigen::Matrix<S, 2, 1>& q) {
    Eigen::Matrix<S, 2, 2> a;
    a << S(1.0), q[0], S(2.0), 2.0 * q[0];
    return a;
  });
  const Vector2d q(0.7, 0.1);
  EXPECT_FALSE(twice.forward_dynamics(q, {0.0, 0.0}, q).has_value());
  EXPECT_FALSE(twice.projection(q).has_value());
}

TEST(ConstrainedLagrangian, NothingAllocates) {
  const auto disk = rolling_disk();
  const Vector4d q(0.2, -0.4, 0.7, 1.9), v(0.0, 0.0, 1.0, 0.0);
  const auto before = rt::heap_calls();
  const double sum = disk.forward_dynamics(q, v, q)->acceleration.sum() + disk.projection(q)->sum();
  EXPECT_EQ(rt::heap_calls() - before, 0U);
  EXPECT_TRUE(std::isfinite(sum));
}

}  // namespace
}  // namespace geodesic::control
