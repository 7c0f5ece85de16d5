// How the metric changes over the configuration space: Coriolis matrix, rate of the metric,
// Christoffel symbols.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "control/mechanism/mechanism.hpp"
#include "control/mechanism/workspace.hpp"

namespace geodesic::control {

/// C(q, v) made of Christoffel symbols: dM/dt = C + C' along v, and C v is the Coriolis covector.
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

/// Christoffel symbols of the first kind, n x n x n numbers.
class Christoffel {
 public:
  explicit Christoffel(const Mechanism& mechanism);

  /// (dM_ij/dq_k + dM_ik/dq_j - dM_jk/dq_i) / 2; with a floating base the coefficients of C in the
  /// base's local twist, so that C_ij = sum over k of (i, j, k) v_k holds everywhere.
  double operator()(int i, int j, int k) const noexcept {
    return slice_[static_cast<std::size_t>(k)](i, j);
  }

 private:
  friend void christoffel_symbols(const Mechanism& mechanism, Workspace& workspace,
                                  const VectorIn& q, Christoffel& result) noexcept;
  std::vector<Eigen::MatrixXd> slice_;  ///< one matrix (i, j) for every k
};

/// Fills `result` for q [nq]. Overwrites the result of coriolis_matrix(). Allocates nothing;
/// O(n^2 depth): C is linear in v, so each unit velocity gives a slice.
void christoffel_symbols(const Mechanism& mechanism, Workspace& workspace, const VectorIn& q,
                         Christoffel& result) noexcept;

}  // namespace geodesic::control
