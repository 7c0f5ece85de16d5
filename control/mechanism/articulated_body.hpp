// The acceleration that torques cause, by articulated bodies: O(n), no matrix of the mechanism.
// The default, faster for arms, is in forward_dynamics.hpp; this is its independent check, and the
// better choice for very long chains.
#pragma once

#include "control/mechanism/mechanism.hpp"
#include "control/mechanism/workspace.hpp"

namespace geodesic::control {

/// a with M(q) a + C(q, v) v + g(q) = tau.
/// @param q  size nq    @param v  size nv    @param tau  size nv [N·m, N]
/// @return   dv/dt, size nv [rad/s², m/s²], in the workspace until the next call; null if a joint
///   meets no inertia, or if the mechanism has mimic joints: they make loops that articulated
///   bodies cannot cut.
/// Real-time, O(n). Source: Featherstone 2008, section 7.3, table 7.1, here with joints of one,
/// three or six degrees of freedom.
const Eigen::VectorXd* articulated_body_acceleration(const Mechanism& mechanism,
                                                     Workspace& workspace, const VectorIn& q,
                                                     const VectorIn& v,
                                                     const VectorIn& tau) noexcept;

}  // namespace geodesic::control
