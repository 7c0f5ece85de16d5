// The time derivative of a link's Jacobian; the Jacobian itself is in kinematics.hpp.
#pragma once

#include "control/mechanism/kinematics.hpp"

namespace geodesic::control {

/// dJ/dt of jacobian() along v, so that J a + (dJ/dt) v is the time derivative of the link's
/// velocity in jacobian()'s sense: of its origin's velocity and its angular velocity, world axes.
/// @param q  size nq    @param v  size nv    @param link  index in mechanism.links()
/// @return   6 x nv; lives in the workspace until the next call. Real-time, O(n).
/// Column by column the product rule on (s + z x lever, z), the joint's column (s, z) in world axes
/// turning with the body that carries it (Featherstone 2008, section 4.5).
const Jacobian& jacobian_rate(const Mechanism& mechanism, Workspace& workspace, const VectorIn& q,
                              const VectorIn& v, int link) noexcept;

}  // namespace geodesic::control
