// Implements coriolis.hpp.
//
// Echeandia and Wensing's body-level matrix B, for which C = sum of J' (I dJ/dt + B J), becomes
// compact when a body is seen as particles: particle m at r, moving with u = v + w x r, has
// velocity A x (body twist) with A = [1, -hat(r)] and dA/dt = [0, -hat(u)], so that
//   B = sum m A' dA/dt = [ 0  -hat(p) ]     p = sum m u      linear momentum,
//                        [ 0  tr(U) - U ]   U = sum m u r'   called flow here.
// Both sums add over bodies: twelve numbers travel inwards instead of a 6 x 6 matrix.
#include "control/mechanism/coriolis.hpp"

#include <Eigen/Geometry>
#include <cassert>

#include "control/mechanism/joint_motion.hpp"
#include "control/mechanism/kinematics.hpp"

namespace geodesic::control {
namespace {

using Composite = Workspace::Composite;

Composite moving(const RigidInertia& body, const Twist& v) noexcept {
  const Eigen::Matrix3d second_moment =  // sum of m r r'
      0.5 * body.rotational.trace() * Eigen::Matrix3d::Identity() - body.rotational;
  return {body, body.mass * v.linear + v.angular.cross(body.first_moment),
          v.linear * body.first_moment.transpose() + hat(v.angular) * second_moment};
}

/// B x.
Wrench times(const Composite& b, const Twist& x) noexcept {
  return {x.angular.cross(b.momentum), b.flow.trace() * x.angular - b.flow * x.angular};
}

/// B' x.
Wrench transposed_times(const Composite& b, const Twist& x) noexcept {
  return {Eigen::Vector3d::Zero(),
          b.momentum.cross(x.linear) + b.flow.trace() * x.angular - b.flow.transpose() * x.angular};
}

void add_to_parent(const Pose& parent_from_child, const Composite& child,
                   Composite& parent) noexcept {
  const Eigen::Matrix3d& r = parent_from_child.rotation;
  const Eigen::Vector3d momentum = r * child.momentum;
  parent.inertia += to_parent(parent_from_child, child.inertia);
  parent.momentum += momentum;
  parent.flow +=
      r * child.flow * r.transpose() + momentum * parent_from_child.translation.transpose();
}

/// Rows and columns of joint `i` against itself and every joint on the way to the world.
void add_joint(const Mechanism& mechanism, const Workspace& workspace, std::size_t i,
               Eigen::MatrixXd& c) noexcept {
  const auto& bodies = mechanism.bodies();
  const Composite& carried = workspace.composite[i];
  for (int k = 0; k < freedoms(bodies[i].motion); ++k) {
    const Twist s = axis(bodies[i], k);
    const int d = bodies[i].dof + k;
    // The force of this column's rate on the others, its momentum, and the transposed share of B.
    Wrench f1 =
        carried.inertia * axis_rate(bodies[i], workspace.body[i].velocity, k) + times(carried, s);
    Wrench f2 = carried.inertia * s;
    Wrench f3 = transposed_times(carried, s);
    for (int j = 0; j < freedoms(bodies[i].motion); ++j) {
      c(bodies[i].dof + j, d) += along_axis(bodies[i], f1, j);
    }
    std::size_t at = i;
    while (bodies[at].parent != kWorld) {
      const Pose& pose = workspace.body[at].parent_from_body;
      f1 = to_parent(pose, f1);
      f2 = to_parent(pose, f2);
      f3 = to_parent(pose, f3);
      at = static_cast<std::size_t>(bodies[at].parent);
      const Body& above = bodies[at];
      const Twist& velocity = workspace.body[at].velocity;
      for (int j = 0; j < freedoms(above.motion); ++j) {
        c(above.dof + j, d) += along_axis(above, f1, j);
        c(d, above.dof + j) += along_axis(above, f3, j) + dot(f2, axis_rate(above, velocity, j));
      }
    }
  }
}

}  // namespace

const Eigen::MatrixXd& coriolis_matrix(const Mechanism& mechanism, Workspace& workspace,
                                       const VectorIn& q, const VectorIn& v) noexcept {
  const auto& bodies = mechanism.bodies();
  update_velocities(mechanism, workspace, q, v);
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    workspace.composite[i] = moving(bodies[i].inertia, workspace.body[i].velocity);
  }
  Eigen::MatrixXd& c = workspace.coriolis;
  c.setZero();
  for (std::size_t i = bodies.size(); i-- > 0;) {
    add_joint(mechanism, workspace, i, c);
    if (bodies[i].parent != kWorld) {
      add_to_parent(workspace.body[i].parent_from_body, workspace.composite[i],
                    workspace.composite[static_cast<std::size_t>(bodies[i].parent)]);
    }
  }
  return c;
}

const Eigen::MatrixXd& metric_rate(const Mechanism& mechanism, Workspace& workspace,
                                   const VectorIn& q, const VectorIn& v) noexcept {
  const Eigen::MatrixXd& c = coriolis_matrix(mechanism, workspace, q, v);
  workspace.metric_rate.noalias() = c + c.transpose();
  return workspace.metric_rate;
}

}  // namespace geodesic::control
