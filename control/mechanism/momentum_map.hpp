// Noether: the momentum map of a symmetry given by its infinitesimal generator, the symmetry's
// test, and the generators of rigid motions.
#pragma once

#include <Eigen/Core>
#include <functional>

#include "control/geometry/se3.hpp"
#include "control/mechanism/mechanism.hpp"
#include "control/mechanism/workspace.hpp"

namespace geodesic::control {

/// A vector field on Q: writes its components [nv] in the frame of connection.hpp at q [nq].
using VectorField = std::function<void(const VectorIn& q, Eigen::Ref<Eigen::VectorXd> components)>;

/// J(q, v) = <<v, xi(q)>> by the metric. Along free motion it is constant for every v exactly if xi
/// is a Killing field (see lie_derivative_of_metric).
/// @param q  size nq    @param v  size nv    @param xi  components of the generator at q, size nv
/// Real-time, O(n). Source: Marsden, Ratiu 1999, corollary 12.1.2 (Noether: theorem 11.4.1).
double momentum_map(const Mechanism& mechanism, Workspace& workspace, const VectorIn& q,
                    const VectorIn& v, const VectorIn& xi) noexcept;

/// E_i(xi_k) in row k, column i, by central differences of sixth order: good to about 1e-11 of the
/// field where it varies over angles of 1 rad and lengths of 1 m.
/// @param result  nv x nv. Allocates nothing itself; 6 nv evaluations of the field.
void field_derivative(const Mechanism& mechanism, Workspace& workspace, const VectorIn& q,
                      const VectorField& xi, Eigen::Ref<Eigen::MatrixXd> result);

/// Lie derivative of the metric along xi, (i, j) = xi(M_ij) - <[xi, Ei], Ej> - <Ei, [xi, Ej]>: zero
/// everywhere exactly if the flow of xi moves Q as an isometry.
/// @param q  size nq    @param xi  components at q, size nv
/// @param xi_derivative  E_i(xi_k) in row k, column i, nv x nv: known, or by field_derivative()
/// @return   nv x nv, symmetric; lives in the workspace until the next call. Overwrites the results
///   of metric() and metric_rate(). Real-time, O(n^3).
/// Source: Abraham, Marsden 1978, "Foundations of mechanics", section 2.2.
const Eigen::MatrixXd& lie_derivative_of_metric(
    const Mechanism& mechanism, Workspace& workspace, const VectorIn& q, const VectorIn& xi,
    const Eigen::Ref<const Eigen::MatrixXd>& xi_derivative) noexcept;

/// Noether's balance: dJ/dt = (L_xi M)(v, v) / 2 + (tau - dV) . xi, whatever the motion.
/// Arguments as above; tau [nv] all torques that are not gravity's. Real-time, O(n^3).
double momentum_map_rate(const Mechanism& mechanism, Workspace& workspace, const VectorIn& q,
                         const VectorIn& v, const VectorIn& tau, const VectorIn& xi,
                         const Eigen::Ref<const Eigen::MatrixXd>& xi_derivative) noexcept;

/// Generator of a rigid motion of everything that moves: of translations along an axis, rotations
/// about an axis, or screws. Its momentum map is dot(spatial_momentum(), twist).
/// @param q  size nq
/// @param twist  of space: world axes, at the world's origin
/// @param result  components at q, size nv
/// @return   false if the mechanism cannot move so (an arm on a fixed base can turn about its first
///   axis, a floating one can do anything); result is then of no use. Real-time, O(n).
bool rigid_motion(const Mechanism& mechanism, Workspace& workspace, const VectorIn& q,
                  const Twist& twist, Eigen::Ref<Eigen::VectorXd> result) noexcept;

}  // namespace geodesic::control
