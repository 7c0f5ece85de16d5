// Implements gravity.hpp.
#include "control/mechanism/gravity.hpp"

#include <cassert>

#include "control/mechanism/inward_pass.hpp"
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
  inward_pass(mechanism, workspace, workspace.gravity);
  return workspace.gravity;
}

}  // namespace geodesic::control
