// Newton-Euler as the textbook writes it, on the mechanism's plain bodies: what the fast recursion
// of control/mechanism/newton_euler.cpp is compared with.
#pragma once

#include <cmath>
#include <vector>

#include "control/mechanism/joint_motion.hpp"

namespace geodesic::control::testing {

/// tau = M(q) a + C(q, v) v + g(q), without rotor inertia (Featherstone 2008, table 5.1).
inline Eigen::VectorXd plain_newton_euler(const Mechanism& mechanism, const Eigen::VectorXd& q,
                                          const Eigen::VectorXd& v, const Eigen::VectorXd& a) {
  struct State {
    Pose pose;
    Twist velocity;
    Twist acceleration;
    Wrench force;
  };
  const auto& bodies = mechanism.bodies();
  std::vector<State> states(bodies.size());
  const Twist upwards{-mechanism.gravity(), Eigen::Vector3d::Zero()};
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const Body& body = bodies[i];
    State& state = states[i];
    State world;
    world.acceleration = upwards;
    const State& parent =
        body.parent == kWorld ? world : states[static_cast<std::size_t>(body.parent)];
    state.pose = parent_from_body(body, q);
    state.velocity = body_velocity(body, state.pose, parent.velocity, v);
    state.acceleration = to_child(state.pose, parent.acceleration);
    state.acceleration =
        state.acceleration + cross(state.velocity, joint_twist(body, v)) + joint_twist(body, a);
    state.force =
        body.inertia * state.acceleration + cross(state.velocity, body.inertia * state.velocity);
  }
  Eigen::VectorXd tau = Eigen::VectorXd::Zero(mechanism.dof());
  for (std::size_t i = bodies.size(); i-- > 0;) {
    const Body& body = bodies[i];
    const Wrench& force = states[i].force;
    for (int k = 0; k < freedoms(body.motion); ++k) {
      tau[body.dof + k] += along_axis(body, force, k);
    }
    if (body.parent != kWorld) {
      states[static_cast<std::size_t>(body.parent)].force += to_parent(states[i].pose, force);
    }
  }
  return tau;
}

}  // namespace geodesic::control::testing
