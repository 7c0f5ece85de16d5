// Implements gravity.hpp on compact bodies: light ones push on nothing, they only turn.
#include "control/mechanism/gravity.hpp"

#include <cassert>

#include "control/mechanism/compact_dispatch.hpp"
#include "control/mechanism/compact_motion.hpp"

namespace geodesic::control {
namespace {

/// First moment times the upward acceleration, of a light body.
inline Triple light_moment(const CompactBody& body, const Triple& up) noexcept {
  return {body.h_y * up.z, -(body.h_x * up.z), body.h_x * up.y - body.h_y * up.x};
}

/// Outwards: the upward acceleration that stands for gravity, in each body's axes, and the wrench
/// that holds the body against it.
[[gnu::always_inline]] inline void outwards(const CompactBody* bodies, std::size_t n,
                                            Workspace& workspace, const double* q) noexcept {
  Workspace::Load* load = workspace.load.data();
  Triple up;
  for (std::size_t i = 0; i < n; ++i) {
    const CompactBody& body = bodies[i];
    if (!body.pushes && with_step(body, workspace.sine[i], workspace.cosine[i],
                                  [&](const auto& rotation, auto /*reaches*/) {
                                    up = rotation.to_body(up);
                                    load[i].moment = light_moment(body, up);
                                  })) {
      continue;
    }
    if (body.at_base) {
      up = body.up;
    } else if (!body.chained) {
      up = workspace.course[static_cast<std::size_t>(body.parent)].acceleration;
    }
    with_rotation(body, workspace.sine[i], workspace.cosine[i],
                  [&](const auto& rotation) { up = rotation.to_body(up); });
    if (body.many) {
      const Axes& axes = workspace.axes[i] = axes_at(q + body.coordinate + angular_offset(body));
      up = from_joint(axes, up);
    }
    if (body.forks) {
      workspace.course[i].acceleration = up;
    }
    load[i].moment = light_moment(body, up);
    if (!body.light) {
      load[i].moment.x -= body.h_z * up.y;
      load[i].moment.y += body.h_z * up.x;
    }
    if (body.pushes) {
      load[i].force = body.mass * up;
    }
  }
}

/// Inwards: moments, and forces where there are any.
[[gnu::always_inline]] inline void inwards(const CompactBody* bodies, std::size_t n,
                                           Workspace& workspace, const double* q,
                                           double* result) noexcept {
  Workspace::Load* load = workspace.load.data();
  Triple carried;  // moment from the body before, in a chain
  for (std::size_t i = n; i-- > 0;) {
    const CompactBody& body = bodies[i];
    Triple moment = load[i].moment + carried;
    if (!body.pushes && with_step(body, workspace.sine[i], workspace.cosine[i],
                                  [&](const auto& rotation, auto /*reaches*/) {
                                    result[body.dof] += body.ratio * moment.z;
                                    carried = rotation.to_parent(moment);
                                  })) {
      continue;
    }
    carried = {};
    if (body.many) {
      put(moment, result + body.dof + angular_offset(body));
      if (body.motion == Motion::kFree) {
        put(load[i].force, result + body.dof);
      }
      moment = to_joint(workspace.axes[i], moment);
    } else {
      result[body.dof] += body.ratio * (body.rotates ? moment.z : load[i].force.z);
    }
    if (body.at_base) {
      continue;
    }
    with_rotation(body, workspace.sine[i], workspace.cosine[i], [&](const auto& rotation) {
      moment = rotation.to_parent(moment);
      if (body.pushes) {
        const Triple& own = load[i].force;
        const Triple force = rotation.to_parent(body.many ? to_joint(workspace.axes[i], own) : own);
        Workspace::Load& parent = load[body.parent];
        parent.force = parent.force + force;
        add_moment_of(body, rotation, q, force, moment);
      }
    });
    if (body.chained) {
      carried = moment;
    } else {
      load[body.parent].moment = load[body.parent].moment + moment;
    }
  }
}

}  // namespace

const Eigen::VectorXd& gravity(const Mechanism& mechanism, Workspace& workspace,
                               const VectorIn& q) noexcept {
  assert(q.size() == mechanism.nq());
  const CompactTree& tree = mechanism.compact_tree();
  const CompactBody* bodies = tree.bodies.data();
  const std::size_t n = tree.bodies.size();
  const double* at = q.data();
  workspace.gravity.setZero();
  double* out = workspace.gravity.data();
  run_with(workspace.registers, [&](auto lanes) noexcept {
    find_angles<lanes()>(tree, at, workspace);
    outwards(bodies, n, workspace, at);
    inwards(bodies, n, workspace, at, out);
  });
  return workspace.gravity;
}

}  // namespace geodesic::control
