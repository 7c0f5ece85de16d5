// The gravity covector alone, for an arm at rest; with velocity see newton_euler.hpp.
#pragma once

#include "control/mechanism/mechanism.hpp"
#include "control/mechanism/workspace.hpp"

namespace geodesic::control {

/// Gravity covector g(q) = dU/dq: the torque that holds the arm at rest.
/// @param q  configuration, size nq
/// @return   covector, size nv [N·m, N]; lives in the workspace until the next call.
/// Real-time, O(n). Source: Featherstone 2008, table 5.1 with v = a = 0: only forces remain, whose
/// moments are taken from tip to base.
const Eigen::VectorXd& gravity(const Mechanism& mechanism, Workspace& workspace,
                               const VectorIn& q) noexcept;

}  // namespace geodesic::control
