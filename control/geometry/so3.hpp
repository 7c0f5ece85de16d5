// Rotations of space: the Lie algebra so(3) as vectors, the exponential map to matrices and to unit
// quaternions, its logarithm and its Jacobians. Rigid motions are in se3.hpp.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <random>

#include "control/geometry/lie_group.hpp"
#include "control/geometry/series.hpp"

namespace geodesic::control {

/// The matrix of w ^ : hat(w) x = w x x (cross product). Real-time.
inline Eigen::Matrix3d hat(const Eigen::Vector3d& w) noexcept {
  Eigen::Matrix3d m;
  m << 0.0, -w.z(), w.y(), w.z(), 0.0, -w.x(), -w.y(), w.x(), 0.0;
  return m;
}

/// Inverse of hat() on skew-symmetric matrices; of any other the skew part counts. Real-time.
inline Eigen::Vector3d vee(const Eigen::Matrix3d& m) noexcept {
  return 0.5 * Eigen::Vector3d(m(2, 1) - m(1, 2), m(0, 2) - m(2, 0), m(1, 0) - m(0, 1));
}

/// Rotation by |w| [rad] about w: Rodrigues' formula, its second coefficient (1 - cos t) / t^2
/// written as sinc(t/2)^2 / 2 so that small angles lose no digit. Real-time.
inline Eigen::Matrix3d exp(const Eigen::Vector3d& w) noexcept {
  const double angle = w.norm();
  const Eigen::Matrix3d w_hat = hat(w);
  return Eigen::Matrix3d::Identity() + sinc(angle) * w_hat +
         versine_second(angle) * (w_hat * w_hat);
}

/// The same rotation as a unit quaternion. Real-time.
inline Eigen::Quaterniond quaternion_exp(const Eigen::Vector3d& w) noexcept {
  const double half = 0.5 * w.norm();
  Eigen::Quaterniond result;
  result.w() = std::cos(half);
  result.vec() = (0.5 * sinc(half)) * w;
  return result;
}

/// The w with |w| <= pi that exp() maps to the rotation [rad]. At pi exactly, where w and -w are
/// the same rotation, one of the two. A quaternion that is not of unit length stands for the one
/// that is. Exact to rounding at every angle: the half angle is that of the quaternion's scalar and
/// its vector, and at least one of them is not small. Real-time.
inline Eigen::Vector3d log(const Eigen::Quaterniond& rotation) noexcept {
  const double sign = std::signbit(rotation.w()) ? -1.0 : 1.0;
  const double w = std::abs(rotation.w());
  const double n = rotation.vec().norm();
  // Where n underflows, the angle over n is 2 / w to rounding.
  const double scale = n > 1e-150 ? 2.0 * std::atan2(n, w) / n : 2.0 / w;
  return (sign * scale) * rotation.vec();
}

/// A quaternion of the rotation; small angles keep their relative precision, and so does what is
/// left to a half turn. Source: Shepperd 1978, "Quaternion from rotation matrix": the largest of
/// the four components is computed first, so that no division is by a small number. Real-time.
inline Eigen::Quaterniond to_quaternion(const Eigen::Matrix3d& r) noexcept {
  const double trace = r.trace();
  Eigen::Quaterniond q;
  if (trace > 0.0) {
    const double w2 = std::sqrt(1.0 + trace);  // twice w
    q.w() = 0.5 * w2;
    q.vec() = vee(r) / w2;
    return q;
  }
  Eigen::Index i = 0;
  r.diagonal().maxCoeff(&i);
  const Eigen::Index j = (i + 1) % 3;
  const Eigen::Index k = (i + 2) % 3;
  const double v2 = std::sqrt(1.0 + r(i, i) - r(j, j) - r(k, k));  // twice the component i
  q.vec()[i] = 0.5 * v2;
  q.vec()[j] = 0.5 * (r(j, i) + r(i, j)) / v2;
  q.vec()[k] = 0.5 * (r(k, i) + r(i, k)) / v2;
  q.w() = 0.5 * (r(k, j) - r(j, k)) / v2;
  return q;
}

/// As of the quaternion. Near pi an angle is known from the matrix's skew part, a direction from
/// its symmetric part. Real-time.
inline Eigen::Vector3d log(const Eigen::Matrix3d& rotation) noexcept {
  return log(to_quaternion(rotation));
}

/// J_l(w): exp(w + d) = exp(J_l d) exp(w) to first order. Real-time.
/// Source: Chirikjian 2012, equation 10.86; Barfoot 2017, equation 7.37.
inline Eigen::Matrix3d left_jacobian(const Eigen::Vector3d& w) noexcept {
  const double angle = w.norm();
  const Eigen::Matrix3d w_hat = hat(w);
  return Eigen::Matrix3d::Identity() + versine_second(angle) * w_hat +
         versine_third(angle) * (w_hat * w_hat);
}

/// Inverse of J_l(w), |w| < 2 pi. Real-time. Source: Chirikjian 2012, equation 10.86.
inline Eigen::Matrix3d left_jacobian_inverse(const Eigen::Vector3d& w) noexcept {
  const Eigen::Matrix3d w_hat = hat(w);
  return Eigen::Matrix3d::Identity() - 0.5 * w_hat + cotangent_second(w.norm()) * (w_hat * w_hat);
}

/// J_r(w): exp(w + d) = exp(w) exp(J_r d) to first order; J_l(-w), and its transpose. Real-time.
inline Eigen::Matrix3d right_jacobian(const Eigen::Vector3d& w) noexcept {
  return left_jacobian(-w);
}

/// Inverse of J_r(w), |w| < 2 pi: the rate of w for a body's angular velocity in its own axes.
/// Real-time.
inline Eigen::Matrix3d right_jacobian_inverse(const Eigen::Vector3d& w) noexcept {
  return left_jacobian_inverse(-w);
}

/// By Haar's measure. Source: Shoemake 1992, "Uniform random rotations".
template <std::uniform_random_bit_generator Engine>
Eigen::Quaterniond random_rotation(Engine& engine) {
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  const double share = uniform(engine);
  const double a = 2.0 * std::numbers::pi * uniform(engine);
  const double b = 2.0 * std::numbers::pi * uniform(engine);
  const double near = std::sqrt(1.0 - share);
  const double far = std::sqrt(share);
  return {far * std::cos(b), near * std::sin(a), near * std::cos(a), far * std::sin(b)};
}

/// As matrices: 3 x 3 rotations; as elements: unit quaternions, of which g and -g are the same.
struct SO3 {
  static constexpr int kDimension = 3;
  using Element = Eigen::Quaterniond;
  using Tangent = Eigen::Vector3d;  ///< [rad, or rad/s]
  using Jacobian = Eigen::Matrix3d;
  using Algebra = Eigen::Matrix3d;

