// The second half of every recursion over the tree: from each body's own wrench to what each joint
// must carry. What the wrenches are is the first half's business, in the algorithms' own files.
#pragma once

#include "control/mechanism/joint_motion.hpp"

namespace geodesic::control {

/// Sums workspace.body[i].force from the tips to the base (Featherstone 2008, table 5.1, second
/// loop). Needs parent_from_body of every body; its forces hold the sums afterwards. Real-time,
/// O(n).
/// @param result  covector, size nv [N·m, N]
inline void inward_pass(const Mechanism& mechanism, Workspace& workspace,
                        Eigen::VectorXd& result) noexcept {
  const auto& bodies = mechanism.bodies();
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
}

}  // namespace geodesic::control
