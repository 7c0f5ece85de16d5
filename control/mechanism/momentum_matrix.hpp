// Momentum of the whole mechanism as a wrench in the world: about the world's origin, and the
// matrix that makes centroidal momentum of velocities. Rotors left out. Centroidal momentum body by
// body is in momentum.hpp.
#pragma once

#include "control/mechanism/momentum.hpp"

namespace geodesic::control {

/// Linear momentum and angular momentum about the world's origin, world axes [kg·m/s, kg·m²/s]:
/// constant while nothing outside pushes. It is the momentum map of the rigid motions of space
/// (momentum_map.hpp), an element of se(3)*.
/// @param q  size nq    @param v  size nv    Real-time, O(n).
Wrench spatial_momentum(const Mechanism& mechanism, Workspace& workspace, const VectorIn& q,
                        const VectorIn& v) noexcept;

/// A(q), 6 x nv, with h = A v the centroidal momentum: rows 0-2 linear, 3-5 angular about the
/// centre of mass, world axes.
/// @param q  size nq
/// @return   lives in the workspace until the next call. Real-time, O(n).
/// Source: Orin, Goswami, Lee 2013, "Centroidal dynamics of a humanoid robot", by composite
/// bodies.
const Jacobian& centroidal_momentum_matrix(const Mechanism& mechanism, Workspace& workspace,
                                           const VectorIn& q) noexcept;

}  // namespace geodesic::control
