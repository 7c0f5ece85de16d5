// Rotations of the plane: the circle S1 = SO(2). Those of space are in so3.hpp.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <numbers>
#include <random>

#include "control/geometry/lie_group.hpp"

namespace geodesic::control {

/// A point of the circle.
struct PlaneRotation {
  double cosine = 1.0;
  double sine = 0.0;
};

inline PlaneRotation operator*(const PlaneRotation& a, const PlaneRotation& b) noexcept {
  return {a.cosine * b.cosine - a.sine * b.sine, a.sine * b.cosine + a.cosine * b.sine};
}

inline Eigen::Vector2d operator*(const PlaneRotation& r, const Eigen::Vector2d& x) noexcept {
  return {r.cosine * x.x() - r.sine * x.y(), r.sine * x.x() + r.cosine * x.y()};
}

inline PlaneRotation inverse(const PlaneRotation& r) noexcept {
  return {r.cosine, -r.sine};
}

inline Eigen::Matrix2d matrix(const PlaneRotation& r) noexcept {
  Eigen::Matrix2d m;
  m << r.cosine, -r.sine, r.sine, r.cosine;
  return m;
}

/// Angle from `from` to `to` the shorter way round [rad], in [-pi, pi]; exact to rounding of the
/// difference. Real-time.
inline double shortest_turn(double from, double to) noexcept {
  return std::remainder(to - from, 2.0 * std::numbers::pi);
}

/// As matrices: 2 x 2 rotations.
struct SO2 {
  static constexpr int kDimension = 1;
  using Element = PlaneRotation;
  using Tangent = Eigen::Matrix<double, 1, 1>;  ///< [rad, or rad/s]
  using Jacobian = Eigen::Matrix<double, 1, 1>;
  using Algebra = Eigen::Matrix2d;

  static Element identity() noexcept { return {}; }
  static Element compose(const Element& a, const Element& b) noexcept { return a * b; }
  static Element inverse(const Element& g) noexcept { return control::inverse(g); }
  static Element exp(const Tangent& x) noexcept { return {std::cos(x[0]), std::sin(x[0])}; }
  /// In [-pi, pi].
  static Tangent log(const Element& g) noexcept {
    return Tangent::Constant(std::atan2(g.sine, g.cosine));
  }
  static Algebra hat(const Tangent& x) noexcept {
    Algebra m;
    m << 0.0, -x[0], x[0], 0.0;
    return m;
  }
  static Tangent vee(const Algebra& m) noexcept {
    return Tangent::Constant(0.5 * (m(1, 0) - m(0, 1)));
  }
  static Algebra matrix(const Element& g) noexcept { return control::matrix(g); }
  static Jacobian Ad(const Element& /*g*/) noexcept { return Jacobian::Identity(); }
  static Jacobian ad(const Tangent& /*x*/) noexcept { return Jacobian::Zero(); }
  static Jacobian left_jacobian(const Tangent& /*x*/) noexcept { return Jacobian::Identity(); }
  static Jacobian left_jacobian_inverse(const Tangent& /*x*/) noexcept {
    return Jacobian::Identity();
  }
  static double distance(const Element& a, const Element& b, double metres_per_radian) noexcept {
    return metres_per_radian * std::abs(difference_of_angles(a, b));
  }
  template <std::uniform_random_bit_generator Engine>
  static Element random(Engine& engine) {
    std::uniform_real_distribution<double> angle(-std::numbers::pi, std::numbers::pi);
    return exp(Tangent::Constant(angle(engine)));
  }

 private:
  static double difference_of_angles(const Element& a, const Element& b) noexcept {
    return log(control::inverse(a) * b)[0];
  }
};

static_assert(LieGroup<SO2>);

}  // namespace geodesic::control
