// Implements christoffel.hpp.
#include "control/mechanism/christoffel.hpp"

#include <cassert>

#include "control/mechanism/coriolis.hpp"
#include "control/mechanism/metric.hpp"

namespace geodesic::control {

Christoffel::Christoffel(const Mechanism& mechanism)
    : slice_(static_cast<std::size_t>(mechanism.dof()),
             Eigen::MatrixXd::Zero(mechanism.dof(), mechanism.dof())) {}

void christoffel_symbols(const Mechanism& mechanism, Workspace& workspace, const VectorIn& q,
                         Christoffel& result) noexcept {
  assert(result.slice_.size() == static_cast<std::size_t>(mechanism.dof()));
  Eigen::VectorXd& v = workspace.unit_velocity;
  v.setZero();
  for (std::size_t k = 0; k < result.slice_.size(); ++k) {
    v[static_cast<Eigen::Index>(k)] = 1.0;
    result.slice_[k] = coriolis_matrix(mechanism, workspace, q, v);
    v[static_cast<Eigen::Index>(k)] = 0.0;
  }
}

bool christoffel_second_kind(const Mechanism& mechanism, Workspace& workspace, const VectorIn& q,
                             Christoffel& result) noexcept {
  if (!workspace.cholesky.factor(metric(mechanism, workspace, q))) {
    return false;
  }
  christoffel_symbols(mechanism, workspace, q, result);
  for (Eigen::MatrixXd& slice : result.slice_) {
    for (Eigen::Index j = 0; j < slice.cols(); ++j) {
      workspace.cholesky.solve(slice.col(j));
    }
  }
  return true;
}

void metric_derivative(const Mechanism& mechanism, Workspace& workspace, const VectorIn& q,
                       Christoffel& result) noexcept {
  christoffel_symbols(mechanism, workspace, q, result);
  for (Eigen::MatrixXd& slice : result.slice_) {
    for (Eigen::Index j = 0; j < slice.cols(); ++j) {
      for (Eigen::Index i = 0; i <= j; ++i) {
        slice(i, j) = slice(j, i) = slice(i, j) + slice(j, i);
      }
    }
  }
}

}  // namespace geodesic::control
