// Noether's theorem point by point: the rate of a momentum map along any motion is the generator's
// power, plus what the Lagrangian changes along the generator.
#include "control/geometry/symmetry.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

namespace geodesic::control {
namespace {

using Eigen::Vector3d;

/// A particle in a field that knows height only, in coordinates (x, y, z).
template <class S>
S particle(const Eigen::Matrix<S, 3, 1>& q, const Eigen::Matrix<S, 3, 1>& v) {
  using std::exp;
  return 0.5 * 1.7 * v.dot(v) - exp(0.3 * q[2]);
}

template <class S>
Eigen::Matrix<S, 3, 1> turn_about_z(const Eigen::Matrix<S, 3, 1>& q) {
  return {-q[1], q[0], S(0.0)};
}

template <class S>
Eigen::Matrix<S, 3, 1> turn_about_x(const Eigen::Matrix<S, 3, 1>& q) {
  return {S(0.0), -q[2], q[1]};
}

constexpr auto kSystem = [](const auto& q, const auto& v) { return particle(q, v); };
constexpr auto kAboutZ = [](const auto& q) { return turn_about_z(q); };
constexpr auto kAboutX = [](const auto& q) { return turn_about_x(q); };

TEST(Symmetry, MomentumMapsOfRotationsAreAngularMomenta) {
  const auto system = lagrangian<3>(kSystem);
  const Vector3d q(0.4, -1.1, 0.8), v(2.0, 0.5, -0.3);
  const Vector3d angular = 1.7 * q.cross(v);
  EXPECT_NEAR(momentum_map<3>(system, kAboutZ, q, v), angular.z(), 1e-15);
  EXPECT_NEAR(momentum_map<3>(system, kAboutX, q, v), angular.x(), 1e-15);
}

TEST(Symmetry, OnlyTheVerticalAxisIsOne) {
  const auto system = lagrangian<3>(kSystem);
  const Vector3d q(0.4, -1.1, 0.8), v(2.0, 0.5, -0.3);
  EXPECT_NEAR(invariance_defect<3>(system, kAboutZ, q, v), 0.0, 1e-15);
  EXPECT_NEAR(invariance_defect<3>(system, kAboutX, q, v), -0.3 * std::exp(0.3 * q.z()) * q.y(),
              1e-14);
}

TEST(Symmetry, RateOfTheMomentumMap) {
  const auto system = lagrangian<3>(kSystem);
  const Vector3d q(0.4, -1.1, 0.8), v(2.0, 0.5, -0.3), a(0.9, -0.2, 1.4);
  const Vector3d tau = system.euler_lagrange(q, v, a);
  const double h = 1e-4;
  const auto rate = [&](const auto& generator) {
    const auto at = [&](double t) {
      return momentum_map<3>(system, generator, q + t * v + 0.5 * t * t * a, v + t * a);
    };
    return (at(h) - at(-h)) / (2.0 * h);
  };
  EXPECT_NEAR(rate(kAboutZ), tau.dot(turn_about_z(q)), 1e-7);
  EXPECT_NEAR(rate(kAboutX), tau.dot(turn_about_x(q)) + invariance_defect<3>(system, kAboutX, q, v),
              1e-7);
}

}  // namespace
}  // namespace geodesic::control
