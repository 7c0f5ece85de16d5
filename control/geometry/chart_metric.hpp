// A Riemannian metric in a chart of n coordinates, at one point: its Levi-Civita connection and its
// curvature, from arrays of numbers. Where the numbers come from is not its business: a Lagrangian
// (lagrangian.hpp), a mechanism, a formula.
#pragma once

#include <Eigen/LU>
#include <array>
#include <cstddef>
#include <optional>

namespace geodesic::control {

template <int N>
using ChartVector = Eigen::Matrix<double, N, 1>;
template <int N>
using ChartMatrix = Eigen::Matrix<double, N, N>;

/// Numbers (i, j, k) as one matrix (j, k) for every i.
template <int N>
struct ChartTensor3 {
  std::array<ChartMatrix<N>, static_cast<std::size_t>(N)> slice;

  double& operator()(int i, int j, int k) { return slice[static_cast<std::size_t>(i)](j, k); }
  double operator()(int i, int j, int k) const { return slice[static_cast<std::size_t>(i)](j, k); }

  /// Of the function's numbers, e.g. a mechanism's Christoffel.
  template <class Function>
  static ChartTensor3 of(const Function& number) {
    ChartTensor3 result;
    for (int i = 0; i < N; ++i) {
      for (int j = 0; j < N; ++j) {
        for (int k = 0; k < N; ++k) {
          result(i, j, k) = number(i, j, k);
        }
      }
    }
    return result;
  }

  /// Sum over j, k of (i, j, k) u_j w_k.
  ChartVector<N> operator()(const ChartVector<N>& u, const ChartVector<N>& w) const {
    ChartVector<N> result;
    for (int i = 0; i < N; ++i) {
      result[i] = u.dot(slice[static_cast<std::size_t>(i)] * w);
    }
    return result;
  }
};

/// Numbers (i, j, k, l).
template <int N>
struct ChartTensor4 {
  std::array<ChartTensor3<N>, static_cast<std::size_t>(N)> slice;

