// Implements elimination.hpp.
#include "control/mechanism/elimination.hpp"

#include <cassert>
#include <cmath>
#include <utility>

namespace geodesic::control {

bool eliminate(Eigen::MatrixXd& a, std::span<Eigen::Index> pivots) noexcept {
  constexpr double kSingular = 1e-14;
  const Eigen::Index n = a.rows();
  assert(a.cols() == n && pivots.size() == static_cast<std::size_t>(n));
  const double largest = n > 0 ? a.cwiseAbs().maxCoeff() : 0.0;
  for (Eigen::Index k = 0; k < n; ++k) {
    Eigen::Index best = k;
    for (Eigen::Index i = k + 1; i < n; ++i) {
      if (std::abs(a(i, k)) > std::abs(a(best, k))) best = i;
    }
    pivots[static_cast<std::size_t>(k)] = best;
    if (!(std::abs(a(best, k)) > kSingular * largest)) return false;
    if (best != k) {
      for (Eigen::Index j = 0; j < n; ++j) {
        std::swap(a(k, j), a(best, j));
      }
    }
    for (Eigen::Index i = k + 1; i < n; ++i) {
      a(i, k) /= a(k, k);
      for (Eigen::Index j = k + 1; j < n; ++j) {
        a(i, j) -= a(i, k) * a(k, j);
      }
    }
  }
  return true;
}

void back_substitute(const Eigen::MatrixXd& lu, std::span<const Eigen::Index> pivots,
                     Eigen::VectorXd& x) noexcept {
  const Eigen::Index n = lu.rows();
  assert(x.size() == n);
  for (Eigen::Index k = 0; k < n; ++k) {
    std::swap(x[k], x[pivots[static_cast<std::size_t>(k)]]);
  }
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j < i; ++j) {
      x[i] -= lu(i, j) * x[j];
    }
  }
  for (Eigen::Index i = n; i-- > 0;) {
    for (Eigen::Index j = i + 1; j < n; ++j) {
      x[i] -= lu(i, j) * x[j];
    }
    x[i] /= lu(i, i);
  }
}

int determinant_sign(const Eigen::MatrixXd& lu, std::span<const Eigen::Index> pivots) noexcept {
  int sign = 1;
  for (Eigen::Index k = 0; k < lu.rows(); ++k) {
    const bool exchanged = pivots[static_cast<std::size_t>(k)] != k;
    if ((lu(k, k) < 0.0) != exchanged) sign = -sign;
  }
  return sign;
}

}  // namespace geodesic::control
