// Curvature of the configuration space under the kinetic-energy metric: Riemann's tensor and the
// sectional curvature of two directions. The connection is in connection.hpp.
//
// R(X, Y) Z = nabla_X nabla_Y Z - nabla_Y nabla_X Z - nabla_[X,Y] Z, so that a sphere is positive.
//
// Computed exactly, from first derivatives only. Q is immersed isometrically in the flat space of
// the positions of all particles (connection.hpp); its second fundamental form is what is normal in
// the accelerations, II(X, Y) = D_X Y - nabla_X Y, and Gauss' equation (do Carmo 1992, chapter 6,
// theorem 2.5, with a flat ambient space) gives
//   <R(X, Y) Z, W> = <II(Y, Z), II(X, W)> - <II(X, Z), II(Y, W)>:
// two recursions of the tree instead of derivatives of Christoffel symbols. It needs that kinetic
// energy is that of particles, as for every inertia (even one no body can have: the ambient metric
// is then indefinite), and counts a rotor's inertia as one more flat direction.
#pragma once

#include <Eigen/Core>

#include "control/mechanism/mechanism.hpp"
#include "control/mechanism/workspace.hpp"

namespace geodesic::control {

/// The covector <R(X, Y) Z, .>; sharp() makes the vector R(X, Y) Z of it.
/// @param q  size nq    @param x, y, z  components, size nv
/// @return   covector, size nv, in the workspace until the next call; null if M(q) is singular to
///   working precision. Overwrites the results of metric() and connection_covector().
/// Real-time, O(n depth^2).
const Eigen::VectorXd* curvature_covector(const Mechanism& mechanism, Workspace& workspace,
                                          const VectorIn& q, const VectorIn& x, const VectorIn& y,
                                          const VectorIn& z) noexcept;

/// Sectional curvature of the plane that x and y span: <R(x, y) y, x> over the squared area of
/// their parallelogram [1/J s² = 1/(kg m²)]. How fast geodesics that start side by side part
/// (negative) or meet (positive): their distance s obeys d²s/dt² = -K |v|² s.
/// @return NaN if x and y span no plane or M(q) is singular to working precision.
/// Real-time, O(n depth^2). Source: do Carmo 1992, chapter 4, proposition 3.1.
double sectional_curvature(const Mechanism& mechanism, Workspace& workspace, const VectorIn& q,
                           const VectorIn& x, const VectorIn& y) noexcept;

/// Riemann's tensor, n^4 numbers: (i, j, k, l) = <R(E_k, E_l) E_j, E_i>.
class RiemannTensor {
 public:
  /// Not real-time: allocates (8 MB for n = 32).
  explicit RiemannTensor(const Mechanism& mechanism);

  double operator()(int i, int j, int k, int l) const noexcept { return entry_[index(i, j, k, l)]; }

 private:
  friend bool riemann_tensor(const Mechanism& mechanism, Workspace& workspace, const VectorIn& q,
                             RiemannTensor& result) noexcept;
  Eigen::Index index(int i, int j, int k, int l) const noexcept {
    return ((static_cast<Eigen::Index>(i) * size_ + j) * size_ + k) * size_ + l;
  }
  Eigen::Index size_;
  Eigen::VectorXd entry_;
};

/// Fills `result` for q [nq]; false if M(q) is singular to working precision. Allocates nothing;
/// O(n^4): for each pair (j, k) the normal accelerations II(E_j, E_k), and of these the products
/// with every II(E_i, E_l).
bool riemann_tensor(const Mechanism& mechanism, Workspace& workspace, const VectorIn& q,
                    RiemannTensor& result) noexcept;

}  // namespace geodesic::control
