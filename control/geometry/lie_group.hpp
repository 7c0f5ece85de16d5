// What every Lie group of this folder offers, as a concept, and what follows from it for all of
// them alike. The groups themselves are in r.hpp, so2.hpp, so3.hpp, se2.hpp, se3.hpp and
// product.hpp.
//
// A group G is a struct of static functions on
//   G::Element   a motion                       G::Tangent    x in the Lie algebra, n numbers
//   G::Algebra   the algebra as matrices        G::Jacobian   n x n
//   exp, log           the exponential map and its inverse on |angle| <= pi
//   hat, vee           x as a matrix and back; matrix(g): the motion as one, matrix(exp x) =
//                      exp of the matrix hat(x)
//   Ad(g)              hat(Ad(g) x) = matrix(g) hat(x) matrix(g)^-1
//   ad(x)              ad(x) y = [x, y];  Ad(exp x) = exp of the matrix ad(x)
//   left_jacobian(x)   exp(x + d) = exp(J_l(x) d) exp(x) to first order in d
//   right_jacobian(x)  exp(x + d) = exp(x) exp(J_r(x) d);  J_r(x) = J_l(-x)
//   distance           that of the left-invariant Riemannian metric in which translations count in
//                      metres and rotations as arcs of radius `metres_per_radian`
//   random(engine)     by Haar's measure: uniform over rotations; translations, where that measure
//                      is infinite, uniform within +-1 m along each axis
// In a tangent the linear numbers come first, then the angular ones. Everything is real-time and
// exact to a few units in the last place, also at small angles and near pi.
//
// Sources: Murray, Li, Sastry 1994, chapter 2 and appendix A; Chirikjian 2012, volume 2, chapter
// 10; Barfoot 2017, chapter 7; Sola, Deray, Atchuthan 2018.
#pragma once

#include <Eigen/Core>
#include <concepts>
#include <random>

namespace geodesic::control {

template <class G>
concept LieGroup = requires(const typename G::Element& g, const typename G::Tangent& x,
                            const typename G::Algebra& m, std::mt19937& engine) {
  { G::kDimension } -> std::convertible_to<int>;
  { G::identity() } -> std::same_as<typename G::Element>;
  { G::compose(g, g) } -> std::same_as<typename G::Element>;
  { G::inverse(g) } -> std::same_as<typename G::Element>;
  { G::exp(x) } -> std::same_as<typename G::Element>;
  { G::log(g) } -> std::same_as<typename G::Tangent>;
  { G::hat(x) } -> std::same_as<typename G::Algebra>;
  { G::vee(m) } -> std::same_as<typename G::Tangent>;
  { G::matrix(g) } -> std::same_as<typename G::Algebra>;
  { G::Ad(g) } -> std::same_as<typename G::Jacobian>;
  { G::ad(x) } -> std::same_as<typename G::Jacobian>;
  { G::left_jacobian(x) } -> std::same_as<typename G::Jacobian>;
  { G::left_jacobian_inverse(x) } -> std::same_as<typename G::Jacobian>;
  { G::distance(g, g, 1.0) } -> std::same_as<double>;
  { G::random(engine) } -> std::same_as<typename G::Element>;
};

/// J_r(x) = J_l(-x). Real-time.
template <LieGroup G>
typename G::Jacobian right_jacobian_of(const typename G::Tangent& x) noexcept {
  return G::left_jacobian(-x);
}

/// Inverse of J_r(x). Real-time.
template <LieGroup G>
typename G::Jacobian right_jacobian_inverse_of(const typename G::Tangent& x) noexcept {
  return G::left_jacobian_inverse(-x);
}

/// The shortest x with from * exp(x) = to. Real-time.
template <LieGroup G>
typename G::Tangent difference_of(const typename G::Element& from,
                                  const typename G::Element& to) noexcept {
  return G::log(G::compose(G::inverse(from), to));
}

/// The way from `from` (share 0) to `to` (share 1) along a one-parameter subgroup, with constant
/// velocity in the moving frame: from * exp(share * log(from^-1 * to)). On R, SO(2) and SO(3),
/// whose metrics are bi-invariant, that is the shortest geodesic; on SE(2) a rotation about a pole
/// and on SE(3) a screw motion, whatever the frames' origins. Real-time.
template <LieGroup G>
typename G::Element interpolate(const typename G::Element& from, const typename G::Element& to,
                                double share) noexcept {
  const typename G::Tangent x = share * difference_of<G>(from, to);
  return G::compose(from, G::exp(x));
}

}  // namespace geodesic::control
