// Implements cholesky.hpp.
#include "control/mechanism/cholesky.hpp"

#include <cmath>

namespace geodesic::control {

bool cholesky_factor(Eigen::MatrixXd& a) noexcept {
  // A pivot this small against its diagonal entry is what rounding leaves of zero.
  constexpr double kSingular = 1e-14;
  const Eigen::Index n = a.rows();
  for (Eigen::Index j = 0; j < n; ++j) {
    const double diagonal = a(j, j);
    for (Eigen::Index k = 0; k < j; ++k) {
      for (Eigen::Index i = j; i < n; ++i) {
        a(i, j) -= a(j, k) * a(i, k);
      }
    }
    if (!(a(j, j) > kSingular * diagonal)) {
      return false;
    }
    const double root = std::sqrt(a(j, j));
    for (Eigen::Index i = j; i < n; ++i) {
      a(i, j) /= root;
    }
  }
  return true;
}

void cholesky_solve(const Eigen::MatrixXd& l, Eigen::Ref<Eigen::VectorXd> x) noexcept {
  const Eigen::Index n = l.rows();
  for (Eigen::Index j = 0; j < n; ++j) {
    x[j] /= l(j, j);
    for (Eigen::Index i = j + 1; i < n; ++i) {
      x[i] -= l(i, j) * x[j];
    }
  }
  for (Eigen::Index j = n; j-- > 0;) {
    for (Eigen::Index i = j + 1; i < n; ++i) {
      x[j] -= l(i, j) * x[i];
    }
    x[j] /= l(j, j);
  }
}

}  // namespace geodesic::control
