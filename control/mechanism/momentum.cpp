// Implements momentum.hpp.
#include "control/mechanism/momentum.hpp"

#include <Eigen/Geometry>

#include "control/mechanism/kinematics.hpp"

namespace geodesic::control {
namespace {

Eigen::Vector3d first_moment_at_poses(const Mechanism& mechanism,
                                      const Workspace& workspace) noexcept {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < mechanism.bodies().size(); ++i) {
    const RigidInertia& inertia = mechanism.bodies()[i].inertia;
    const Pose& pose = workspace.world_from_body[i];
    sum += pose.rotation * inertia.first_moment + inertia.mass * pose.translation;
  }
  return sum;
}

}  // namespace

Eigen::Vector3d first_moment(const Mechanism& mechanism, Workspace& workspace,
                             const VectorIn& q) noexcept {
  update_poses(mechanism, workspace, q);
  return first_moment_at_poses(mechanism, workspace);
}

Eigen::Vector3d centre_of_mass(const Mechanism& mechanism, Workspace& workspace,
                               const VectorIn& q) noexcept {
  if (!(mechanism.moving_mass() > 0.0)) {
    return Eigen::Vector3d::Zero();
  }
  return first_moment(mechanism, workspace, q) / mechanism.moving_mass();
}

CentroidalMomentum centroidal_momentum(const Mechanism& mechanism, Workspace& workspace,
                                       const VectorIn& q, const VectorIn& v) noexcept {
  CentroidalMomentum result;
  result.centre_of_mass = centre_of_mass(mechanism, workspace, q);
  update_poses(mechanism, workspace, q);
  update_velocities(mechanism, workspace, q, v);
  for (std::size_t i = 0; i < mechanism.bodies().size(); ++i) {
    const Pose& world_from_body = workspace.world_from_body[i];
    const Pose centre_from_body{world_from_body.rotation,
                                world_from_body.translation - result.centre_of_mass};
    const Wrench momentum =
        to_parent(centre_from_body, mechanism.bodies()[i].inertia * workspace.body[i].velocity);
    result.linear += momentum.force;
    result.angular += momentum.moment;
  }
  if (mechanism.moving_mass() > 0.0) {
    result.velocity = result.linear / mechanism.moving_mass();
  }
  return result;
}

}  // namespace geodesic::control
