// A Lagrangian of one's own, against mechanics worked out by hand: natural, gyroscopic, not
// quadratic in v, with a joint that is no rigid tree; against finite differences; and without heap.
#include "control/geometry/lagrangian.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "rt/heap_counter.hpp"

namespace geodesic::control {
namespace {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

template <class S>
using Pair = Eigen::Matrix<S, 2, 1>;
template <class S>
using Triple3 = Eigen::Matrix<S, 3, 1>;

/// A cart of mass m on a rail, under it a pendulum of mass b and length l.
struct CartPendulum {
  double m = 2.0, b = 0.7, l = 0.4, g = 9.81;

  template <class S>
  S operator()(const Pair<S>& q, const Pair<S>& v) const {
    using std::cos;
    using std::sin;
    const S x_rate = v[0] + l * cos(q[1]) * v[1];
    const S y_rate = l * sin(q[1]) * v[1];
    return 0.5 * m * v[0] * v[0] + 0.5 * b * (x_rate * x_rate + y_rate * y_rate) +
           b * g * l * cos(q[1]);
  }
};

TEST(Lagrangian, CartAndPendulum) {
  const CartPendulum p;
  const auto system = lagrangian<2>(p);
  const Vector2d q(0.3, 0.8), v(-0.6, 1.7), a(0.9, -2.2);
  const double c = std::cos(q[1]), s = std::sin(q[1]);
  const double mixed = p.b * p.l * c;
  Matrix2d m;
  m << p.m + p.b, mixed, mixed, p.b * p.l * p.l;
  const Vector2d coriolis(-p.b * p.l * s * v[1] * v[1], 0.0);
  const Vector2d gradient(0.0, p.b * p.g * p.l * s);
  EXPECT_LE((system.metric(q) - m).norm(), 1e-15);
  EXPECT_LE((system.metric(q, v) - m).norm(), 1e-15);
  EXPECT_LE((system.momentum(q, v) - m * v).norm(), 1e-15);
  EXPECT_LE((system.coriolis(q, v) - coriolis).norm(), 1e-14);
  EXPECT_LE((system.coriolis_matrix(q, v) * v - coriolis).norm(), 1e-14);
  EXPECT_LE((system.potential_differential(q) - gradient).norm(), 1e-15);
  EXPECT_LE((*system.potential_gradient(q) - m.inverse() * gradient).norm(), 1e-14);
  EXPECT_NEAR(system.potential_energy(q), -p.b * p.g * p.l * c, 1e-15);
  EXPECT_NEAR(system.kinetic_energy(q, v), 0.5 * v.dot(m * v), 1e-14);
  EXPECT_NEAR(system.energy(q, v), 0.5 * v.dot(m * v) - p.b * p.g * p.l * c, 1e-14);
  const Vector2d tau = m * a + coriolis + gradient;
  EXPECT_LE((system.euler_lagrange(q, v, a) - tau).norm(), 1e-14);
  EXPECT_LE((*system.forward_dynamics(q, v, tau) - a).norm(), 1e-14);
  EXPECT_EQ(system.gyroscopic_matrix(q), Matrix2d::Zero());
  const auto symbols = system.christoffel_first_kind(q);
  EXPECT_NEAR(symbols(0, 1, 1), -p.b * p.l * s, 1e-15);
  EXPECT_NEAR(symbols(1, 0, 1), 0.0, 1e-15);
}

/// A link on a motor through a spring, q = [link angle, motor angle]: no rigid tree, since the
/// spring stands between them. Equations of Spong 1987, "Modeling and control of elastic joint
/// robots".
TEST(Lagrangian, ElasticJoint) {
  const double inertia = 0.8, rotor = 0.05, stiffness = 120.0, weight = 6.0;  // weight: m g l
  const auto elastic = [=](const auto& q, const auto& v) {
    using std::cos;
    const auto stretch = q[0] - q[1];
    return 0.5 * inertia * v[0] * v[0] + 0.5 * rotor * v[1] * v[1] + weight * cos(q[0]) -
           0.5 * stiffness * stretch * stretch;
  };
  const auto system = lagrangian<2>(elastic);
  const Vector2d q(0.7, 0.9), v(1.0, -2.0);
  const double motor_torque = 3.0;
  const Vector2d a = *system.forward_dynamics(q, v, Vector2d(0.0, motor_torque));
  const double spring = stiffness * (q[1] - q[0]);
  EXPECT_NEAR(a[0], (spring - weight * std::sin(q[0])) / inertia, 1e-13);
  EXPECT_NEAR(a[1], (motor_torque - spring) / rotor, 1e-12);
}

/// A charge in a magnetic field along z, L = T + A(q) v with A = b/2 (-y, x): it circles.
TEST(Lagrangian, ChargeInAMagneticField) {
  const double m = 1.7, b = 0.6;
  const auto charge = [=](const auto& q, const auto& v) {
    return 0.5 * m * v.dot(v) + 0.5 * b * (q[0] * v[1] - q[1] * v[0]);
  };
  const auto system = lagrangian<2>(charge);
  const Vector2d q(0.4, -1.1), v(2.0, 0.5);
  const Vector2d a = *system.forward_dynamics(q, v, Vector2d::Zero());
  EXPECT_LE((a - b / m * Vector2d(v[1], -v[0])).norm(), 1e-15);
  Matrix2d g;
  g << 0.0, -b, b, 0.0;
  EXPECT_LE((system.gyroscopic_matrix(q) - g).norm(), 1e-15);
  EXPECT_LE((system.euler_lagrange(q, v, Vector2d::Zero()) - g * v).norm(), 1e-15);
  EXPECT_LE(system.coriolis(q, v).norm(), 1e-15);
  // The field does no work: energy is T, momentum is not M v.
  EXPECT_NEAR(system.energy(q, v), 0.5 * m * v.squaredNorm(), 1e-14);
  EXPECT_LE((system.momentum(q, v) - m * v - 0.5 * b * Vector2d(-q[1], q[0])).norm(), 1e-15);
}

/// Not quadratic in v: L = -m c^2 / gamma - V. Closed forms of special relativity.
TEST(Lagrangian, RelativisticParticle) {
  const double m = 1.3, c = 2.0, k = 0.9;
  const auto particle = [=](const auto& q, const auto& v) {
    using std::sqrt;
    return -m * c * c * sqrt(1.0 - v.dot(v) / (c * c)) - 0.5 * k * q.dot(q);
  };
  const auto system = lagrangian<3>(particle);
  const Vector3d q(0.2, -0.5, 0.8), v(0.9, -0.4, 1.1), force(0.3, 1.0, -0.7);
  const double gamma = 1.0 / std::sqrt(1.0 - v.squaredNorm() / (c * c));
  EXPECT_LE((system.momentum(q, v) - gamma * m * v).norm(), 1e-14);
  EXPECT_NEAR(system.energy(q, v), gamma * m * c * c + 0.5 * k * q.squaredNorm(), 1e-13);
  const Matrix3d mass =
      gamma * m * (Matrix3d::Identity() + gamma * gamma / (c * c) * v * v.transpose());
  EXPECT_LE((system.metric(q, v) - mass).norm(), 1e-13);
  const Vector3d f = force - k * q;
  const Vector3d a = (f - f.dot(v) / (c * c) * v) / (gamma * m);
  EXPECT_LE((*system.forward_dynamics(q, v, force) - a).norm(), 1e-13);
}

/// Everything at once, of no physical meaning: dense metric, gyroscopic term, potential.
struct Dense {
  template <class S>
  S operator()(const Triple3<S>& q, const Triple3<S>& v) const {
    using std::atan2;
    using std::cos;
    using std::exp;
    using std::log;
    using std::sin;
    const S x = v[0] + sin(q[1]) * v[2], y = exp(0.3 * q[0]) * v[1] - q[2] * v[0];
    const S z = (1.5 + cos(q[0] * q[1])) * v[2] + 0.2 * v[1];
    const S linear = q[1] * q[1] * v[0] + sin(q[0] + 2.0 * q[2]) * v[1] + q[0] * q[1] * v[2];
    return 0.5 * (x * x + y * y + z * z) + linear - log(2.0 + sin(q[0])) * q[2] +
           atan2(q[1], 2.0 + q[0] * q[0]);
  }
};

TEST(Lagrangian, EveryDerivativeAgreesWithFiniteDifferences) {
  const Dense dense;
  const auto system = lagrangian<3>(dense);
  const Vector3d q(0.4, -0.7, 0.3), v(0.8, 1.1, -0.5), a(-0.3, 0.6, 1.9);
  const double h = 1e-4;
  const auto unit = [](int i) { return Vector3d(Vector3d::Unit(i)); };
  const ChartMetric<3> at = system.chart_metric(q);
  const auto second = system.metric_second_derivative(q);
  for (int i = 0; i < 3; ++i) {
    const Vector3d e = h * unit(i);
    const double p = (dense(q, Vector3d(v + e)) - dense(q, Vector3d(v - e))) / (2.0 * h);
    EXPECT_NEAR(system.momentum(q, v)[i], p, 1e-8);
    const Vector3d column = (system.momentum(q, v + e) - system.momentum(q, v - e)) / (2.0 * h);
    EXPECT_LE((system.metric(q, v).col(i) - column).norm(), 1e-8);
    const Matrix3d slope = (system.metric(q + e) - system.metric(q - e)) / (2.0 * h);
    EXPECT_LE((at.derivative.slice[static_cast<std::size_t>(i)] - slope).norm(), 1e-7);
    const auto ahead = system.chart_metric(q + e), behind = system.chart_metric(q - e);
    for (std::size_t k = 0; k < 3; ++k) {
      const Matrix3d change = (ahead.derivative.slice[k] - behind.derivative.slice[k]) / (2.0 * h);
      EXPECT_LE((second.slice[static_cast<std::size_t>(i)].slice[k] - change).norm(), 1e-7);
    }
    // d/dt dL/dv - dL/dq along a motion with these v and a.
    const auto momentum_at = [&](double t) {
      return system.momentum(q + t * v + 0.5 * t * t * a, v + t * a)[i];
    };
    const double rate = (momentum_at(h) - momentum_at(-h)) / (2.0 * h);
    const double force = (dense(Vector3d(q + e), v) - dense(Vector3d(q - e), v)) / (2.0 * h);
    EXPECT_NEAR(system.euler_lagrange(q, v, a)[i], rate - force, 1e-7);
  }
}

TEST(Lagrangian, ThePartsAddUpToTheEquationsOfMotion) {
  const auto system = lagrangian<3>(Dense{});
  const Vector3d q(-0.9, 0.5, 1.2), v(0.8, 1.1, -0.5), a(-0.3, 0.6, 1.9);
  const Matrix3d c = system.coriolis_matrix(q, v), g = system.gyroscopic_matrix(q);
  const Vector3d tau = system.metric(q) * a + c * v + g * v + system.potential_differential(q);
  EXPECT_LE((system.euler_lagrange(q, v, a) - tau).norm(), 1e-13);
  EXPECT_LE((system.coriolis(q, v) - c * v).norm(), 1e-13);
  EXPECT_EQ(g, -g.transpose());
  // dM/dt = C + C', from the metric's derivative.
  const ChartMetric<3> at = system.chart_metric(q);
  Matrix3d rate = Matrix3d::Zero();
  for (int k = 0; k < 3; ++k) rate += v[k] * at.derivative.slice[static_cast<std::size_t>(k)];
  EXPECT_LE((rate - c - c.transpose()).norm(), 1e-14);
  // Energy changes by the power of tau alone.
  const double h = 1e-4;
  const auto energy_at = [&](double t) {
    return system.energy(q + t * v + 0.5 * t * t * a, v + t * a);
  };
  EXPECT_NEAR((energy_at(h) - energy_at(-h)) / (2.0 * h), tau.dot(v), 1e-7);
  EXPECT_LE((*system.forward_dynamics(q, v, tau) - a).norm(), 1e-13);
}

TEST(Lagrangian, MetricAndPotentialMakeANaturalOne) {
  const auto metric = []<class S>(const Pair<S>& q) {
    Eigen::Matrix<S, 2, 2> m;
    m << 1.0 + q[1] * q[1], 0.1 * q[0], 0.1 * q[0], S(2.0);
    return m;
  };
  const auto potential = [](const auto& q) { return q[0] * q[0] * q[1]; };
  const auto system = natural_lagrangian<2>(metric, potential);
  const Vector2d q(0.3, -0.9), v(1.0, 2.0);
  EXPECT_LE((system.metric(q) - metric(q)).norm(), 1e-15);
  EXPECT_NEAR(system.kinetic_energy(q, v), 0.5 * v.dot(metric(q) * v), 1e-14);
  EXPECT_LE((system.potential_differential(q) - Vector2d(2.0 * q[0] * q[1], q[0] * q[0])).norm(),
            1e-15);
}

TEST(Lagrangian, SaysWhereTheMetricIsSingular) {
  // Polar coordinates end at r = 0; a massless coordinate has no acceleration.
  const auto polar = [](const auto& q, const auto& v) {
    return 0.5 * (v[0] * v[0] + q[0] * q[0] * v[1] * v[1]);
  };
  const auto system = lagrangian<2>(polar);
  const Vector2d origin(0.0, 0.4), v(1.0, 1.0);
  EXPECT_FALSE(system.forward_dynamics(origin, v, v).has_value());
  EXPECT_FALSE(system.christoffel_second_kind(origin).has_value());
  EXPECT_FALSE(system.riemann_curvature(origin).has_value());
  EXPECT_FALSE(system.sectional_curvature(origin, v, origin).has_value());
  EXPECT_TRUE(system.forward_dynamics(Vector2d(0.1, 0.4), v, v).has_value());
}

TEST(Lagrangian, NothingAllocates) {
  const auto system = lagrangian<3>(Dense{});
  const Vector3d q(0.4, -0.7, 0.3), v(0.8, 1.1, -0.5);
  const auto before = rt::heap_calls();
  double sum = system.energy(q, v) + system.kinetic_energy(q, v) + system.metric(q, v).sum();
  sum += system.coriolis_matrix(q, v).sum() + system.coriolis(q, v).sum();
  sum += system.forward_dynamics(q, v, v)->sum() + *system.sectional_curvature(q, v, q);
  sum += system.gyroscopic_matrix(q).sum();
  EXPECT_EQ(rt::heap_calls() - before, 0U);
  EXPECT_TRUE(std::isfinite(sum));
}

}  // namespace
}  // namespace geodesic::control
