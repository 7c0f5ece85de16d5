// Rigid motions of space: Pose (an element of SE(3)) and Twist (an element of its Lie algebra),
// and how a pose carries twists between frames. Wrenches and inertias are in spatial.hpp.
#pragma once

#include <Eigen/Core>

#include "control/geometry/so3.hpp"

namespace geodesic::control {

/// a_from_b: x_a = rotation * x_b + translation. Names say both frames: world_from_tool.
struct Pose {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();  ///< [m]
};

/// a_from_c = a_from_b * b_from_c.
inline Pose operator*(const Pose& a_from_b, const Pose& b_from_c) noexcept {
  return {a_from_b.rotation * b_from_c.rotation,
          a_from_b.rotation * b_from_c.translation + a_from_b.translation};
}

inline Pose inverse(const Pose& pose) noexcept {
  return {pose.rotation.transpose(), -(pose.rotation.transpose() * pose.translation)};
}

/// Velocity of a rigid body in the coordinates of a frame: `linear` is the velocity of the point
/// of the body that is at the frame's origin. Where six numbers stand in a vector, the linear ones
/// come first.
struct Twist {
  Eigen::Vector3d linear = Eigen::Vector3d::Zero();   ///< [m/s]
  Eigen::Vector3d angular = Eigen::Vector3d::Zero();  ///< [rad/s]
};

inline Twist operator+(const Twist& a, const Twist& b) noexcept {
  return {a.linear + b.linear, a.angular + b.angular};
}

inline Twist operator*(double s, const Twist& a) noexcept {
  return {s * a.linear, s * a.angular};
}

/// The same motion in the child's coordinates (Pluecker transform of motion vectors; Featherstone
/// 2008, table 2.1).
inline Twist to_child(const Pose& parent_from_child, const Twist& in_parent) noexcept {
  const auto& r = parent_from_child.rotation;
  return {
      r.transpose() * (in_parent.linear + in_parent.angular.cross(parent_from_child.translation)),
      r.transpose() * in_parent.angular};
}

/// The Lie bracket [a, b] = a x b: the rate of b, fixed in a frame that moves with a, seen from a
/// frame at rest (Featherstone 2008, equation 2.31).
inline Twist cross(const Twist& a, const Twist& b) noexcept {
  return {a.angular.cross(b.linear) + a.linear.cross(b.angular), a.angular.cross(b.angular)};
}

/// (t - sin t) / t^3, by its series below 1 where the quotient would cancel.
inline double versine_third(double t) noexcept {
  if (t > 1.0) {
    return (t - std::sin(t)) / (t * t * t);
  }
  // 1/3! - t^2/5! + t^4/7! - ... ; the first term left out is below 1e-19.
  double sum = 0.0;
  for (int k = 8; k >= 0; --k) {
    sum = (1.0 - t * t * sum) / static_cast<double>((2 * k + 2) * (2 * k + 3));
  }
  return sum;
}

/// The motion reached by following the constant local twist for one second. Real-time.
/// Source: Murray, Li, Sastry 1994, proposition 2.9.
inline Pose exp(const Twist& twist) noexcept {
  const double angle = twist.angular.norm();
  const double half_sinc = sinc(0.5 * angle);
  const Eigen::Vector3d once = twist.angular.cross(twist.linear);
  const Eigen::Vector3d twice = twist.angular.cross(once);
  return {exp(twist.angular),
          twist.linear + 0.5 * half_sinc * half_sinc * once + versine_third(angle) * twice};
}

}  // namespace geodesic::control
