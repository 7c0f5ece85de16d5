// Translations: the group R^n under addition. Rotations are in so2.hpp and so3.hpp.
#pragma once

#include <Eigen/Core>
#include <random>

#include "control/geometry/lie_group.hpp"

namespace geodesic::control {

/// As matrices: [1 x; 0 1].
template <int n>
struct Translations {
  static constexpr int kDimension = n;
  using Element = Eigen::Matrix<double, n, 1>;  ///< [m]
  using Tangent = Eigen::Matrix<double, n, 1>;  ///< [m, or m/s]
  using Jacobian = Eigen::Matrix<double, n, n>;
  using Algebra = Eigen::Matrix<double, n + 1, n + 1>;

  static Element identity() noexcept { return Element::Zero(); }
  static Element compose(const Element& a, const Element& b) noexcept { return a + b; }
  static Element inverse(const Element& g) noexcept { return -g; }
  static Element exp(const Tangent& x) noexcept { return x; }
  static Tangent log(const Element& g) noexcept { return g; }
  static Algebra hat(const Tangent& x) noexcept {
    Algebra m = Algebra::Zero();
    m.template topRightCorner<n, 1>() = x;
    return m;
  }
  static Tangent vee(const Algebra& m) noexcept { return m.template topRightCorner<n, 1>(); }
  static Algebra matrix(const Element& g) noexcept { return Algebra::Identity() + hat(g); }
  static Jacobian Ad(const Element& /*g*/) noexcept { return Jacobian::Identity(); }
  static Jacobian ad(const Tangent& /*x*/) noexcept { return Jacobian::Zero(); }
  static Jacobian left_jacobian(const Tangent& /*x*/) noexcept { return Jacobian::Identity(); }
  static Jacobian left_jacobian_inverse(const Tangent& /*x*/) noexcept {
    return Jacobian::Identity();
  }
  static double distance(const Element& a, const Element& b,
                         double /*metres_per_radian*/) noexcept {
    return (b - a).norm();
  }
  template <std::uniform_random_bit_generator Engine>
  static Element random(Engine& engine) {
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    Element g;
    for (int i = 0; i < n; ++i) {
      g[i] = uniform(engine);
    }
    return g;
  }
};

using R = Translations<1>;
using R2 = Translations<2>;
static_assert(LieGroup<R> && LieGroup<R2>);

}  // namespace geodesic::control
