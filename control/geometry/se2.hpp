// Rigid motions of the plane: SE(2), the semidirect product of R2 by SO(2). Motions of space are in
// se3.hpp; the direct product R2 x SO(2), which a planar joint's coordinates live in, is in
// product.hpp.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <random>

#include "control/geometry/lie_group.hpp"
#include "control/geometry/r.hpp"
#include "control/geometry/series.hpp"
#include "control/geometry/so2.hpp"

namespace geodesic::control {

/// a_from_b: x_a = rotation * x_b + translation.
struct PlanePose {
  PlaneRotation rotation;
  Eigen::Vector2d translation = Eigen::Vector2d::Zero();  ///< [m]
};

/// As matrices: 3 x 3, [R p; 0 1]. A tangent is (linear x, linear y, angular).
/// Source: Chirikjian 2012, section 10.6.2; Sola, Deray, Atchuthan 2018, appendix C.
struct SE2 {
  static constexpr int kDimension = 3;
  using Element = PlanePose;
  using Tangent = Eigen::Vector3d;  ///< [m, m, rad], or the same per second
  using Jacobian = Eigen::Matrix3d;
  using Algebra = Eigen::Matrix3d;

  static Element identity() noexcept { return {}; }
  static Element compose(const Element& a, const Element& b) noexcept {
    return {a.rotation * b.rotation, a.rotation * b.translation + a.translation};
  }
  static Element inverse(const Element& g) noexcept {
    const PlaneRotation back = control::inverse(g.rotation);
    return {back, -(back * g.translation)};
  }
  static Element exp(const Tangent& x) noexcept {
    return {{std::cos(x[2]), std::sin(x[2])}, spread(x[2]) * x.head<2>()};
  }
  /// Angle in [-pi, pi].
  static Tangent log(const Element& g) noexcept {
    const double angle = std::atan2(g.rotation.sine, g.rotation.cosine);
    Tangent x;
    x << spread_inverse(angle) * g.translation, angle;
    return x;
  }
  static Algebra hat(const Tangent& x) noexcept {
    Algebra m;
    m << 0.0, -x[2], x[0], x[2], 0.0, x[1], 0.0, 0.0, 0.0;
    return m;
  }
  static Tangent vee(const Algebra& m) noexcept {
    return {m(0, 2), m(1, 2), 0.5 * (m(1, 0) - m(0, 1))};
  }
  static Algebra matrix(const Element& g) noexcept {
    Algebra m = Algebra::Identity();
    m.topLeftCorner<2, 2>() = control::matrix(g.rotation);
    m.topRightCorner<2, 1>() = g.translation;
    return m;
  }
  static Jacobian Ad(const Element& g) noexcept {
    Jacobian m = Jacobian::Identity();
    m.topLeftCorner<2, 2>() = control::matrix(g.rotation);
    m.topRightCorner<2, 1>() << g.translation.y(), -g.translation.x();
    return m;
  }
  static Jacobian ad(const Tangent& x) noexcept {
    Jacobian m;
    m << 0.0, -x[2], x[1], x[2], 0.0, -x[0], 0.0, 0.0, 0.0;
    return m;
  }
  static Jacobian left_jacobian(const Tangent& x) noexcept {
    Jacobian m = Jacobian::Identity();
    m.topLeftCorner<2, 2>() = spread(x[2]);
    m.topRightCorner<2, 1>() = shear(x);
    return m;
  }
  /// |angle| < 2 pi.
  static Jacobian left_jacobian_inverse(const Tangent& x) noexcept {
    const Eigen::Matrix2d back = spread_inverse(x[2]);
    Jacobian m = Jacobian::Identity();
    m.topLeftCorner<2, 2>() = back;
    m.topRightCorner<2, 1>() = -(back * shear(x));
    return m;
  }
  static double distance(const Element& a, const Element& b, double metres_per_radian) noexcept {
    return std::hypot(R2::distance(a.translation, b.translation, 1.0),
                      SO2::distance(a.rotation, b.rotation, metres_per_radian));
  }
  template <std::uniform_random_bit_generator Engine>
  static Element random(Engine& engine) {
    const PlaneRotation rotation = SO2::random(engine);
    return {rotation, R2::random(engine)};
  }

 private:
  /// The integral of the rotations by s * angle over s from 0 to 1.
  static Eigen::Matrix2d spread(double angle) noexcept {
    return control::matrix(PlaneRotation{sinc(angle), angle * versine_second(angle)});
  }
  static Eigen::Matrix2d spread_inverse(double angle) noexcept {
    const double cotangent = 1.0 - angle * angle * cotangent_second(angle);  // (t/2) cot(t/2)
    return control::matrix(PlaneRotation{cotangent, -0.5 * angle});
  }
  /// Last column of the left Jacobian.
  static Eigen::Vector2d shear(const Tangent& x) noexcept {
    return (x[2] * versine_third(x[2])) * x.head<2>() +
           versine_second(x[2]) * Eigen::Vector2d(x[1], -x[0]);
  }
};

static_assert(LieGroup<SE2>);

}  // namespace geodesic::control
