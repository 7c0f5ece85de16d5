// The gravity covector as the textbook writes it, on the mechanism's plain bodies: what the fast
// recursion of control/mechanism/gravity.cpp is compared with.
#pragma once

#include <vector>

#include "control/mechanism/joint_motion.hpp"

namespace geodesic::control::testing {

/// g(q): weights in the world's axes, moved to each joint on the way to the world (d'Alembert's
/// principle with nothing in motion).
inline Eigen::VectorXd plain_gravity(const Mechanism& mechanism, const Eigen::VectorXd& q) {
  const auto& bodies = mechanism.bodies();
  std::vector<Pose> world_from_body(bodies.size());
  Eigen::VectorXd result = Eigen::VectorXd::Zero(mechanism.dof());
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const Pose pose = parent_from_body(bodies[i], q);
    world_from_body[i] = bodies[i].parent == kWorld
                             ? pose
                             : world_from_body[static_cast<std::size_t>(bodies[i].parent)] * pose;
    const Eigen::Vector3d weight = -bodies[i].inertia.mass * mechanism.gravity();
    // First moment and mass of this body alone, felt by every joint above it.
    for (int at = static_cast<int>(i); at != kWorld;
         at = bodies[static_cast<std::size_t>(at)].parent) {
      const Body& above = bodies[static_cast<std::size_t>(at)];
      const Pose& frame = world_from_body[static_cast<std::size_t>(at)];
      const Eigen::Vector3d lever =
          bodies[i].inertia.mass * (world_from_body[i].translation - frame.translation) +
          world_from_body[i].rotation * bodies[i].inertia.first_moment;
      const Wrench held{frame.rotation.transpose() * weight,
                        -(frame.rotation.transpose() * lever.cross(mechanism.gravity()))};
      for (int k = 0; k < freedoms(above.motion); ++k) {
        result[above.dof + k] += along_axis(above, held, k);
      }
    }
  }
  return result;
}

}  // namespace geodesic::control::testing
