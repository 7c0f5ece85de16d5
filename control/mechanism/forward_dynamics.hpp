// The acceleration that torques cause.
#pragma once

#include "control/mechanism/mechanism.hpp"
#include "control/mechanism/workspace.hpp"

namespace geodesic::control {

/// a with M(q) a + C(q, v) v + g(q) = tau.
/// @param q  size nq    @param v  size nv    @param tau  size nv [N·m, N]
/// @return   dv/dt, size nv [rad/s², m/s²], in the workspace until the next call; null if M(q) is
///   singular to working precision. Overwrites the results of metric() and bias().
/// Real-time, O(n^3). Composite bodies and Cholesky rather than articulated bodies, since mimic
/// joints make loops that the latter cannot cut.
const Eigen::VectorXd* forward_dynamics(const Mechanism& mechanism, Workspace& workspace,
                                        const VectorIn& q, const VectorIn& v,
                                        const VectorIn& tau) noexcept;

}  // namespace geodesic::control
