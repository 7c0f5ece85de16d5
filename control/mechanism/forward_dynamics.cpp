// Implements forward_dynamics.hpp.
#include "control/mechanism/forward_dynamics.hpp"

#include <cassert>

#include "control/mechanism/metric.hpp"
#include "control/mechanism/newton_euler.hpp"

namespace geodesic::control {

const Eigen::VectorXd* forward_dynamics(const Mechanism& mechanism, Workspace& workspace,
                                        const VectorIn& q, const VectorIn& v,
                                        const VectorIn& tau) noexcept {
  assert(tau.size() == mechanism.dof());
  if (!workspace.cholesky.factor(metric(mechanism, workspace, q))) {
    return nullptr;
  }
  workspace.forward_dynamics = tau - bias(mechanism, workspace, q, v);
  workspace.cholesky.solve(workspace.forward_dynamics);
  return &workspace.forward_dynamics;
}

}  // namespace geodesic::control
