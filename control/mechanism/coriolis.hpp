// How the metric changes along a motion: Coriolis matrix and rate of the metric. Christoffel
// symbols are in christoffel.hpp, covariant derivatives in connection.hpp.
#pragma once

#include <Eigen/Core>

#include "control/mechanism/mechanism.hpp"
#include "control/mechanism/workspace.hpp"

namespace geodesic::control {

/// C(q, v) of the Levi-Civita connection, C_ij = <nabla_v Ej, Ei>, made of Christoffel symbols of
/// the first kind: dM/dt = C + C' along v, and C v is the Coriolis covector.
/// @param q  size nq    @param v  size nv
/// @return   nv x nv [N·m·s, ...]; lives in the workspace until the next call.
/// Real-time, O(n depth). Source: Echeandia, Wensing 2021, "Numerical methods to compute the
/// Coriolis matrix and Christoffel symbols for rigid-body systems", algorithm 1.
const Eigen::MatrixXd& coriolis_matrix(const Mechanism& mechanism, Workspace& workspace,
                                       const VectorIn& q, const VectorIn& v) noexcept;

/// dM/dt along v: symmetric to the bit. Overwrites the result of coriolis_matrix(). Lives in the
/// workspace until the next call. Real-time, O(n depth).
const Eigen::MatrixXd& metric_rate(const Mechanism& mechanism, Workspace& workspace,
                                   const VectorIn& q, const VectorIn& v) noexcept;

}  // namespace geodesic::control
