// A Lagrangian system whose velocities are restricted, A(q) v = 0: rolling wheels, blades, closed
// loops. Forces of constraint, accelerations and projections; free systems are in lagrangian.hpp.
#pragma once

#include <optional>
#include <utility>

#include "control/geometry/lagrangian.hpp"

namespace geodesic::control {

/// The velocity constraint dh(q) v = 0 of a holonomic one, h(q) = constant.
/// @tparam H  callable, q (N of any scalar S) -> K of S
template <int K, class H>
struct Differential {
  H function;

  template <class S, int N>
  Eigen::Matrix<S, K, N> operator()(const Eigen::Matrix<S, N, 1>& q) const {
    Eigen::Matrix<S, K, N> result;
    for (int i = 0; i < N; ++i) {
      const Eigen::Matrix<Jet<S>, K, 1> moved = function(vary(q, i));
      result.col(i) = rates(moved);
    }
    return result;
  }
};

template <int K, class H>
Differential<K, H> differential(H function) {
  return {std::move(function)};
}

/// The Lagrange-d'Alembert principle: Euler-Lagrange equations with a force of constraint A' lambda
/// that does no work on velocities with A v = 0, the distribution D. Holonomic or not.
///
/// All functions allocate nothing if L and A do not. An optional is empty where M or A M^-1 A' is
/// singular to working precision: a constraint that repeats another has no force of its own. The
/// constraint is kept in its rate: integrated over long times, q and v drift off by the
/// integrator's error, and projection() takes v back.
///
/// Source: Bullo, Lewis 2005, section 4.5.
/// @tparam A  callable, q (N of any scalar S) -> K x N of S
template <int N, int K, class L, class A>
class ConstrainedLagrangian {
 public:
  using Vector = ChartVector<N>;
  using Matrix = ChartMatrix<N>;
  using Rows = Eigen::Matrix<double, K, N>;
  using Multipliers = Eigen::Matrix<double, K, 1>;

  struct Motion {
    Vector acceleration;
    Multipliers
        multipliers;  ///< lambda; the force of constraint is the covector A' lambda [N·m, N]
  };

  ConstrainedLagrangian(Lagrangian<N, L> free, A constraint)
      : free_(std::move(free)), constraint_(std::move(constraint)) {}

  /// The same system without its constraint.
  const Lagrangian<N, L>& free() const { return free_; }

  Rows constraint(const Vector& q) const { return constraint_(q); }

  /// dA/dt v, along v.
  Multipliers constraint_drift(const Vector& q, const Vector& v) const {
    const Eigen::Matrix<Jet<>, K, 1> moved = constraint_(along(q, v)) * still(v);
    return rates(moved);
  }

  /// The acceleration that tau [N·m, N] and the constraint cause, and the constraint's force:
  /// euler_lagrange(q, v, a) = tau + A' lambda and A a + dA/dt v = 0. v must obey the constraint.
  std::optional<Motion> forward_dynamics(const Vector& q, const Vector& v,
                                         const Vector& tau) const {
    const auto parts = factor(q, v);
    if (!parts) {
      return std::nullopt;
    }
    const Vector free = parts->inverse_metric * (tau - free_.euler_lagrange(q, v, Vector::Zero()));
    const Multipliers lambda =
        -parts->inverse_reduced * (parts->rows * free + constraint_drift(q, v));
    return Motion{free + parts->inverse_metric * parts->rows.transpose() * lambda, lambda};
  }

  /// P_D, which takes a velocity to the nearest in D by the metric at rest: P P = P, A P = 0, M P
  /// symmetric. Its transpose takes a force to the part of it that the constraint lets through.
  std::optional<Matrix> projection(const Vector& q) const {
    const auto parts = factor(q, Vector::Zero());
    if (!parts) {
      return std::nullopt;
    }
    return Matrix::Identity() -
           parts->inverse_metric * parts->rows.transpose() * parts->inverse_reduced * parts->rows;
  }

 private:
  struct Parts {
    Rows rows;
    Matrix inverse_metric;
    Eigen::Matrix<double, K, K> inverse_reduced;  ///< (A M^-1 A')^-1
  };

  std::optional<Parts> factor(const Vector& q, const Vector& v) const {
    const auto inverse = invert<N>(free_.metric(q, v));
    if (!inverse) {
      return std::nullopt;
    }
    const Rows rows = constraint_(q);
    const auto reduced = invert<K>(rows * *inverse * rows.transpose());
    if (!reduced) {
      return std::nullopt;
    }
    return Parts{rows, *inverse, *reduced};
  }

  Lagrangian<N, L> free_;
  A constraint_;
};

/// constrained<2>(system, A): the system under 2 velocity constraints A(q) v = 0.
template <int K, int N, class L, class A>
ConstrainedLagrangian<N, K, L, A> constrained(Lagrangian<N, L> free, A constraint) {
  return {std::move(free), std::move(constraint)};
}

}  // namespace geodesic::control
