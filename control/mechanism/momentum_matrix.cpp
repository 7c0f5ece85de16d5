// Implements momentum_matrix.hpp.
#include "control/mechanism/momentum_matrix.hpp"

#include "control/mechanism/joint_motion.hpp"
#include "control/mechanism/kinematics.hpp"

namespace geodesic::control {

Wrench spatial_momentum(const Mechanism& mechanism, Workspace& workspace, const VectorIn& q,
                        const VectorIn& v) noexcept {
  update_poses(mechanism, workspace, q);
  update_velocities(mechanism, workspace, q, v);
  Wrench sum;
  for (std::size_t i = 0; i < mechanism.bodies().size(); ++i) {
    sum += to_parent(workspace.world_from_body[i],
                     mechanism.bodies()[i].inertia * workspace.body[i].velocity);
  }
  return sum;
}

const Jacobian& centroidal_momentum_matrix(const Mechanism& mechanism, Workspace& workspace,
                                           const VectorIn& q) noexcept {
  const auto& bodies = mechanism.bodies();
  const Eigen::Vector3d centre = centre_of_mass(mechanism, workspace, q);
  update_poses(mechanism, workspace, q);
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    workspace.composite[i].inertia = bodies[i].inertia;
  }
  Jacobian& result = workspace.momentum_matrix;
  result.setZero();
  for (std::size_t i = bodies.size(); i-- > 0;) {
    const Body& body = bodies[i];
    const RigidInertia& carried = workspace.composite[i].inertia;
    const Pose& pose = workspace.world_from_body[i];
    const Pose centre_from_body{pose.rotation, pose.translation - centre};
    for (int k = 0; k < freedoms(body.motion); ++k) {
      const Wrench momentum = to_parent(centre_from_body, carried * axis(body, k));
      result.col(body.dof + k).head<3>() += momentum.force;
      result.col(body.dof + k).tail<3>() += momentum.moment;
    }
    if (body.parent != kWorld) {
      workspace.composite[static_cast<std::size_t>(body.parent)].inertia +=
          to_parent(workspace.body[i].parent_from_body, carried);
    }
  }
  return result;
}

}  // namespace geodesic::control
