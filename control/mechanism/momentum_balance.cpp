// Implements momentum_balance.hpp.
#include "control/mechanism/momentum_balance.hpp"

#include <cassert>

#include "control/mechanism/joint_motion.hpp"

namespace geodesic::control {

void momentum_balance(const Mechanism& mechanism, Workspace& workspace, const VectorIn& q,
                      const VectorIn& v) noexcept {
  assert(q.size() == mechanism.nq() && v.size() == mechanism.dof());
  const auto& bodies = mechanism.bodies();
  const Twist at_rest;
  // Outwards: velocity, and the upward acceleration that stands for gravity.
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const Body& body = bodies[i];
    auto& state = workspace.body[i];
    state.parent_from_body = parent_from_body(body, q);
    const auto down = state.parent_from_body.rotation.transpose();
    if (body.parent == kWorld) {
      state.velocity = body_velocity(body, state.parent_from_body, at_rest, v);
      state.acceleration.linear = -(down * mechanism.gravity());
    } else {
      const auto& parent = workspace.body[static_cast<std::size_t>(body.parent)];
      state.velocity = body_velocity(body, state.parent_from_body, parent.velocity, v);
      state.acceleration.linear = down * parent.acceleration.linear;
    }
    state.force.force = body.inertia.mass * state.acceleration.linear;
    state.force.moment = body.inertia.first_moment.cross(state.acceleration.linear);
    workspace.body_momentum[i] = body.inertia * state.velocity;
  }
  // Inwards: momentum and weight of all that each joint carries.
  Eigen::VectorXd& momentum = workspace.joint_momentum;
  Eigen::VectorXd& drift = workspace.momentum_drift;
  momentum = mechanism.rotor_inertia().cwiseProduct(v);
  drift.setZero();
  for (std::size_t i = bodies.size(); i-- > 0;) {
    const Body& body = bodies[i];
    const auto& state = workspace.body[i];
    const Wrench& carried = workspace.body_momentum[i];
    for (int k = 0; k < freedoms(body.motion); ++k) {
      momentum[body.dof + k] += along_axis(body, carried, k);
      drift[body.dof + k] +=
          dot(carried, axis_rate(body, state.velocity, k)) - along_axis(body, state.force, k);
    }
    if (body.parent != kWorld) {
      const auto parent = static_cast<std::size_t>(body.parent);
      workspace.body_momentum[parent] += to_parent(state.parent_from_body, carried);
      workspace.body[parent].force += to_parent(state.parent_from_body, state.force);
    }
  }
}

}  // namespace geodesic::control
