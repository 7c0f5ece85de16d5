// Wrenches and the inertia of a rigid body as spatial (6-dimensional) quantities of fixed size, and
// how a pose carries them from child to parent. Twists and poses are in se3.hpp.
#pragma once

#include <Eigen/Core>

#include "control/geometry/se3.hpp"

namespace geodesic::control {

/// Force on (or momentum of) a rigid body in the coordinates of a frame, the moment about its
/// origin. Where six numbers stand in a vector, the force comes first.
struct Wrench {
  Eigen::Vector3d force = Eigen::Vector3d::Zero();   ///< [N], or [kg·m/s]
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();  ///< [N·m], or [kg·m²/s]
};

inline Wrench operator+(const Wrench& a, const Wrench& b) noexcept {
  return {a.force + b.force, a.moment + b.moment};
}

inline Wrench& operator+=(Wrench& a, const Wrench& b) noexcept {
  a.force += b.force;
  a.moment += b.moment;
  return a;
}

inline Wrench operator-(const Wrench& a, const Wrench& b) noexcept {
  return {a.force - b.force, a.moment - b.moment};
}

inline Wrench operator*(double s, const Wrench& a) noexcept {
  return {s * a.force, s * a.moment};
}

/// Power [W].
inline double dot(const Wrench& f, const Twist& v) noexcept {
  return f.force.dot(v.linear) + f.moment.dot(v.angular);
}

/// v x* f: the rate of a wrench fixed in a frame that moves with v (Featherstone 2008, equation
/// 2.32). Dual to the bracket of twists: dot(cross(v, f), u) = -dot(f, cross(v, u)).
inline Wrench cross(const Twist& v, const Wrench& f) noexcept {
  return {v.angular.cross(f.force), v.angular.cross(f.moment) + v.linear.cross(f.force)};
}

/// The same wrench in the parent's coordinates.
inline Wrench to_parent(const Pose& parent_from_child, const Wrench& in_child) noexcept {
  const Eigen::Vector3d force = parent_from_child.rotation * in_child.force;
  return {force, parent_from_child.rotation * in_child.moment +
                     parent_from_child.translation.cross(force)};
}

/// The same wrench in the child's coordinates; inverse of to_parent().
inline Wrench to_child(const Pose& parent_from_child, const Wrench& in_parent) noexcept {
  const auto down = parent_from_child.rotation.transpose();
  return {down * in_parent.force,
          down * (in_parent.moment - parent_from_child.translation.cross(in_parent.force))};
}

/// The ten inertial parameters of a rigid body in the coordinates of a frame. They are moments of
/// the mass distribution, so bodies joined rigidly add.
struct RigidInertia {
  double mass = 0.0;                                       ///< [kg]
  Eigen::Vector3d first_moment = Eigen::Vector3d::Zero();  ///< mass * centre of mass [kg·m]
  Eigen::Matrix3d rotational = Eigen::Matrix3d::Zero();    ///< about the frame's origin [kg·m²]
};

inline RigidInertia& operator+=(RigidInertia& a, const RigidInertia& b) noexcept {
  a.mass += b.mass;
  a.first_moment += b.first_moment;
  a.rotational += b.rotational;
  return a;
}

/// Momentum of a body that moves with the twist.
inline Wrench operator*(const RigidInertia& body, const Twist& v) noexcept {
  return {body.mass * v.linear + v.angular.cross(body.first_moment),
          body.rotational * v.angular + body.first_moment.cross(v.linear)};
}

/// -hat(a) hat(b) symmetrised: the change of the rotational inertia that a shift brings.
inline Eigen::Matrix3d shifted(const Eigen::Vector3d& a, const Eigen::Vector3d& b) noexcept {
  return 2.0 * a.dot(b) * Eigen::Matrix3d::Identity() - a * b.transpose() - b * a.transpose();
}

/// The same body in the parent's coordinates (rotation, then the parallel-axis theorem).
inline RigidInertia to_parent(const Pose& parent_from_child, const RigidInertia& body) noexcept {
  const auto& r = parent_from_child.rotation;
  const auto& p = parent_from_child.translation;
  const Eigen::Vector3d moment = r * body.first_moment;
  // Sum of m |x|^2 - x x' over x = r y + p, with the pure rotation term first.
  return {body.mass, moment + body.mass * p,
          r * body.rotational * r.transpose() + shifted(p, moment + (0.5 * body.mass) * p)};
}

}  // namespace geodesic::control
