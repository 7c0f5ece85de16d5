// A mechanical system given by its Lagrangian, a C++ function of (q, v) on a chart: metric,
// connection, momentum, energy and equations of motion by automatic differentiation. Constraints
// are in constrained_lagrangian.hpp, symmetries in symmetry.hpp, other charts in chart_change.hpp.
#pragma once

#include <optional>
#include <utility>

#include "control/geometry/chart_metric.hpp"
#include "control/geometry/jet_vector.hpp"

namespace geodesic::control {

/// The Lagrangian of a natural system, T - V with T = v' M(q) v / 2, from its metric and potential.
/// @tparam Metric     callable, q (N of any scalar S) -> N x N of S, symmetric [kg·m², kg]
/// @tparam Potential  callable, q -> S [J]
template <class Metric, class Potential>
struct NaturalLagrangian {
  Metric metric;
  Potential potential;

  template <class S, int N>
  S operator()(const Eigen::Matrix<S, N, 1>& q, const Eigen::Matrix<S, N, 1>& v) const {
    const Eigen::Matrix<S, N, N> m = metric(q);
    const Eigen::Matrix<S, N, 1> p = m * v;
    return 0.5 * v.dot(p) - potential(q);
  }
};

/// What the Lagrangian L(q, v) [J] says of a system with N coordinates. L is a callable
///
///     template <class S> S operator()(const Eigen::Matrix<S, N, 1>& q,
///                                     const Eigen::Matrix<S, N, 1>& v) const
///
/// that computes in S what it computes in double (see jet.hpp); L may nest in others, since a
/// Lagrangian is one itself. Any regular L will do for momentum, energy, metric at (q, v),
/// euler_lagrange() and forward_dynamics(). The connection and the curvature are those of
/// L = T + A(q) v - V(q) with T quadratic in v: they take the metric at rest, and such an L may
/// hold the gyroscopic term A.
///
/// Every function evaluates L afresh, in chart coordinates and SI units, and allocates nothing if L
/// does not; costs in evaluations of L are given for those that make a habit of it. An optional is
/// empty where the metric is singular to working precision (or L not finite).
///
/// Source: Bullo, Lewis 2005, "Geometric Control of Mechanical Systems", chapter 4; derivatives by
/// Griewank, Walther 2008.
template <int N, class L>
class Lagrangian {
 public:
  using Vector = ChartVector<N>;
  using Matrix = ChartMatrix<N>;

  explicit Lagrangian(L function) : function_(std::move(function)) {}

  template <class S>
  S operator()(const Eigen::Matrix<S, N, 1>& q, const Eigen::Matrix<S, N, 1>& v) const {
    return function_(q, v);
  }

  /// Legendre transform p = dL/dv, a covector.
  Vector momentum(const Vector& q, const Vector& v) const {
    Vector p;
    for (int i = 0; i < N; ++i) {
      p[i] = function_(still(q), vary(v, i)).rate;
    }
    return p;
  }

  /// p v - L: T + V of a natural system, conserved by free motion of any.
  double energy(const Vector& q, const Vector& v) const {
    return momentum(q, v).dot(v) - function_(q, v);
  }

  /// V(q) = -L(q, 0).
  double potential_energy(const Vector& q) const { return -function_(q, Vector(Vector::Zero())); }

  /// energy() - potential_energy(): T of a natural system, gyroscopic terms or not.
  double kinetic_energy(const Vector& q, const Vector& v) const {
    return energy(q, v) - potential_energy(q);
  }

  /// dV, a covector: what gravity and springs ask of the motors.
  Vector potential_differential(const Vector& q) const { return -slope(q, Vector::Zero()); }

  /// grad V = M^-1 dV, a vector: minus the acceleration of the system let go at rest.
  std::optional<Vector> potential_gradient(const Vector& q) const {
    const auto inverse = invert<N>(metric(q));
    if (!inverse) {
      return std::nullopt;
    }
    return *inverse * potential_differential(q);
  }

  /// Hessian of L in v. N (N + 1) / 2 evaluations.
  Matrix metric(const Vector& q, const Vector& v) const {
    const auto q2 = still(still(q));
    Matrix m;
    for (int i = 0; i < N; ++i) {
      const auto v1 = vary(v, i);
      for (int j = 0; j <= i; ++j) {
        m(i, j) = m(j, i) = function_(q2, vary(v1, j)).rate.rate;
      }
    }
    return m;
  }

  /// At rest: the M(q) of a natural system.
  Matrix metric(const Vector& q) const { return metric(q, Vector::Zero()); }

  /// M and dM/dq at rest. O(N^3) evaluations.
  ChartMetric<N> chart_metric(const Vector& q) const {
    ChartMetric<N> result;
    result.metric = metric(q);
    const Vector rest = Vector::Zero();
    for (int k = 0; k < N; ++k) {
      const auto q3 = still(still(vary(q, k)));
      for (int i = 0; i < N; ++i) {
        const auto v2 = vary(still(rest), i);
        for (int j = 0; j <= i; ++j) {
          const double derivative = function_(q3, vary(v2, j)).rate.rate.rate;
          result.derivative(k, i, j) = result.derivative(k, j, i) = derivative;
        }
      }
    }
    return result;
  }

