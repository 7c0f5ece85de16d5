// The metric by composite rigid bodies as the textbook writes it, on the mechanism's plain bodies:
// what the fast recursion of control/mechanism/metric.cpp is compared with.
#pragma once

#include <vector>

#include "control/mechanism/joint_motion.hpp"

namespace geodesic::control::testing {

/// M(q) without rotor inertia (Featherstone 2008, table 6.2).
inline Eigen::MatrixXd plain_metric(const Mechanism& mechanism, const Eigen::VectorXd& q) {
  const auto& bodies = mechanism.bodies();
  std::vector<Pose> pose(bodies.size());
  std::vector<RigidInertia> carried(bodies.size());
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    pose[i] = parent_from_body(bodies[i], q);
    carried[i] = bodies[i].inertia;
  }
  Eigen::MatrixXd m = Eigen::MatrixXd::Zero(mechanism.dof(), mechanism.dof());
  for (std::size_t i = bodies.size(); i-- > 0;) {
    const Body& body = bodies[i];
    for (int k = 0; k < freedoms(body.motion); ++k) {
      const int column = body.dof + k;
      Wrench momentum = carried[i] * axis(body, k);
      for (int j = 0; j < freedoms(body.motion); ++j) {
        m(body.dof + j, column) += along_axis(body, momentum, j);
      }
      for (std::size_t at = i; bodies[at].parent != kWorld;) {
        momentum = to_parent(pose[at], momentum);
        at = static_cast<std::size_t>(bodies[at].parent);
        const Body& above = bodies[at];
        for (int j = 0; j < freedoms(above.motion); ++j) {
          // Where two joints share a degree of freedom (mimic), both terms fall on the diagonal.
          m(above.dof + j, column) += along_axis(above, momentum, j);
          m(column, above.dof + j) += along_axis(above, momentum, j);
        }
      }
    }
    if (body.parent != kWorld) {
      RigidInertia full = carried[i];
      full.rotational.triangularView<Eigen::StrictlyLower>() = full.rotational.transpose();
      carried[static_cast<std::size_t>(body.parent)] += to_parent(pose[i], full);
    }
  }
  return m;
}

}  // namespace geodesic::control::testing
