// The kinetic-energy metric of the configuration space (the joint-space inertia matrix). Its
// inverse is in musical.hpp, its derivatives in coriolis.hpp and christoffel.hpp.
#pragma once

#include "control/mechanism/mechanism.hpp"
#include "control/mechanism/workspace.hpp"

namespace geodesic::control {

/// M(q): kinetic energy is v' M v / 2, rotor inertia included.
/// @param q  configuration, size nq
/// @return   nv x nv, full and symmetric to the bit [kg·m², kg·m, kg]; lives in the workspace until
///   the next call.
/// Real-time, O(n depth). Source: composite rigid bodies, Featherstone 2008, table 6.2.
const Eigen::MatrixXd& metric(const Mechanism& mechanism, Workspace& workspace,
                              const VectorIn& q) noexcept;

}  // namespace geodesic::control
