// The Levi-Civita connection of the kinetic-energy metric, in the recursions of the tree: covariant
// derivatives, geodesic acceleration, gradient. Its coefficients as tables are in christoffel.hpp,
// its curvature in curvature.hpp.
//
// The frame. v[i] is the component along the field E_i of a frame of Q: the coordinate fields where
// a joint has an angle or a distance, the left-invariant fields of SO(3) or SE(3) where it is
// spherical or free (quasi-velocities). These do not all commute: [E_i, E_j] = c_ij^k E_k with the
// structure constants of the factor's Lie algebra (frame_bracket). The connection nabla is the one
// with
//   X<Y, Z> = <nabla_X Y, Z> + <Y, nabla_X Z>        (compatible with the metric),
//   nabla_X Y - nabla_Y X = [X, Y]                   (torsion-free),
// which are Koszul's formula for its coefficients (do Carmo 1992, theorem 3.6 of chapter 2):
//   2 <nabla_Ek Ej, Ei> = Ek(M_ij) + Ej(M_ik) - Ei(M_jk)
//                         + <[Ek, Ej], Ei> - <[Ek, Ei], Ej> - <[Ej, Ei], Ek>.
// With coordinate fields the brackets vanish and the Christoffel symbols remain.
//
// How it is computed. T = sum of m |dx/dt|^2 / 2 says that Q is immersed isometrically in the flat
// space of the positions of all particles. There, D_X Y is the plain second derivative of
// positions, a field of accelerations over each body; nabla_X Y is its tangential part (do Carmo
// 1992, chapter 6, proposition 2.1): <nabla_X Y, E_i> = sum m (D_X Y) . (E_i x), which is one
// Newton-Euler recursion, bilinear in X and Y. No derivative of M is taken.
#pragma once

#include "control/mechanism/mechanism.hpp"
#include "control/mechanism/workspace.hpp"

namespace geodesic::control {

/// [x, y] for fields of constant components: zero except along spherical and free joints.
/// @param x, y  size nv    @param result  size nv, neither of them. Real-time, O(n).
void frame_bracket(const Mechanism& mechanism, const VectorIn& x, const VectorIn& y,
                   Eigen::Ref<Eigen::VectorXd> result) noexcept;

/// The covector <nabla_X Y, .> for fields of constant components x and y: the connection of the
/// first kind, sum over j, k of Christoffel(i, j, k) y_j x_k. With x = y = v the Coriolis covector
/// C(q, v) v.
/// @param q  size nq    @param x, y  size nv
/// @return   covector, size nv, in the workspace until the next call. Real-time, O(n).
const Eigen::VectorXd& connection_covector(const Mechanism& mechanism, Workspace& workspace,
                                           const VectorIn& q, const VectorIn& x,
                                           const VectorIn& y) noexcept;

/// DY/dt = dy/dt + nabla_v Y, the covariant derivative of a vector field along a curve; with y = v
/// and dy/dt the numbers' rate it is the acceleration that torques see: flat(Dv/dt) = tau - g.
/// @param q  point of the curve, size nq    @param v  its velocity, size nv
/// @param y  components of the field, size nv    @param y_rate  their time derivatives, size nv
/// @return   size nv, in the workspace until the next call; null if M(q) is singular to working
///   precision. Overwrites the result of metric().
/// Real-time, O(n depth^2). Source: Bullo, Lewis 2004, section 3.8.
const Eigen::VectorXd* covariant_derivative(const Mechanism& mechanism, Workspace& workspace,
                                            const VectorIn& q, const VectorIn& v, const VectorIn& y,
                                            const VectorIn& y_rate) noexcept;

/// dv/dt of the geodesic through q with velocity v: -nabla_v v, which takes the Christoffel symbols
/// of the second kind where the Coriolis covector takes those of the first. The motion without
/// gravity and torque. Arguments, result and cost as covariant_derivative().
const Eigen::VectorXd* geodesic_acceleration(const Mechanism& mechanism, Workspace& workspace,
                                             const VectorIn& q, const VectorIn& v) noexcept;

/// Gradient of the potential energy by the metric: sharp(dV), so that without torque
/// Dv/dt = -grad V. Arguments, result and cost as covariant_derivative().
const Eigen::VectorXd* potential_gradient(const Mechanism& mechanism, Workspace& workspace,
                                          const VectorIn& q) noexcept;

}  // namespace geodesic::control
