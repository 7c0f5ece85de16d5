// The coefficients of the Levi-Civita connection as tables: of the first kind, of the second kind,
// and the derivatives of the metric. What they mean on spherical and free joints is in
// connection.hpp, which also has the cheaper covectors.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "control/mechanism/mechanism.hpp"
#include "control/mechanism/workspace.hpp"

namespace geodesic::control {

/// n x n x n numbers with three indices.
class Christoffel {
 public:
  /// Not real-time: allocates.
  explicit Christoffel(const Mechanism& mechanism);

  double operator()(int i, int j, int k) const noexcept {
    return slice_[static_cast<std::size_t>(k)](i, j);
  }
  /// The matrix of (i, j) for one k.
  const Eigen::MatrixXd& slice(int k) const noexcept { return slice_[static_cast<std::size_t>(k)]; }

 private:
  friend void christoffel_symbols(const Mechanism& mechanism, Workspace& workspace,
                                  const VectorIn& q, Christoffel& result) noexcept;
  friend bool christoffel_second_kind(const Mechanism& mechanism, Workspace& workspace,
                                      const VectorIn& q, Christoffel& result) noexcept;
  friend void metric_derivative(const Mechanism& mechanism, Workspace& workspace, const VectorIn& q,
                                Christoffel& result) noexcept;
  std::vector<Eigen::MatrixXd> slice_;  ///< one matrix (i, j) for every k
};

/// First kind: (i, j, k) = <nabla_Ek Ej, Ei>, covariant in all three; with coordinates
/// (dM_ij/dq_k + dM_ik/dq_j - dM_jk/dq_i) / 2, symmetric in j and k; with spherical and free joints
/// the difference of (i, j, k) and (i, k, j) is <[Ek, Ej], Ei>. The Coriolis matrix and covector
/// are made of these: C_ij = sum over k of (i, j, k) v_k.
/// @param q  size nq. Overwrites the result of coriolis_matrix(). Allocates nothing; O(n^2 depth):
/// C is linear in v, so each unit velocity gives a slice.
void christoffel_symbols(const Mechanism& mechanism, Workspace& workspace, const VectorIn& q,
                         Christoffel& result) noexcept;

/// Second kind: nabla_Ek Ej = sum over i of (i, j, k) E_i, the first kind with its first index
/// raised by M^-1: what the acceleration of a geodesic is made of, dv_i/dt = -sum of (i, j, k) v_j
/// v_k. The numbers do not change when the metric is multiplied by a constant; those of the first
/// kind do.
/// @return false if M(q) is singular to working precision. Overwrites the results of metric() and
/// coriolis_matrix(). Allocates nothing; O(n^2 depth^2).
bool christoffel_second_kind(const Mechanism& mechanism, Workspace& workspace, const VectorIn& q,
                             Christoffel& result) noexcept;

/// dM/dq: (i, j, k) = E_k(M_ij), which is dM_ij/dq_k for joints with one degree of freedom; along a
/// motion, dM/dt = sum over k of it times v_k. Symmetric in i and j to the bit. From the
/// connection: E_k<Ei, Ej> = <nabla_Ek Ei, Ej> + <Ei, nabla_Ek Ej>. Overwrites the result of
/// coriolis_matrix(). Allocates nothing; O(n^2 depth).
void metric_derivative(const Mechanism& mechanism, Workspace& workspace, const VectorIn& q,
                       Christoffel& result) noexcept;

}  // namespace geodesic::control
