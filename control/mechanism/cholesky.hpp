// Cholesky factorisation of a small dense matrix in place, without allocation, and its solve.
// (Eigen's own may allocate work space from a certain size on.)
#pragma once

#include <Eigen/Core>

namespace geodesic::control {

/// Replaces the lower triangle of symmetric a [n x n] by L with L L' = a; the rest is untouched.
/// @return false if a is not positive definite to working precision; a is then spoilt.
/// Real-time, O(n^3). Source: Golub, Van Loan 2013, algorithm 4.2.1.
bool cholesky_factor(Eigen::MatrixXd& a) noexcept;

/// Replaces x [n] by the solution of (L L') y = x. Real-time, O(n^2).
void cholesky_solve(const Eigen::MatrixXd& l, Eigen::Ref<Eigen::VectorXd> x) noexcept;

}  // namespace geodesic::control
