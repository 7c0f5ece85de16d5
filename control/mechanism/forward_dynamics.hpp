// The acceleration that torques cause.
#pragma once

#include "control/mechanism/mechanism.hpp"
#include "control/mechanism/workspace.hpp"

namespace geodesic::control {

/// a with M(q) a + C(q, v) v + g(q) = tau.
/// @param q  size nq    @param v  size nv    @param tau  size nv [N·m, N]
/// @return   dv/dt, size nv [rad/s², m/s²], in the workspace until the next call; null if M(q) is
///   singular to working precision. Overwrites the results of metric() and bias().
/// Real-time, O(n depth^2): composite bodies and the sparse factor of cholesky.hpp. In instructions
/// that is less than half of articulated_body.hpp for 7 joints, 0.7 of it for a quadruped, the same
/// for a branched tree of 32 joints; an unbranched chain of 32 is faster there by 1.8. Mimic
/// joints, which articulated bodies cannot cut, are no exception here.
const Eigen::VectorXd* forward_dynamics(const Mechanism& mechanism, Workspace& workspace,
                                        const VectorIn& q, const VectorIn& v,
                                        const VectorIn& tau) noexcept;

}  // namespace geodesic::control
