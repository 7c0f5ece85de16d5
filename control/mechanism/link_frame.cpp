// Implements link_frame.hpp.
#include "control/mechanism/link_frame.hpp"

#include <cassert>

#include "control/mechanism/joint_motion.hpp"

namespace geodesic::control {

Twist link_twist(const Mechanism& mechanism, Workspace& workspace, const VectorIn& q,
                 const VectorIn& v, int link, Frame frame) noexcept {
  assert(q.size() == mechanism.nq() && v.size() == mechanism.dof() && link >= 0);
  update_velocities(mechanism, workspace, q, v);
  const LinkFrame& of = mechanism.links()[static_cast<std::size_t>(link)];
  if (of.body == kWorld) {
    return {};
  }
  const Twist& carrier = workspace.body[static_cast<std::size_t>(of.body)].velocity;
  return to_parent(frame_from_link(link_pose(mechanism, q, link), frame),
                   to_child(of.body_from_link, carrier));
}

Wrench link_wrench(const Mechanism& mechanism, const VectorIn& q, int link, const Wrench& wrench,
                   Frame from, Frame to) noexcept {
  const Pose world_from_link = link_pose(mechanism, q, link);
  return to_parent(frame_from_link(world_from_link, to),
                   to_child(frame_from_link(world_from_link, from), wrench));
}

const Jacobian& jacobian(const Mechanism& mechanism, Workspace& workspace, const VectorIn& q,
                         int link, Frame frame) noexcept {
  jacobian(mechanism, workspace, q, link);
  Jacobian& result = workspace.jacobian;
  if (frame == Frame::kLinkOrigin) {
    return result;
  }
  const Pose world_from_link = link_pose(mechanism, q, link);
  const Pose from_aligned = frame_from_link(world_from_link, frame) *
                            inverse(frame_from_link(world_from_link, Frame::kLinkOrigin));
  for (Eigen::Index i = 0; i < result.cols(); ++i) {
    const Twist column =
        to_parent(from_aligned, Twist{result.col(i).head<3>(), result.col(i).tail<3>()});
    result.col(i) << column.linear, column.angular;
  }
  return result;
}

}  // namespace geodesic::control
