// Sizes the buffers of a Workspace.
#include "control/mechanism/workspace.hpp"

namespace geodesic::control {

Workspace::Workspace(const Mechanism& mechanism)
    : compact(mechanism.bodies().size()),
      angle(mechanism.bodies().size() + 1),
      sine(mechanism.bodies().size() + 1),
      cosine(mechanism.bodies().size() + 1),
      body(mechanism.bodies().size()),
      composite(mechanism.bodies().size()),
      world_from_body(mechanism.bodies().size()),
      body_momentum(mechanism.bodies().size()) {
  const Eigen::Index n = mechanism.dof();
  for (auto* vector : {&gravity, &bias, &inverse_dynamics, &forward_dynamics, &unit_velocity,
                       &joint_momentum, &momentum_drift}) {
    vector->setZero(n);
  }
  for (auto* matrix : {&metric, &metric_factor, &metric_inverse, &metric_rate, &coriolis}) {
    matrix->setZero(n, n);
  }
  jacobian.setZero(6, n);
}

}  // namespace geodesic::control
