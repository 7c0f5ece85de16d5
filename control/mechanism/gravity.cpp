// Implements gravity.hpp on compact bodies: light ones push on nothing, they only turn.
#include "control/mechanism/gravity.hpp"

#include <Eigen/Geometry>
#include <cassert>

#include "control/mechanism/compact_motion.hpp"

namespace geodesic::control {

const Eigen::VectorXd& gravity(const Mechanism& mechanism, Workspace& workspace,
                               const VectorIn& q) noexcept {
  assert(q.size() == mechanism.nq());
  const auto& bodies = mechanism.compact_bodies();
  find_angles(mechanism, workspace, q);
  // Outwards: the upward acceleration that stands for gravity, in each body's axes.
  const Triple upwards = -1.0 * triple(mechanism.gravity());
  Triple up;
  const int n = static_cast<int>(bodies.size());
  for (int i = 0; i < n; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const CompactBody& body = bodies[at];
    auto& state = workspace.compact[at];
    if (body.free) {
      const Eigen::Quaterniond orientation(q[6], q[3], q[4], q[5]);
      up = -1.0 * triple(orientation.normalized().conjugate() * mechanism.gravity());
    } else {
      if (body.parent == kWorld) {
        up = upwards;
      } else if (body.parent != i - 1) {
        up = workspace.compact[static_cast<std::size_t>(body.parent)].acceleration;
      }
      up = JointRotation(body, workspace.sine[at], workspace.cosine[at]).to_body(up);
    }
    state.acceleration = up;
    state.force = body.mass * up;
    state.moment = cross(triple(body.first_moment), up);
  }
  // Inwards: moments, and forces where there are any.
  Eigen::VectorXd& result = workspace.gravity;
  result.setZero();
  Triple carried;  // moment from the body before, in a chain
  for (int i = n - 1; i >= 0; --i) {
    const auto at = static_cast<std::size_t>(i);
    const CompactBody& body = bodies[at];
    const auto& state = workspace.compact[at];
    const Triple moment = state.moment + carried;
    carried = {};
    if (body.free) {
      result.head<6>() << state.force.x, state.force.y, state.force.z, moment.x, moment.y, moment.z;
      continue;
    }
    result[body.dof] += body.ratio * (body.rotates ? moment.z : state.force.z);
    if (body.parent == kWorld) {
      continue;
    }
    const JointRotation rotation(body, workspace.sine[at], workspace.cosine[at]);
    auto& parent = workspace.compact[static_cast<std::size_t>(body.parent)];
    Triple about_parent = rotation.to_parent(moment);
    if (body.pushes) {
      const Triple force = rotation.to_parent(state.force);
      parent.force = parent.force + force;
      about_parent = about_parent + cross(joint_translation(body, q), force);
    }
    if (body.parent == i - 1) {
      carried = about_parent;
    } else {
      parent.moment = parent.moment + about_parent;
    }
  }
  return workspace.gravity;
}

}  // namespace geodesic::control
