// Implements jacobian_rate.hpp.
#include "control/mechanism/jacobian_rate.hpp"

#include <Eigen/Geometry>
#include <cassert>

#include "control/mechanism/joint_motion.hpp"

namespace geodesic::control {

const Jacobian& jacobian_rate(const Mechanism& mechanism, Workspace& workspace, const VectorIn& q,
                              const VectorIn& v, int link) noexcept {
  assert(link >= 0 && static_cast<std::size_t>(link) < mechanism.links().size());
  const LinkFrame& frame = mechanism.links()[static_cast<std::size_t>(link)];
  Jacobian& result = workspace.jacobian_rate;
  result.setZero();
  if (frame.body == kWorld) {
    return result;
  }
  update_poses(mechanism, workspace, q);
  update_velocities(mechanism, workspace, q, v);
  const auto carrier = static_cast<std::size_t>(frame.body);
  const Eigen::Vector3d& in_body = frame.body_from_link.translation;
  const Pose& carrier_pose = workspace.world_from_body[carrier];
  const Twist& carrier_velocity = workspace.body[carrier].velocity;
  const Eigen::Vector3d origin = carrier_pose.rotation * in_body + carrier_pose.translation;
  const Eigen::Vector3d origin_velocity =
      carrier_pose.rotation * (carrier_velocity.linear + carrier_velocity.angular.cross(in_body));
  for (int index = frame.body; index != kWorld;
       index = mechanism.bodies()[static_cast<std::size_t>(index)].parent) {
    const Body& body = mechanism.bodies()[static_cast<std::size_t>(index)];
    const Pose& pose = workspace.world_from_body[static_cast<std::size_t>(index)];
    const Twist& velocity = workspace.body[static_cast<std::size_t>(index)].velocity;
    const Eigen::Vector3d lever = origin - pose.translation;
    const Eigen::Vector3d lever_rate = origin_velocity - pose.rotation * velocity.linear;
    for (int k = 0; k < freedoms(body.motion); ++k) {
      const Twist s = axis(body, k);
      const Eigen::Vector3d z = pose.rotation * s.angular;
      const Eigen::Vector3d z_rate = pose.rotation * velocity.angular.cross(s.angular);
      const Eigen::Vector3d slide_rate = pose.rotation * velocity.angular.cross(s.linear);
      result.col(body.dof + k).head<3>() += slide_rate + z_rate.cross(lever) + z.cross(lever_rate);
      result.col(body.dof + k).tail<3>() += z_rate;
    }
  }
  return result;
}

}  // namespace geodesic::control
