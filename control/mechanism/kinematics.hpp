// Where links are and how they move: poses, velocities, Jacobians. No masses here; the
// configuration space itself is in configuration.hpp.
#pragma once

#include <Eigen/Core>

#include "control/geometry/se3.hpp"
#include "control/mechanism/mechanism.hpp"
#include "control/mechanism/workspace.hpp"

namespace geodesic::control {

/// Pose of every body in the world for q [nq], into workspace.body[].parent_from_body and
/// workspace.world_from_body. Real-time, O(n).
void update_poses(const Mechanism& mechanism, Workspace& workspace, const VectorIn& q) noexcept;

/// Twist of every body for q [nq] and v [nv], in its own coordinates, into
/// workspace.body[].velocity; parent_from_body as above. Real-time, O(n).
void update_velocities(const Mechanism& mechanism, Workspace& workspace, const VectorIn& q,
                       const VectorIn& v) noexcept;

/// world_from_link for q [nq].
/// @param link  index in mechanism.links()    Real-time, O(depth).
Pose link_pose(const Mechanism& mechanism, const VectorIn& q, int link) noexcept;

/// Maps v to the velocity of the link's origin (rows 0-2) and its angular velocity (rows 3-5), both
/// along the world's axes.
/// @param q  size nq    @param link  index in mechanism.links()
/// @return   6 x nv [m or 1; 1 or 1/m]; lives in the workspace until the next call. Real-time,
/// O(n).
const Jacobian& jacobian(const Mechanism& mechanism, Workspace& workspace, const VectorIn& q,
                         int link) noexcept;

}  // namespace geodesic::control
