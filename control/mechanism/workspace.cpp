// Sizes the buffers of a Workspace.
#include "control/mechanism/workspace.hpp"

namespace geodesic::control {

Workspace::Workspace(const Mechanism& mechanism)
    : load(mechanism.bodies().size()),
      course(mechanism.bodies().size()),
      carried(mechanism.bodies().size()),
      axes(mechanism.bodies().size()),
      sine(mechanism.bodies().size() + kMostLanes),
      cosine(mechanism.bodies().size() + kMostLanes),
      body(mechanism.bodies().size()),
      composite(mechanism.bodies().size()),
      world_from_body(mechanism.bodies().size()),
      body_momentum(mechanism.bodies().size()),
      cholesky(mechanism),
      field(mechanism.bodies().size()),
      articulated(mechanism.bodies().size()) {
  const Eigen::Index n = mechanism.dof();
  for (auto* vector : {&gravity, &bias, &inverse_dynamics, &forward_dynamics, &unit_velocity,
                       &joint_momentum, &momentum_drift, &flat, &sharp, &connection,
                       &covariant_derivative, &curvature, &generator, &external_torque}) {
    vector->setZero(n);
  }
  for (auto* matrix :
       {&metric, &metric_inverse, &metric_rate, &coriolis, &lie_derivative, &field_bracket}) {
    matrix->setZero(n, n);
  }
  configuration.setZero(mechanism.nq());
  for (auto* matrix : {&jacobian, &jacobian_rate, &momentum_matrix}) {
    matrix->setZero(6, n);
  }
}

}  // namespace geodesic::control
