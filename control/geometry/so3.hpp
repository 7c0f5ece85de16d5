// Rotations of space: the Lie algebra so(3) as vectors, and its exponential map. Rigid motions are
// in se3.hpp.
#pragma once

#include <Eigen/Core>
#include <cmath>

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

/// sin(x) / x, continued by 1 at 0. Exact to rounding everywhere: the division loses nothing.
inline double sinc(double x) noexcept {
  return x == 0.0 ? 1.0 : std::sin(x) / x;
}

/// Rotation by |w| [rad] about w: Rodrigues' formula, its second coefficient (1 - cos t) / t^2
/// written as sinc(t/2)^2 / 2 so that small angles lose no digit. Real-time.
inline Eigen::Matrix3d exp(const Eigen::Vector3d& w) noexcept {
  const double angle = w.norm();
  const double half_sinc = sinc(0.5 * angle);
  const Eigen::Matrix3d w_hat = hat(w);
  return Eigen::Matrix3d::Identity() + sinc(angle) * w_hat +
         (0.5 * half_sinc * half_sinc) * (w_hat * w_hat);
}

}  // namespace geodesic::control
