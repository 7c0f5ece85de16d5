// Other coordinates for the same motion, x = x(q): how velocities, covectors, the metric, the
// connection and the curvature change their numbers, at a point; and a Lagrangian written in them.
#pragma once

#include <optional>
#include <utility>

#include "control/geometry/chart_metric.hpp"
#include "control/geometry/jet_vector.hpp"

namespace geodesic::control {

/// A change of coordinates x(q) at one point, by its first two derivatives. "Old" are the numbers
/// in q, "new" those in x. Arrays in, arrays out: they may come from a Lagrangian, or a mechanism
/// whose v is dq/dt. Allocates nothing.
/// Source: Bullo, Lewis 2005, chapter 3 (connections: section 3.8).
template <int N>
struct ChartChange {
  using Vector = ChartVector<N>;
  using Matrix = ChartMatrix<N>;

  Matrix jacobian;          ///< J^a_i = dx^a/dq_i
  Matrix inverse_jacobian;  ///< dq/dx
  ChartTensor3<N> hessian;  ///< (a, j, k) = d2 x^a / dq_j dq_k

  Vector velocity(const Vector& old) const { return jacobian * old; }

  /// Of a motion with velocity v: J a + H(v, v). An acceleration is no vector.
  Vector acceleration(const Vector& v, const Vector& old) const {
    return jacobian * old + hessian(v, v);
  }

  /// Momentum or torque: J^-T p, so that <p, v> stays.
  Vector covector(const Vector& old) const { return inverse_jacobian.transpose() * old; }

  /// J^-T M J^-1, so that v' M v stays.
  Matrix metric(const Matrix& old) const {
    return inverse_jacobian.transpose() * old * inverse_jacobian;
  }

  /// Second kind: (J Gamma - H)(J^-1 ., J^-1 .). The inhomogeneous H makes a flat connection's
  /// zeros the centrifugal terms of curved coordinates.
  ChartTensor3<N> christoffel_second_kind(const ChartTensor3<N>& old) const {
    ChartTensor3<N> result;
    for (int a = 0; a < N; ++a) {
      Matrix numbers = -hessian.slice[static_cast<std::size_t>(a)];
      for (int i = 0; i < N; ++i) {
        numbers += jacobian(a, i) * old.slice[static_cast<std::size_t>(i)];
      }
      result.slice[static_cast<std::size_t>(a)] = metric(numbers);
    }
    return result;
  }

  /// First kind: the same with the index lowered by the metric.
  /// @param old_metric  M in old coordinates
  ChartTensor3<N> christoffel_first_kind(const ChartTensor3<N>& old,
                                         const Matrix& old_metric) const {
    // Row i of this matrix is the old metric's, applied to dq/dx^d: M_ij K^j_d.
    const Matrix lowered = inverse_jacobian.transpose() * old_metric * inverse_jacobian;
    ChartTensor3<N> result;
    for (int a = 0; a < N; ++a) {
      Matrix numbers = Matrix::Zero();
      for (int i = 0; i < N; ++i) {
        numbers += inverse_jacobian(i, a) * old.slice[static_cast<std::size_t>(i)] -
                   lowered(a, i) * hessian.slice[static_cast<std::size_t>(i)];
      }
      result.slice[static_cast<std::size_t>(a)] = metric(numbers);
    }
    return result;
  }

  /// A tensor with four indices below, such as the curvature: J^-1 on every one.
  ChartTensor4<N> covariant(const ChartTensor4<N>& old) const {
    const auto at = [](int i) { return static_cast<std::size_t>(i); };
    ChartTensor4<N> inner;  // the last two indices are new
    for (int i = 0; i < N; ++i) {
      for (int j = 0; j < N; ++j) {
        inner.slice[at(i)].slice[at(j)] = metric(old.slice[at(i)].slice[at(j)]);
      }
    }
    ChartTensor4<N> result;
    for (int a = 0; a < N; ++a) {
      for (int b = 0; b < N; ++b) {
        Matrix numbers = Matrix::Zero();
        for (int i = 0; i < N; ++i) {
          for (int j = 0; j < N; ++j) {
            numbers +=
                inverse_jacobian(i, a) * inverse_jacobian(j, b) * inner.slice[at(i)].slice[at(j)];
          }
        }
        result.slice[at(a)].slice[at(b)] = numbers;
      }
    }
    return result;
  }

  /// The way back, q(x), at the same point.
  ChartChange inverse() const {
    ChartChange back{inverse_jacobian, jacobian, {}};
    for (int i = 0; i < N; ++i) {
      Matrix numbers = Matrix::Zero();
      for (int a = 0; a < N; ++a) {
        numbers -= inverse_jacobian(i, a) * hessian.slice[static_cast<std::size_t>(a)];
      }
      back.hessian.slice[static_cast<std::size_t>(i)] = metric(numbers);
    }
    return back;
  }
};

/// The change x(q) at q; none where its Jacobian is singular to working precision.
/// @param map  callable, q (N of any scalar S) -> x, N of S
template <int N, class Map>
std::optional<ChartChange<N>> chart_change(const Map& map, const ChartVector<N>& q) {
  ChartChange<N> result;
  for (int j = 0; j < N; ++j) {
    const Eigen::Matrix<Jet<>, N, 1> moved = map(vary(q, j));
    result.jacobian.col(j) = rates(moved);
    for (int k = 0; k <= j; ++k) {
      const Eigen::Matrix<Jet<Jet<>>, N, 1> twice = map(vary(vary(q, j), k));
      for (int a = 0; a < N; ++a) {
        result.hessian(a, j, k) = result.hessian(a, k, j) = twice[a].rate.rate;
      }
    }
  }
  const auto inverse = invert<N>(result.jacobian);
  if (!inverse) {
    return std::nullopt;
  }
  result.inverse_jacobian = *inverse;
  return result;
}

/// The Lagrangian L(q, v) written in other coordinates x, given q(x): L(q(x), dq(x) x'). It is a
/// Lagrangian as any other, with the same values: T and V are invariant.
/// @tparam L    as lagrangian.hpp wants it    @tparam Map  callable, x (N of any scalar S) -> q
template <class L, class Map>
struct LagrangianInChart {
  L old;
  Map old_from_new;

  template <class S, int N>
  S operator()(const Eigen::Matrix<S, N, 1>& x, const Eigen::Matrix<S, N, 1>& x_rate) const {
    const Eigen::Matrix<Jet<S>, N, 1> q = old_from_new(along(x, x_rate));
    return old(values(q), rates(q));
  }
};

}  // namespace geodesic::control
