// The direct product of two Lie groups: each acts as if the other were not there. Configuration
// spaces are such products; that of a whole mechanism, of a number of factors known at run time
// only, is in ../mechanism/configuration.hpp.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <random>

#include "control/geometry/lie_group.hpp"
#include "control/geometry/r.hpp"
#include "control/geometry/so2.hpp"

namespace geodesic::control {

/// As matrices: those of both factors on the diagonal.
template <LieGroup A, LieGroup B>
struct Product {
  static constexpr int kFirst = A::kDimension;
  static constexpr int kSecond = B::kDimension;
  static constexpr int kDimension = kFirst + kSecond;
  struct Element {
    typename A::Element first = A::identity();
    typename B::Element second = B::identity();
  };
  using Tangent = Eigen::Matrix<double, kDimension, 1>;
  using Jacobian = Eigen::Matrix<double, kDimension, kDimension>;
  static constexpr int kRows = A::Algebra::RowsAtCompileTime;
  static constexpr int kMoreRows = B::Algebra::RowsAtCompileTime;
  using Algebra = Eigen::Matrix<double, kRows + kMoreRows, kRows + kMoreRows>;

  static Element identity() noexcept { return {}; }
  static Element compose(const Element& a, const Element& b) noexcept {
    return {A::compose(a.first, b.first), B::compose(a.second, b.second)};
  }
  static Element inverse(const Element& g) noexcept {
    return {A::inverse(g.first), B::inverse(g.second)};
  }
  static Element exp(const Tangent& x) noexcept { return {A::exp(first(x)), B::exp(second(x))}; }
  static Tangent log(const Element& g) noexcept {
    return joined(A::log(g.first), B::log(g.second));
  }
  static Algebra hat(const Tangent& x) noexcept {
    return blocks<Algebra>(A::hat(first(x)), B::hat(second(x)));
  }
  static Tangent vee(const Algebra& m) noexcept {
    return joined(A::vee(m.template topLeftCorner<kRows, kRows>()),
                  B::vee(m.template bottomRightCorner<kMoreRows, kMoreRows>()));
  }
  static Algebra matrix(const Element& g) noexcept {
    return blocks<Algebra>(A::matrix(g.first), B::matrix(g.second));
  }
  static Jacobian Ad(const Element& g) noexcept {
    return blocks<Jacobian>(A::Ad(g.first), B::Ad(g.second));
  }
  static Jacobian ad(const Tangent& x) noexcept {
    return blocks<Jacobian>(A::ad(first(x)), B::ad(second(x)));
  }
  static Jacobian left_jacobian(const Tangent& x) noexcept {
    return blocks<Jacobian>(A::left_jacobian(first(x)), B::left_jacobian(second(x)));
  }
  static Jacobian left_jacobian_inverse(const Tangent& x) noexcept {
    return blocks<Jacobian>(A::left_jacobian_inverse(first(x)),
                            B::left_jacobian_inverse(second(x)));
  }
  static double distance(const Element& a, const Element& b, double metres_per_radian) noexcept {
    return std::hypot(A::distance(a.first, b.first, metres_per_radian),
                      B::distance(a.second, b.second, metres_per_radian));
  }
  template <std::uniform_random_bit_generator Engine>
  static Element random(Engine& engine) {
    const typename A::Element first = A::random(engine);
    return {first, B::random(engine)};
  }

 private:
  static Tangent joined(const typename A::Tangent& a, const typename B::Tangent& b) noexcept {
    Tangent x;
    x.template head<A::kDimension>() = a;
    x.template tail<B::kDimension>() = b;
    return x;
  }
  static typename A::Tangent first(const Tangent& x) noexcept { return x.template head<kFirst>(); }
  static typename B::Tangent second(const Tangent& x) noexcept {
    return x.template tail<kSecond>();
  }
  template <class Whole, class First, class Second>
  static Whole blocks(const First& first, const Second& second) noexcept {
    Whole m = Whole::Zero();
    m.template topLeftCorner<First::RowsAtCompileTime, First::ColsAtCompileTime>() = first;
    m.template bottomRightCorner<Second::RowsAtCompileTime, Second::ColsAtCompileTime>() = second;
    return m;
  }
};

/// Positions of a planar joint: (x, y) and the angle, which do not act on each other.
using PlanarJoint = Product<R2, SO2>;
static_assert(LieGroup<PlanarJoint>);

}  // namespace geodesic::control
