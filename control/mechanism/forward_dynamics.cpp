// Implements forward_dynamics.hpp.
#include "control/mechanism/forward_dynamics.hpp"

#include <cassert>

#include "control/mechanism/cholesky.hpp"
#include "control/mechanism/metric.hpp"
#include "control/mechanism/newton_euler.hpp"

namespace geodesic::control {

const Eigen::VectorXd* forward_dynamics(const Mechanism& mechanism, Workspace& workspace,
                                        const VectorIn& q, const VectorIn& v,
                                        const VectorIn& tau) noexcept {
  assert(tau.size() == mechanism.dof());
  workspace.metric_factor = metric(mechanism, workspace, q);
  if (!cholesky_factor(workspace.metric_factor)) {
    return nullptr;
  }
  workspace.forward_dynamics = tau - bias(mechanism, workspace, q, v);
  cholesky_solve(workspace.metric_factor, workspace.forward_dynamics);
  return &workspace.forward_dynamics;
}

}  // namespace geodesic::control