  double& operator()(int i, int j, int k, int l) {
    return slice[static_cast<std::size_t>(i)](j, k, l);
  }
  double operator()(int i, int j, int k, int l) const {
    return slice[static_cast<std::size_t>(i)](j, k, l);
  }
};

/// The metric's numbers and their first derivatives.
template <int N>
struct ChartMetric {
  ChartMatrix<N> metric;       ///< M_ij, symmetric
  ChartTensor3<N> derivative;  ///< (k, i, j) = dM_ij/dq_k
};

/// Inverse of a matrix, a metric of any signature or a Jacobian; none if it is singular to working
/// precision or not finite.
template <int N>
std::optional<ChartMatrix<N>> invert(const ChartMatrix<N>& matrix) {
  const Eigen::FullPivLU<ChartMatrix<N>> factor(matrix);
  if (!matrix.allFinite() || !factor.isInvertible()) {
    return std::nullopt;
  }
  return factor.solve(ChartMatrix<N>::Identity());
}

/// First kind: Gamma_i,jk = (dM_ij/dq_k + dM_ik/dq_j - dM_jk/dq_i) / 2, all indices below,
/// symmetric in j and k; the Coriolis covector is c_i = Gamma_i,jk v_j v_k. No tensor: see
/// chart_change.hpp.
template <int N>
ChartTensor3<N> christoffel_first_kind(const ChartMetric<N>& at) {
  const auto& d = at.derivative;
  return ChartTensor3<N>::of(
      [&](int i, int j, int k) { return 0.5 * (d(k, i, j) + d(j, i, k) - d(i, j, k)); });
}

/// Second kind: Gamma^i_jk = sum over l of (M^-1)^il Gamma_l,jk, the coefficients of the
/// Levi-Civita connection; the geodesic acceleration is -Gamma^i_jk v^j v^k. Source: Bullo, Lewis
/// 2005, "Geometric Control of Mechanical Systems", section 3.8.
template <int N>
ChartTensor3<N> christoffel_second_kind(const ChartMatrix<N>& inverse_metric,
                                        const ChartTensor3<N>& first_kind) {
  ChartTensor3<N> result;
  for (int j = 0; j < N; ++j) {
    for (int k = 0; k < N; ++k) {
      for (int i = 0; i < N; ++i) {
        result(i, j, k) = 0.0;
        for (int l = 0; l < N; ++l) {
          result(i, j, k) += inverse_metric(i, l) * first_kind(l, j, k);
        }
      }
    }
  }
  return result;
}

/// C_ij = sum over k of Gamma_i,jk v_k: dM/dt = C + C' along v.
template <int N>
ChartMatrix<N> coriolis_matrix(const ChartTensor3<N>& first_kind, const ChartVector<N>& v) {
  ChartMatrix<N> result;
  for (int i = 0; i < N; ++i) {
    result.row(i) = (first_kind.slice[static_cast<std::size_t>(i)] * v).transpose();
  }
  return result;
}

/// Covariant derivative along a curve of velocity v of a field w(t) with numbers w and dw/dt.
/// Bullo, Lewis 2005, section 3.8.
template <int N>
ChartVector<N> covariant_derivative(const ChartTensor3<N>& second_kind, const ChartVector<N>& v,
                                    const ChartVector<N>& w, const ChartVector<N>& w_rate) {
  return w_rate + second_kind(v, w);
}

/// Acceleration of the free motion through v: the curve whose velocity is parallel along itself.
template <int N>
ChartVector<N> geodesic_acceleration(const ChartTensor3<N>& second_kind, const ChartVector<N>& v) {
  return -second_kind(v, v);
}

/// Riemann curvature R_ijkl = <R(d_k, d_l) d_j, d_i> with R(X, Y) Z = D_X D_Y Z - D_Y D_X Z -
/// D_[X,Y] Z: positive R_1212 on a sphere.
/// @param second_derivative  (k, l, i, j) = d2 M_ij / dq_k dq_l
/// Source: Lee 2018, "Introduction to Riemannian Manifolds", chapter 7.
template <int N>
ChartTensor4<N> riemann_curvature(const ChartTensor4<N>& second_derivative,
                                  const ChartTensor3<N>& first_kind,
                                  const ChartTensor3<N>& second_kind) {
  const auto& d = second_derivative;
  ChartTensor4<N> result;
  for (int i = 0; i < N; ++i) {
    for (int j = 0; j < N; ++j) {
      for (int k = 0; k < N; ++k) {
        for (int l = 0; l < N; ++l) {
          double sum = 0.5 * (d(j, k, i, l) + d(i, l, j, k) - d(i, k, j, l) - d(j, l, i, k));
          for (int m = 0; m < N; ++m) {
            sum += first_kind(m, i, l) * second_kind(m, j, k) -
                   first_kind(m, i, k) * second_kind(m, j, l);
          }
          result(i, j, k, l) = sum;
        }
      }
    }
  }
  return result;
}

/// Sectional curvature of the plane of u and w: <R(u, w) w, u> / (|u|^2 |w|^2 - <u, w>^2). Not a
/// number if they span none.
template <int N>
double sectional_curvature(const ChartMatrix<N>& metric, const ChartTensor4<N>& riemann,
                           const ChartVector<N>& u, const ChartVector<N>& w) {
  double curvature = 0.0;
  for (int i = 0; i < N; ++i) {
    for (int j = 0; j < N; ++j) {
      const auto& numbers = riemann.slice[static_cast<std::size_t>(i)];
      curvature += u[i] * w[j] * u.dot(numbers.slice[static_cast<std::size_t>(j)] * w);
    }
  }
  const double uw = u.dot(metric * w);
  return curvature / (u.dot(metric * u) * w.dot(metric * w) - uw * uw);
}

}  // namespace geodesic::control
