// Kinetic and potential energy of everything that moves.
#pragma once

#include "control/mechanism/mechanism.hpp"
#include "control/mechanism/workspace.hpp"

namespace geodesic::control {

/// v' M(q) v / 2 [J], rotor inertia included.
/// @param q  size nq    @param v  size nv    Real-time, O(n).
double kinetic_energy(const Mechanism& mechanism, Workspace& workspace, const VectorIn& q,
                      const VectorIn& v) noexcept;

/// U(q) = -sum of mass * gravity . centre of mass, over the moving links [J]; zero with every
/// centre of mass at the world's origin.
/// @param q  size nq    Real-time, O(n).
double potential_energy(const Mechanism& mechanism, Workspace& workspace,
                        const VectorIn& q) noexcept;

}  // namespace geodesic::control
