// Square systems without symmetry, solved in place by elimination with partial pivoting. Symmetric
// ones are in cholesky.hpp.
#pragma once

#include <Eigen/Core>
#include <span>

namespace geodesic::control {

/// Replaces `a` by its factors L (unit diagonal, not stored) and U, rows exchanged as `pivots` says
/// [one a row]. False if a pivot is nothing beside its column's largest entry. Allocates nothing.
/// Source: Golub, Van Loan 2013, algorithm 3.4.1.
bool eliminate(Eigen::MatrixXd& a, std::span<Eigen::Index> pivots) noexcept;

/// Solves with what eliminate() left; x [n] goes in as the right-hand side. Allocates nothing.
void back_substitute(const Eigen::MatrixXd& lu, std::span<const Eigen::Index> pivots,
                     Eigen::VectorXd& x) noexcept;

/// Sign of the determinant of what eliminate() factored: 1 or -1.
int determinant_sign(const Eigen::MatrixXd& lu, std::span<const Eigen::Index> pivots) noexcept;

}  // namespace geodesic::control
