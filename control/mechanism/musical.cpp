// Implements musical.hpp.
#include "control/mechanism/musical.hpp"

#include <cassert>

#include "control/mechanism/joint_motion.hpp"
#include "control/mechanism/kinematics.hpp"
#include "control/mechanism/metric.hpp"

namespace geodesic::control {

const Eigen::VectorXd& flat(const Mechanism& mechanism, Workspace& workspace, const VectorIn& q,
                            const VectorIn& v) noexcept {
  const auto& bodies = mechanism.bodies();
  update_velocities(mechanism, workspace, q, v);
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    workspace.body_momentum[i] = bodies[i].inertia * workspace.body[i].velocity;
  }
  Eigen::VectorXd& p = workspace.flat;
  p = mechanism.rotor_inertia().cwiseProduct(v);
  for (std::size_t i = bodies.size(); i-- > 0;) {
    const Body& body = bodies[i];
    const Wrench& carried = workspace.body_momentum[i];
    for (int k = 0; k < freedoms(body.motion); ++k) {
      p[body.dof + k] += along_axis(body, carried, k);
    }
    if (body.parent != kWorld) {
      workspace.body_momentum[static_cast<std::size_t>(body.parent)] +=
          to_parent(workspace.body[i].parent_from_body, carried);
    }
  }
  return p;
}

const Eigen::VectorXd* sharp(const Mechanism& mechanism, Workspace& workspace, const VectorIn& q,
                             const VectorIn& p) noexcept {
  assert(p.size() == mechanism.dof());
  if (!workspace.cholesky.factor(metric(mechanism, workspace, q))) {
    return nullptr;
  }
  workspace.sharp = p;
  workspace.cholesky.solve(workspace.sharp);
  return &workspace.sharp;
}

const Eigen::MatrixXd* metric_inverse(const Mechanism& mechanism, Workspace& workspace,
                                      const VectorIn& q) noexcept {
  if (!workspace.cholesky.factor(metric(mechanism, workspace, q))) {
    return nullptr;
  }
  workspace.cholesky.inverse(workspace.metric_inverse);
  return &workspace.metric_inverse;
}

}  // namespace geodesic::control
