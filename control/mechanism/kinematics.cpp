// Implements kinematics.hpp.
#include "control/mechanism/kinematics.hpp"

#include <Eigen/Geometry>
#include <cassert>

#include "control/mechanism/joint_motion.hpp"

namespace geodesic::control {

void update_poses(const Mechanism& mechanism, Workspace& workspace, const VectorIn& q) noexcept {
  assert(q.size() == mechanism.nq());
  const auto& bodies = mechanism.bodies();
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const Body& body = bodies[i];
    Pose& pose = workspace.body[i].parent_from_body;
    pose = parent_from_body(body, q);
    workspace.world_from_body[i] =
        body.parent == kWorld
            ? pose
            : workspace.world_from_body[static_cast<std::size_t>(body.parent)] * pose;
  }
}

void update_velocities(const Mechanism& mechanism, Workspace& workspace, const VectorIn& q,
                       const VectorIn& v) noexcept {
  assert(q.size() == mechanism.nq() && v.size() == mechanism.dof());
  const auto& bodies = mechanism.bodies();
  const Twist at_rest;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const Body& body = bodies[i];
    auto& state = workspace.body[i];
    state.parent_from_body = parent_from_body(body, q);
    const Twist& parent = body.parent == kWorld
                              ? at_rest
                              : workspace.body[static_cast<std::size_t>(body.parent)].velocity;
    state.velocity = body_velocity(body, state.parent_from_body, parent, v);
  }
}

Pose link_pose(const Mechanism& mechanism, const VectorIn& q, int link) noexcept {
  assert(q.size() == mechanism.nq() && link >= 0);
  const LinkFrame& frame = mechanism.links()[static_cast<std::size_t>(link)];
  Pose pose = frame.body_from_link;
  int index = frame.body;
  while (index != kWorld) {
    const Body& body = mechanism.bodies()[static_cast<std::size_t>(index)];
    pose = parent_from_body(body, q) * pose;
    index = body.parent;
  }
  return pose;
}

const Jacobian& jacobian(const Mechanism& mechanism, Workspace& workspace, const VectorIn& q,
                         int link) noexcept {
  assert(link >= 0 && static_cast<std::size_t>(link) < mechanism.links().size());
  update_poses(mechanism, workspace, q);
  Jacobian& result = workspace.jacobian;
  result.setZero();
  const LinkFrame& frame = mechanism.links()[static_cast<std::size_t>(link)];
  if (frame.body == kWorld) {
    return result;
  }
  const Pose& carrier = workspace.world_from_body[static_cast<std::size_t>(frame.body)];
  const Eigen::Vector3d origin =
      carrier.rotation * frame.body_from_link.translation + carrier.translation;
  // Three columns of a rotation about any axis through a point that is `lever` from the origin.
  const auto turning = [&result](int column, const Eigen::Matrix3d& rotation,
                                 const Eigen::Vector3d& lever) {
    for (int k = 0; k < 3; ++k) {
      result.col(column + k).head<3>() = rotation.col(k).cross(lever);
      result.col(column + k).tail<3>() = rotation.col(k);
    }
  };
  int index = frame.body;
  while (index != kWorld) {
    const Body& body = mechanism.bodies()[static_cast<std::size_t>(index)];
    const Pose& world_from_body = workspace.world_from_body[static_cast<std::size_t>(index)];
    const Eigen::Matrix3d& rotation = world_from_body.rotation;
    const Eigen::Vector3d lever = origin - world_from_body.translation;
    if (body.motion == Motion::kFree) {
      result.block<3, 3>(0, body.dof) = rotation;
      turning(body.dof + 3, rotation, lever);
    } else if (body.motion == Motion::kSpherical) {
      turning(body.dof, rotation, lever);
    } else if (body.motion == Motion::kRotation) {
      result.col(body.dof).head<3>() += body.ratio * rotation.col(2).cross(lever);
      result.col(body.dof).tail<3>() += body.ratio * rotation.col(2);
    } else {
      result.col(body.dof).head<3>() += body.ratio * rotation.col(2);
    }
    index = body.parent;
  }
  return result;
}

}  // namespace geodesic::control
