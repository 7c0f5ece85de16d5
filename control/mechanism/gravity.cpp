// Implements gravity.hpp.
#include "control/mechanism/gravity.hpp"

#include <cassert>

#include "control/mechanism/joint_motion.hpp"

namespace geodesic::control {

const Eigen::VectorXd& gravity(const Mechanism& mechanism, Workspace& workspace,
                               const VectorIn& q) noexcept {
  assert(q.size() == mechanism.nq());
  const auto& bodies = mechanism.bodies();
  // Outwards: the upward acceleration that stands for gravity, in each body's axes.
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const Body& body = bodies[i];
    auto& state = workspace.body[i];
    state.parent_from_body = parent_from_body(mechanism, body, q);
    const auto down = state.parent_from_body.rotation.transpose();
    if (body.parent == kWorld) {
      state.acceleration.linear = -(down * mechanism.gravity());
    } else {
      state.acceleration.linear =
          down * workspace.body[static_cast<std::size_t>(body.parent)].acceleration.linear;
    }
    state.force.force = body.inertia.mass * state.acceleration.linear;
    state.force.moment = body.inertia.first_moment.cross(state.acceleration.linear);
  }
  // Inwards: what each joint must carry.
  Eigen::VectorXd& result = workspace.gravity;
  result.setZero();
  for (std::size_t i = bodies.size(); i-- > 0;) {
    const Body& body = bodies[i];
    const auto& state = workspace.body[i];
    if (body.motion == Motion::kFree) {
      result.head<3>() = state.force.force;
      result.segment<3>(3) = state.force.moment;
      continue;
    }
    result[body.dof] += along_axis(body, state.force);
    if (body.parent != kWorld) {
      workspace.body[static_cast<std::size_t>(body.parent)].force +=
          to_parent(state.parent_from_body, state.force);
    }
  }
  return result;
}

}  // namespace geodesic::control
