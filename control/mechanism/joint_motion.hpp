// How one body moves in its parent: pose, rate, and the projection of wrenches on the joint axis.
// The inner steps of every algorithm; loops over bodies are in the algorithms' own files.
#pragma once

#include <Eigen/Geometry>

#include "control/geometry/sine_cosine.hpp"
#include "control/mechanism/mechanism.hpp"
#include "control/mechanism/workspace.hpp"

namespace geodesic::control {

/// The rotation of the unit quaternion x y z w that begins at q[first]. Real-time. Normalised here.
inline Eigen::Matrix3d rotation_at(const VectorIn& q, int first) noexcept {
  const Eigen::Quaterniond orientation(q[first + 3], q[first], q[first + 1], q[first + 2]);
  return orientation.normalized().toRotationMatrix();
}

/// Pose of the body in its parent. Real-time.
inline Pose parent_from_body(const Body& body, const VectorIn& q) noexcept {
  const Pose& placed = body.parent_from_joint;
  if (body.motion == Motion::kFree) {
    return placed * Pose{rotation_at(q, body.coordinate + 3), q.segment<3>(body.coordinate)};
  }
  if (body.motion == Motion::kSpherical) {
    return {placed.rotation * rotation_at(q, body.coordinate), placed.translation};
  }
  const double position = body.ratio * q[body.coordinate] + body.offset;
  const Eigen::Matrix3d& fixed = placed.rotation;
  if (body.motion == Motion::kTranslation) {
    return {fixed, placed.translation + position * fixed.col(2)};
  }
  const auto [s, c] = sine_cosine(position);
  Pose pose;
  pose.rotation.col(0) = c * fixed.col(0) + s * fixed.col(1);
  pose.rotation.col(1) = c * fixed.col(1) - s * fixed.col(0);
  pose.rotation.col(2) = fixed.col(2);
  pose.translation = placed.translation;
  return pose;
}

/// Column k of the body: its twist in its parent per unit of v[body.dof + k], in its own
/// coordinates; k < freedoms(body.motion).
inline Twist axis(const Body& body, int k = 0) noexcept {
  Twist unit;
  switch (body.motion) {
    case Motion::kRotation:
      unit.angular.z() = body.ratio;
      break;
    case Motion::kTranslation:
      unit.linear.z() = body.ratio;
      break;
    case Motion::kSpherical:
      unit.angular[k] = 1.0;
      break;
    case Motion::kFree:
      (k < 3 ? unit.linear : unit.angular)[k % 3] = 1.0;
      break;
  }
  return unit;
}

/// dot(wrench, axis(body, k)).
inline double along_axis(const Body& body, const Wrench& wrench, int k = 0) noexcept {
  switch (body.motion) {
    case Motion::kRotation:
      return body.ratio * wrench.moment.z();
    case Motion::kTranslation:
      return body.ratio * wrench.force.z();
    case Motion::kSpherical:
      return wrench.moment[k];
    case Motion::kFree:
      break;
  }
  return k < 3 ? wrench.force[k] : wrench.moment[k - 3];
}

/// cross(velocity, axis(body, k)): the rate of the column.
inline Twist axis_rate(const Body& body, const Twist& velocity, int k = 0) noexcept {
  if (freedoms(body.motion) > 1) {
    return cross(velocity, axis(body, k));
  }
  const auto cross_z = [&](const Eigen::Vector3d& x) {
    return Eigen::Vector3d(body.ratio * x.y(), -body.ratio * x.x(), 0.0);
  };
  if (body.motion == Motion::kRotation) {
    return {cross_z(velocity.linear), cross_z(velocity.angular)};
  }
  return {cross_z(velocity.angular), Eigen::Vector3d::Zero()};
}

/// What the joint's rates (v, or dv/dt) add to the twist (or acceleration) its parent hands on: the
/// sum of its columns, each times its number in `rates` [nv].
inline Twist joint_twist(const Body& body, const VectorIn& rates) noexcept {
  switch (body.motion) {
    case Motion::kSpherical:
      return {Eigen::Vector3d::Zero(), rates.segment<3>(body.dof)};
    case Motion::kFree:
      return {rates.segment<3>(body.dof), rates.segment<3>(body.dof + 3)};
    default:
      return rates[body.dof] * axis(body);
  }
}

/// Twist of a body from its parent's (zero for the world) and its joint's rate.
inline Twist body_velocity(const Body& body, const Pose& parent_from_body, const Twist& parent,
                           const VectorIn& v) noexcept {
  return to_child(parent_from_body, parent) + joint_twist(body, v);
}

}  // namespace geodesic::control
