// Fields over the particles of a mechanism, one affine map a body: what connection.cpp and
// curvature.cpp share. Steps over one body; the state is Workspace::FieldState.
#pragma once

#include <Eigen/Geometry>

#include "control/mechanism/joint_motion.hpp"

namespace geodesic::control {

/// Sum of m r r', the second moments behind the rotational inertia [kg·m²].
inline Eigen::Matrix3d second_moments(const RigidInertia& body) noexcept {
  return 0.5 * body.rotational.trace() * Eigen::Matrix3d::Identity() - body.rotational;
}

/// Axial vector of the skew matrix k - k': sum of m a x b for k = sum of m b a'.
inline Eigen::Vector3d axial(const Eigen::Matrix3d& k) noexcept {
  return {k(2, 1) - k(1, 2), k(0, 2) - k(2, 0), k(1, 0) - k(0, 1)};
}

/// Sum over the body of m n(r), and of r x m n(r), for the field n(r) = linear + turning r.
inline Wrench weigh(const RigidInertia& body, const Eigen::Vector3d& linear,
                    const Eigen::Matrix3d& turning) noexcept {
  return {body.mass * linear + turning * body.first_moment,
          body.first_moment.cross(linear) + axial(turning * second_moments(body))};
}

/// Sum over the body of m x(r) x n(r), with x(r) the velocities of a twist.
inline Eigen::Vector3d couple(const RigidInertia& body, const Twist& x,
                              const Eigen::Vector3d& linear,
                              const Eigen::Matrix3d& turning) noexcept {
  const Eigen::Vector3d& h = body.first_moment;
  return x.linear.cross(body.mass * linear + turning * h) + x.angular.cross(h).cross(linear) +
         axial(turning * second_moments(body) * hat(x.angular).transpose());
}

/// Outwards: twists of X and Y, and D_X Y as a field, from the parent's.
///
/// With G the body's pose and G Y^ its derivative along Y, D_X D_Y G = G (X^ Y^ + (X Y)^), and
/// Y = Ad(parent to child) Y_parent + S y changes along X by
///   X Y = Ad (X Y)_parent + [Ad Y_parent, S x],
/// as S and y are constant in the body's own coordinates.
inline void second_derivative(const Body& body, const Pose& parent_from_body,
                              const Workspace::FieldState& parent, const VectorIn& x,
                              const VectorIn& y, Workspace::FieldState& state) noexcept {
  const Twist joint = joint_twist(body, x);
  state.x = to_child(parent_from_body, parent.x) + joint;
  const Twist y_handed_on = to_child(parent_from_body, parent.y);
  state.y = y_handed_on + joint_twist(body, y);
  state.rate = to_child(parent_from_body, parent.rate) + cross(y_handed_on, joint);
  state.linear = state.rate.linear + state.x.angular.cross(state.y.linear);
  state.turning = hat(state.rate.angular) + hat(state.x.angular) * hat(state.y.angular);
}

/// D_X Y over every body whose parent_from_body is in the workspace.
inline void second_derivatives(const Mechanism& mechanism, Workspace& workspace, const VectorIn& x,
                               const VectorIn& y) noexcept {
  const Workspace::FieldState at_rest{};
  for (std::size_t i = 0; i < mechanism.bodies().size(); ++i) {
    const Body& body = mechanism.bodies()[i];
    second_derivative(
        body, workspace.body[i].parent_from_body,
        body.parent == kWorld ? at_rest : workspace.field[static_cast<std::size_t>(body.parent)], x,
        y, workspace.field[i]);
  }
}

/// Inwards: <n, E_i> for the field n in the workspace, into `result` [nv].
inline void tangential_part(const Mechanism& mechanism, Workspace& workspace,
                            Eigen::VectorXd& result) noexcept {
  const auto& bodies = mechanism.bodies();
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    auto& state = workspace.field[i];
    state.wrench = weigh(bodies[i].inertia, state.linear, state.turning);
  }
  result.setZero();
  for (std::size_t i = bodies.size(); i-- > 0;) {
    const Body& body = bodies[i];
    const Wrench& carried = workspace.field[i].wrench;
    for (int k = 0; k < freedoms(body.motion); ++k) {
      result[body.dof + k] += along_axis(body, carried, k);
    }
    if (body.parent != kWorld) {
      workspace.field[static_cast<std::size_t>(body.parent)].wrench +=
          to_parent(workspace.body[i].parent_from_body, carried);
    }
  }
}

}  // namespace geodesic::control
