// Implements newton_euler.hpp.
#include "control/mechanism/newton_euler.hpp"

#include <cassert>

#include "control/mechanism/inward_pass.hpp"
#include "control/mechanism/joint_motion.hpp"

namespace geodesic::control {
namespace {

/// The recursion itself; `a` null stands for no acceleration.
void newton_euler(const Mechanism& mechanism, Workspace& workspace, const VectorIn& q,
                  const VectorIn& v, const double* a, Eigen::VectorXd& result) noexcept {
  assert(q.size() == mechanism.nq() && v.size() == mechanism.dof());
  const auto& bodies = mechanism.bodies();
  // Outwards: motion. The world accelerates upwards, which stands for gravity.
  const Twist at_rest;
  const Twist upwards{-mechanism.gravity(), Eigen::Vector3d::Zero()};
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const Body& body = bodies[i];
    auto& state = workspace.body[i];
    state.parent_from_body = parent_from_body(mechanism, body, q);
    const bool on_world = body.parent == kWorld;
    const auto& parent = workspace.body[on_world ? i : static_cast<std::size_t>(body.parent)];
    const Pose& pose = state.parent_from_body;
    state.velocity = body_velocity(body, pose, on_world ? at_rest : parent.velocity, v);
    state.acceleration = to_child(pose, on_world ? upwards : parent.acceleration);
    if (body.motion == Motion::kFree) {
      if (a != nullptr) {
        state.acceleration.linear += Eigen::Map<const Eigen::Vector3d>(a);
        state.acceleration.angular += Eigen::Map<const Eigen::Vector3d>(a + 3);
      }
    } else {
      const Twist bend = axis_rate(body, state.velocity);
      state.acceleration.linear += v[body.dof] * bend.linear;
      state.acceleration.angular += v[body.dof] * bend.angular;
      if (a != nullptr) {
        add_along_axis(body, a[body.dof], state.acceleration);
      }
    }
    state.force =
        body.inertia * state.acceleration + cross(state.velocity, body.inertia * state.velocity);
  }
  inward_pass(mechanism, workspace, result);
}

}  // namespace

const Eigen::VectorXd& bias(const Mechanism& mechanism, Workspace& workspace, const VectorIn& q,
                            const VectorIn& v) noexcept {
  newton_euler(mechanism, workspace, q, v, nullptr, workspace.bias);
  return workspace.bias;
}

const Eigen::VectorXd& inverse_dynamics(const Mechanism& mechanism, Workspace& workspace,
                                        const VectorIn& q, const VectorIn& v,
                                        const VectorIn& a) noexcept {
  assert(a.size() == mechanism.dof());
  newton_euler(mechanism, workspace, q, v, a.data(), workspace.inverse_dynamics);
  workspace.inverse_dynamics += mechanism.rotor_inertia().cwiseProduct(a);
  return workspace.inverse_dynamics;
}

}  // namespace geodesic::control
