// The two maps between velocities and momenta that a metric gives, flat and sharp, and the inverse
// metric on covectors.
#pragma once

#include "control/mechanism/mechanism.hpp"
#include "control/mechanism/workspace.hpp"

namespace geodesic::control {

/// v -> p = M(q) v, the momentum of the velocity v, without forming M.
/// @param q  size nq    @param v  size nv [rad/s, m/s]
/// @return   covector, size nv [N·m·s, N·s]; lives in the workspace until the next call.
/// Real-time, O(n): the momentum that each joint carries, along its axis.
const Eigen::VectorXd& flat(const Mechanism& mechanism, Workspace& workspace, const VectorIn& q,
                            const VectorIn& v) noexcept;

/// p -> v with M(q) v = p; the inverse of flat(). Of the differential dV of a function it makes the
/// gradient.
/// @param q  size nq    @param p  covector, size nv
/// @return   size nv, in the workspace until the next call; null if M(q) is singular to working
///   precision, as with a massless link at a tip. Overwrites the result of metric().
/// Real-time, O(n depth^2).
const Eigen::VectorXd* sharp(const Mechanism& mechanism, Workspace& workspace, const VectorIn& q,
                             const VectorIn& p) noexcept;

/// Inverse of M(q), nv x nv, full and symmetric to the bit; null if M(q) is singular to working
/// precision. Overwrites the result of metric(). Real-time, O(n^2 depth).
const Eigen::MatrixXd* metric_inverse(const Mechanism& mechanism, Workspace& workspace,
                                      const VectorIn& q) noexcept;

}  // namespace geodesic::control
