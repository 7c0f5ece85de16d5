// How one body moves in its parent: pose, rate, and the projection of wrenches on the joint axis.
// The inner steps of every algorithm; loops over bodies are in the algorithms' own files.
#pragma once

#include <Eigen/Geometry>

#include "control/geometry/sine_cosine.hpp"
#include "control/mechanism/mechanism.hpp"
#include "control/mechanism/workspace.hpp"

namespace geodesic::control {

/// Pose of the body in its parent. Real-time. A floating base's quaternion is normalised here.
inline Pose parent_from_body(const Mechanism& mechanism, const Body& body,
                             const VectorIn& q) noexcept {
  if (body.motion == Motion::kFree) {
    const Eigen::Quaterniond orientation(q[6], q[3], q[4], q[5]);
    return {orientation.normalized().toRotationMatrix(), q.head<3>()};
  }
  const int index = mechanism.floating() ? body.dof + 1 : body.dof;
  const double position = body.ratio * q[index] + body.offset;
  const Eigen::Matrix3d& fixed = body.parent_from_joint.rotation;
  if (body.motion == Motion::kTranslation) {
    return {fixed, body.parent_from_joint.translation + position * fixed.col(2)};
  }
  const auto [s, c] = sine_cosine(position);
  Pose pose;
  pose.rotation.col(0) = c * fixed.col(0) + s * fixed.col(1);
  pose.rotation.col(1) = c * fixed.col(1) - s * fixed.col(0);
  pose.rotation.col(2) = fixed.col(2);
  pose.translation = body.parent_from_joint.translation;
  return pose;
}

/// Column of the body's degree of freedom: its twist in its parent per unit of v[body.dof], in its
/// own coordinates. Not for a free body, whose six columns are the unit twists.
inline Twist axis(const Body& body) noexcept {
  const Eigen::Vector3d z = body.ratio * Eigen::Vector3d::UnitZ();
  return body.motion == Motion::kRotation ? Twist{Eigen::Vector3d::Zero(), z}
                                          : Twist{z, Eigen::Vector3d::Zero()};
}

/// dot(wrench, axis(body)).
inline double along_axis(const Body& body, const Wrench& wrench) noexcept {
  return body.ratio * (body.motion == Motion::kRotation ? wrench.moment.z() : wrench.force.z());
}

/// Adds what the joint contributes to the twist (or acceleration) its parent hands on.
inline void add_along_axis(const Body& body, double rate, Twist& twist) noexcept {
  (body.motion == Motion::kRotation ? twist.angular : twist.linear).z() += body.ratio * rate;
}

/// cross(velocity, axis(body)): the rate of the axis.
inline Twist axis_rate(const Body& body, const Twist& velocity) noexcept {
  const auto cross_z = [&](const Eigen::Vector3d& x) {
    return Eigen::Vector3d(body.ratio * x.y(), -body.ratio * x.x(), 0.0);
  };
  if (body.motion == Motion::kRotation) {
    return {cross_z(velocity.linear), cross_z(velocity.angular)};
  }
  return {cross_z(velocity.angular), Eigen::Vector3d::Zero()};
}

/// Twist of a body from its parent's (zero for the world) and its joint's rate.
inline Twist body_velocity(const Body& body, const Pose& parent_from_body, const Twist& parent,
                           const VectorIn& v) noexcept {
  if (body.motion == Motion::kFree) {
    return {v.head<3>(), v.segment<3>(3)};
  }
  Twist twist = to_child(parent_from_body, parent);
  add_along_axis(body, v[body.dof], twist);
  return twist;
}

}  // namespace geodesic::control
