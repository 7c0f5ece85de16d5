// Generalised momentum and what changes it while no torque acts: the two sides of the balance that
// external torques are observed from. Makes no matrix; the observer itself is in safety/.
#pragma once

#include "control/mechanism/mechanism.hpp"
#include "control/mechanism/workspace.hpp"

namespace geodesic::control {

/// p = M(q) v into workspace.joint_momentum [kg·m²/s, kg·m/s], and C(q, v)' v - g(q) into
/// workspace.momentum_drift [N·m, N], so that dp/dt = tau + drift. Rotor inertia included.
/// @param q  size nq    @param v  size nv
/// Real-time, O(n). Source: C'v is the gradient of kinetic energy over q (De Luca, Mattone 2005,
/// equation 6); for a tree that is, joint by joint, dot(h, v x S), with h the momentum of all that
/// the joint carries and v x S the rate of its axis (Featherstone 2008, equation 2.45, on T).
void momentum_balance(const Mechanism& mechanism, Workspace& workspace, const VectorIn& q,
                      const VectorIn& v) noexcept;

}  // namespace geodesic::control
