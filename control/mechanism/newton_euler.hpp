// Inverse dynamics in one pass outwards and one inwards: the bias covector, and the torque for a
// given acceleration. No matrices; those are in metric.hpp and coriolis.hpp.
#pragma once

#include "control/mechanism/mechanism.hpp"
#include "control/mechanism/workspace.hpp"

namespace geodesic::control {

/// Bias covector b(q, v) = C(q, v) v + g(q): the torque that holds the motion's acceleration at
/// zero.
/// @param q  configuration, size nq    @param v  velocity, size nv [rad/s, m/s]
/// @return   covector, size nv [N·m, N]; lives in the workspace until the next call.
/// Real-time, O(n). Source: Featherstone 2008, table 5.1 with qdd = 0.
const Eigen::VectorXd& bias(const Mechanism& mechanism, Workspace& workspace, const VectorIn& q,
                            const VectorIn& v) noexcept;

/// tau = M(q) a + C(q, v) v + g(q), rotor inertia included.
/// @param q  size nq    @param v  size nv    @param a  dv/dt, size nv [rad/s², m/s²]
/// @return   covector, size nv [N·m, N]; lives in the workspace until the next call.
/// Real-time, O(n). Source: Featherstone 2008, table 5.1.
const Eigen::VectorXd& inverse_dynamics(const Mechanism& mechanism, Workspace& workspace,
                                        const VectorIn& q, const VectorIn& v,
                                        const VectorIn& a) noexcept;

}  // namespace geodesic::control
