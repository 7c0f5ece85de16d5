// Implements metric.hpp.
#include "control/mechanism/metric.hpp"

#include <cassert>

#include "control/mechanism/cholesky.hpp"
#include "control/mechanism/joint_motion.hpp"

namespace geodesic::control {
namespace {

/// Fills the columns of joint `i`: the momentum its unit velocity gives to all it carries, felt
/// along every joint on the way to the world.
void add_joint(const Mechanism& mechanism, const Workspace& workspace, std::size_t i,
               Eigen::MatrixXd& m) noexcept {
  const auto& bodies = mechanism.bodies();
  const int column = bodies[i].dof;
  Wrench momentum = workspace.composite[i].inertia * axis(bodies[i]);
  m(column, column) += along_axis(bodies[i], momentum);
  std::size_t at = i;
  while (bodies[at].parent != kWorld) {
    momentum = to_parent(workspace.body[at].parent_from_body, momentum);
    at = static_cast<std::size_t>(bodies[at].parent);
    const Body& above = bodies[at];
    if (above.motion == Motion::kFree) {
      m.col(column).head<3>() += momentum.force;
      m.col(column).segment<3>(3) += momentum.moment;
      m.row(column).head<3>() += momentum.force.transpose();
      m.row(column).segment<3>(3) += momentum.moment.transpose();
    } else {
      // Where two joints share a degree of freedom (mimic), both terms fall on the diagonal.
      const double entry = along_axis(above, momentum);
      m(above.dof, column) += entry;
      m(column, above.dof) += entry;
    }
  }
}

}  // namespace

const Eigen::MatrixXd& metric(const Mechanism& mechanism, Workspace& workspace,
                              const VectorIn& q) noexcept {
  assert(q.size() == mechanism.nq());
  const auto& bodies = mechanism.bodies();
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    workspace.body[i].parent_from_body = parent_from_body(mechanism, bodies[i], q);
    workspace.composite[i].inertia = bodies[i].inertia;
  }
  Eigen::MatrixXd& m = workspace.metric;
  m.setZero();
  m.diagonal() = mechanism.rotor_inertia();
  for (std::size_t i = bodies.size(); i-- > 0;) {
    const RigidInertia& carried = workspace.composite[i].inertia;
    if (bodies[i].motion == Motion::kFree) {
      m.block<3, 3>(0, 0).diagonal().setConstant(carried.mass);
      m.block<3, 3>(3, 0) = hat(carried.first_moment);
      m.block<3, 3>(0, 3) = -m.block<3, 3>(3, 0);
      m.block<3, 3>(3, 3) = carried.rotational;
      m.block<3, 3>(3, 3).triangularView<Eigen::StrictlyLower>() =
          carried.rotational.transpose().triangularView<Eigen::StrictlyLower>();
      continue;
    }
    add_joint(mechanism, workspace, i, m);
    if (bodies[i].parent != kWorld) {
      workspace.composite[static_cast<std::size_t>(bodies[i].parent)].inertia +=
          to_parent(workspace.body[i].parent_from_body, carried);
    }
  }
  return m;
}

const Eigen::MatrixXd* metric_inverse(const Mechanism& mechanism, Workspace& workspace,
                                      const VectorIn& q) noexcept {
  workspace.metric_factor = metric(mechanism, workspace, q);
  if (!cholesky_factor(workspace.metric_factor)) {
    return nullptr;
  }
  Eigen::MatrixXd& inverse = workspace.metric_inverse;
  inverse.setIdentity();
  for (Eigen::Index j = 0; j < inverse.cols(); ++j) {
    cholesky_solve(workspace.metric_factor, inverse.col(j));
  }
  for (Eigen::Index j = 0; j < inverse.cols(); ++j) {
    for (Eigen::Index i = 0; i < j; ++i) {
      inverse(i, j) = inverse(j, i) = 0.5 * (inverse(i, j) + inverse(j, i));
    }
  }
  return &inverse;
}

}  // namespace geodesic::control
