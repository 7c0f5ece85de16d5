// Velocities of links and forces on them in the frames people name. How a pose carries twists and
// wrenches at all is in ../geometry/se3.hpp and spatial.hpp.
#pragma once

#include "control/geometry/spatial.hpp"
#include "control/mechanism/kinematics.hpp"
#include "control/mechanism/mechanism.hpp"
#include "control/mechanism/workspace.hpp"

namespace geodesic::control {

/// Whose origin and axes the six numbers of a link's twist, or of a wrench on it, belong to.
enum class Frame {
  kLink,  ///< the link's origin and axes: the body twist of Murray, Li, Sastry 1994, section 2.4
  kWorldOrigin,  ///< the world's origin and axes: their spatial twist
  kLinkOrigin,   ///< the link's origin, the world's axes: what jacobian() speaks of
};

/// Coordinates in the named frame from those in the link's own. Twists and wrenches of the link go
/// there by to_parent() and back by to_child(), which leaves their power as it is. Real-time.
inline Pose frame_from_link(const Pose& world_from_link, Frame frame) noexcept {
  switch (frame) {
    case Frame::kWorldOrigin:
      return world_from_link;
    case Frame::kLinkOrigin:
      return {world_from_link.rotation, Eigen::Vector3d::Zero()};
    case Frame::kLink:
      break;
  }
  return {};
}

/// Twist of a link in the named frame [m/s, rad/s].
/// @param q  size nq    @param v  size nv    @param link  index in mechanism.links()
/// Real-time, O(depth).
Twist link_twist(const Mechanism& mechanism, Workspace& workspace, const VectorIn& q,
                 const VectorIn& v, int link, Frame frame) noexcept;

/// The same wrench on a link, written in another frame [N, N·m].
/// @param q  size nq    @param link  index in mechanism.links()    Real-time, O(depth).
Wrench link_wrench(const Mechanism& mechanism, const VectorIn& q, int link, const Wrench& wrench,
                   Frame from, Frame to) noexcept;

/// Maps v to the link's twist in the named frame. Overwrites the result of jacobian(). Real-time.
/// @param q  size nq    @param link  index in mechanism.links()
/// @return   6 x nv, linear rows first; lives in the workspace until the next call. Real-time,
/// O(n).
const Jacobian& jacobian(const Mechanism& mechanism, Workspace& workspace, const VectorIn& q,
                         int link, Frame frame) noexcept;

}  // namespace geodesic::control
