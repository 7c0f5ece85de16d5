// Vectors and matrices of jets: how a point of a chart is set moving, and Eigen's leave to compute
// with jets. The numbers themselves are in jet.hpp.
#pragma once

#include <Eigen/Core>
#include <limits>

#include "control/geometry/jet.hpp"

namespace Eigen {

template <class S>
struct NumTraits<geodesic::control::Jet<S>> : GenericNumTraits<geodesic::control::Jet<S>> {
  using Jet = geodesic::control::Jet<S>;
  using Real = Jet;
  using NonInteger = Jet;
  using Nested = Jet;
  using Literal = double;
  enum {
    IsComplex = 0,
    IsInteger = 0,
    IsSigned = 1,
    RequireInitialization = 1,
    ReadCost = 2 * static_cast<int>(NumTraits<S>::ReadCost),
    AddCost = 2 * static_cast<int>(NumTraits<S>::AddCost),
    MulCost = 3 * static_cast<int>(NumTraits<S>::MulCost) + static_cast<int>(NumTraits<S>::AddCost)
  };
  static Jet epsilon() { return std::numeric_limits<double>::epsilon(); }
  static Jet dummy_precision() { return NumTraits<double>::dummy_precision(); }
  static Jet highest() { return std::numeric_limits<double>::max(); }
  static Jet lowest() { return std::numeric_limits<double>::lowest(); }
  static int digits10() { return NumTraits<double>::digits10(); }
};

/// Matrices of double and matrices of jets multiply and add.
template <class S, class BinaryOp>
struct ScalarBinaryOpTraits<double, geodesic::control::Jet<S>, BinaryOp> {
  using ReturnType = geodesic::control::Jet<S>;
};
template <class S, class BinaryOp>
struct ScalarBinaryOpTraits<geodesic::control::Jet<S>, double, BinaryOp> {
  using ReturnType = geodesic::control::Jet<S>;
};

}  // namespace Eigen

namespace geodesic::control {

/// x, at rest.
template <class S, int N>
Eigen::Matrix<Jet<S>, N, 1> still(const Eigen::Matrix<S, N, 1>& x) {
  Eigen::Matrix<Jet<S>, N, 1> result;
  for (int i = 0; i < N; ++i) {
    result[i] = {x[i], S(0.0)};
  }
  return result;
}

/// x, its coordinate i moving at rate 1: a function's rate is its partial derivative.
template <class S, int N>
Eigen::Matrix<Jet<S>, N, 1> vary(const Eigen::Matrix<S, N, 1>& x, int i) {
  Eigen::Matrix<Jet<S>, N, 1> result = still(x);
  result[i].rate = S(1.0);
  return result;
}

/// x, moving at `rate`: a function's rate is its derivative in that direction.
template <class S, int N>
Eigen::Matrix<Jet<S>, N, 1> along(const Eigen::Matrix<S, N, 1>& x,
                                  const Eigen::Matrix<S, N, 1>& rate) {
  Eigen::Matrix<Jet<S>, N, 1> result;
  for (int i = 0; i < N; ++i) {
    result[i] = {x[i], rate[i]};
  }
  return result;
}

template <class S, int N>
Eigen::Matrix<S, N, 1> values(const Eigen::Matrix<Jet<S>, N, 1>& x) {
  Eigen::Matrix<S, N, 1> result;
  for (int i = 0; i < N; ++i) {
    result[i] = x[i].value;
  }
  return result;
}

template <class S, int N>
Eigen::Matrix<S, N, 1> rates(const Eigen::Matrix<Jet<S>, N, 1>& x) {
  Eigen::Matrix<S, N, 1> result;
  for (int i = 0; i < N; ++i) {
    result[i] = x[i].rate;
  }
  return result;
}

}  // namespace geodesic::control