  /// (k, l, i, j) = d2 M_ij / dq_k dq_l at rest. O(N^4) evaluations.
  ChartTensor4<N> metric_second_derivative(const Vector& q) const {
    ChartTensor4<N> d;
    const Vector rest = Vector::Zero();
    for (int k = 0; k < N; ++k) {
      for (int l = 0; l <= k; ++l) {
        const auto q4 = still(still(vary(vary(q, k), l)));
        for (int i = 0; i < N; ++i) {
          const auto v3 = vary(still(still(rest)), i);
          for (int j = 0; j <= i; ++j) {
            const double second = function_(q4, vary(v3, j)).rate.rate.rate.rate;
            d(k, l, i, j) = d(k, l, j, i) = d(l, k, i, j) = d(l, k, j, i) = second;
          }
        }
      }
    }
    return d;
  }

  /// Gamma_i,jk; see chart_metric.hpp for both kinds. O(N^3) evaluations.
  ChartTensor3<N> christoffel_first_kind(const Vector& q) const {
    return control::christoffel_first_kind(chart_metric(q));
  }

  /// Gamma^i_jk. O(N^3) evaluations.
  std::optional<ChartTensor3<N>> christoffel_second_kind(const Vector& q) const {
    const ChartMetric<N> at = chart_metric(q);
    const auto inverse = invert<N>(at.metric);
    if (!inverse) {
      return std::nullopt;
    }
    return control::christoffel_second_kind(*inverse, control::christoffel_first_kind(at));
  }

  /// C with C v the Coriolis covector and dM/dt = C + C'. O(N^3) evaluations.
  Matrix coriolis_matrix(const Vector& q, const Vector& v) const {
    return control::coriolis_matrix(christoffel_first_kind(q), v);
  }

  /// Coriolis covector C(q, v) v, without C: the part of the inertial forces that is even in v.
  /// O(N) evaluations.
  Vector coriolis(const Vector& q, const Vector& v) const {
    const Vector rest = Vector::Zero();
    const Vector even = euler_lagrange(q, v, rest) + euler_lagrange(q, -v, rest);
    return 0.5 * even - euler_lagrange(q, rest, rest);
  }

  /// G with G v the gyroscopic covector of the term A(q) v: G_ij = dA_i/dq_j - dA_j/dq_i, skew;
  /// zero for T - V. N (N - 1) / 2 pairs of evaluations.
  Matrix gyroscopic_matrix(const Vector& q) const {
    const Vector rest = Vector::Zero();
    const auto mixed = [&](int i, int j) {
      return function_(still(vary(q, j)), vary(still(rest), i)).rate.rate;
    };
    Matrix g = Matrix::Zero();
    for (int i = 0; i < N; ++i) {
      for (int j = 0; j < i; ++j) {
        g(i, j) = mixed(i, j) - mixed(j, i);
        g(j, i) = -g(i, j);
      }
    }
    return g;
  }

  /// Inverse dynamics: the covector d/dt dL/dv - dL/dq along a motion with velocity v and
  /// acceleration a, which is M a + C v + G v + dV for a natural (gyroscopic) system. Free motion
  /// makes it zero. 2 N evaluations.
  Vector euler_lagrange(const Vector& q, const Vector& v, const Vector& a) const {
    const auto q_moving = still(along(q, v));
    const auto v_moving = along(v, a);
    Vector tau;
    for (int i = 0; i < N; ++i) {
      tau[i] = function_(q_moving, vary(v_moving, i)).rate.rate;
    }
    return tau - slope(q, v);
  }

  /// The acceleration that makes euler_lagrange() equal tau [N·m, N]; any regular L.
  std::optional<Vector> forward_dynamics(const Vector& q, const Vector& v,
                                         const Vector& tau) const {
    const auto inverse = invert<N>(metric(q, v));
    if (!inverse) {
      return std::nullopt;
    }
    return *inverse * (tau - euler_lagrange(q, v, Vector::Zero()));
  }

  /// R_ijkl; conventions in chart_metric.hpp. O(N^4) evaluations.
  std::optional<ChartTensor4<N>> riemann_curvature(const Vector& q) const {
    const ChartMetric<N> at = chart_metric(q);
    const auto inverse = invert<N>(at.metric);
    if (!inverse) {
      return std::nullopt;
    }
    const auto first = control::christoffel_first_kind(at);
    return control::riemann_curvature(metric_second_derivative(q), first,
                                      control::christoffel_second_kind(*inverse, first));
  }

  /// Sectional curvature of the plane that u and w span. O(N^4) evaluations.
  std::optional<double> sectional_curvature(const Vector& q, const Vector& u,
                                            const Vector& w) const {
    const auto riemann = riemann_curvature(q);
    if (!riemann) {
      return std::nullopt;
    }
    return control::sectional_curvature<N>(metric(q), *riemann, u, w);
  }

 private:
  /// dL/dq.
  Vector slope(const Vector& q, const Vector& v) const {
    Vector result;
    for (int i = 0; i < N; ++i) {
      result[i] = function_(vary(q, i), still(v)).rate;
    }
    return result;
  }

  L function_;
};

/// lagrangian<3>(L): what L says of a system with 3 coordinates.
template <int N, class L>
Lagrangian<N, L> lagrangian(L function) {
  return Lagrangian<N, L>(std::move(function));
}

/// From metric and potential.
template <int N, class Metric, class Potential>
auto natural_lagrangian(Metric metric, Potential potential) {
  return lagrangian<N>(
      NaturalLagrangian<Metric, Potential>{std::move(metric), std::move(potential)});
}

}  // namespace geodesic::control