  static Element identity() noexcept { return Element::Identity(); }
  static Element compose(const Element& a, const Element& b) noexcept { return a * b; }
  static Element inverse(const Element& g) noexcept { return g.conjugate(); }
  static Element exp(const Tangent& x) noexcept { return quaternion_exp(x); }
  static Tangent log(const Element& g) noexcept { return control::log(g); }
  static Algebra hat(const Tangent& x) noexcept { return control::hat(x); }
  static Tangent vee(const Algebra& m) noexcept { return control::vee(m); }
  static Algebra matrix(const Element& g) noexcept { return g.toRotationMatrix(); }
  static Jacobian Ad(const Element& g) noexcept { return g.toRotationMatrix(); }
  static Jacobian ad(const Tangent& x) noexcept { return control::hat(x); }
  static Jacobian left_jacobian(const Tangent& x) noexcept { return control::left_jacobian(x); }
  static Jacobian left_jacobian_inverse(const Tangent& x) noexcept {
    return control::left_jacobian_inverse(x);
  }
  static double distance(const Element& a, const Element& b, double metres_per_radian) noexcept {
    return metres_per_radian * log(a.conjugate() * b).norm();
  }
  template <std::uniform_random_bit_generator Engine>
  static Element random(Engine& engine) {
    return random_rotation(engine);
  }
};

static_assert(LieGroup<SO3>);

}  // namespace geodesic::control
