// Implements connection.hpp.
#include "control/mechanism/connection.hpp"

#include <cassert>

#include "control/mechanism/gravity.hpp"
#include "control/mechanism/kinematics.hpp"
#include "control/mechanism/metric.hpp"
#include "control/mechanism/musical.hpp"
#include "control/mechanism/particle_field.hpp"

namespace geodesic::control {

void frame_bracket(const Mechanism& mechanism, const VectorIn& x, const VectorIn& y,
                   Eigen::Ref<Eigen::VectorXd> result) noexcept {
  assert(x.size() == mechanism.dof() && y.size() == x.size() && result.size() == x.size());
  result.setZero();
  for (const Body& body : mechanism.bodies()) {
    const int n = freedoms(body.motion);
    if (n == 1) {
      continue;
    }
    const Twist bracket = cross(joint_twist(body, x), joint_twist(body, y));
    if (n == 6) {
      result.segment<3>(body.dof) = bracket.linear;
    }
    result.segment<3>(body.dof + n - 3) = bracket.angular;
  }
}

const Eigen::VectorXd& connection_covector(const Mechanism& mechanism, Workspace& workspace,
                                           const VectorIn& q, const VectorIn& x,
                                           const VectorIn& y) noexcept {
  assert(x.size() == mechanism.dof() && y.size() == x.size());
  update_poses(mechanism, workspace, q);
  second_derivatives(mechanism, workspace, x, y);
  tangential_part(mechanism, workspace, workspace.connection);
  return workspace.connection;
}

const Eigen::VectorXd* covariant_derivative(const Mechanism& mechanism, Workspace& workspace,
                                            const VectorIn& q, const VectorIn& v, const VectorIn& y,
                                            const VectorIn& y_rate) noexcept {
  if (!workspace.cholesky.factor(metric(mechanism, workspace, q))) {
    return nullptr;
  }
  Eigen::VectorXd& result = workspace.covariant_derivative;
  result = connection_covector(mechanism, workspace, q, v, y);
  workspace.cholesky.solve(result);
  result += y_rate;
  return &result;
}

const Eigen::VectorXd* geodesic_acceleration(const Mechanism& mechanism, Workspace& workspace,
                                             const VectorIn& q, const VectorIn& v) noexcept {
  if (!workspace.cholesky.factor(metric(mechanism, workspace, q))) {
    return nullptr;
  }
  Eigen::VectorXd& result = workspace.covariant_derivative;
  result = -connection_covector(mechanism, workspace, q, v, v);
  workspace.cholesky.solve(result);
  return &result;
}

const Eigen::VectorXd* potential_gradient(const Mechanism& mechanism, Workspace& workspace,
                                          const VectorIn& q) noexcept {
  return sharp(mechanism, workspace, q, gravity(mechanism, workspace, q));
}

}  // namespace geodesic::control
