// The shortest form of a trigonometric polynomial: sums of angles, sin(q1 + q2), where joints are
// parallel, products, cos q1 sin q2, where they are not. Chosen by the number of terms; how it is
// written down is another file's matter.
#pragma once

#include <vector>

#include "tools/derive/polynomial.hpp"

namespace geodesic::tools::derive {

/// cos(wave)^exponent or sin(wave)^exponent.
struct TrigPower {
  Wave wave{};
  bool sine = false;
  int exponent = 1;
  // NOLINTNEXTLINE(modernize-use-nullptr): the compiler compares with 0
  auto operator<=>(const TrigPower&) const = default;
};

struct ProductTerm {
  Monomial monomial = 0;
  double value = 0.0;
  std::vector<TrigPower> factors;  ///< ascending; none: a constant
};

/// Equal to `polynomial` and never of more terms: pairs A cos(a + b) +- A cos(a - b), and the like
/// with sines, become products for as long as there are any; 1 +- cos 2a become squares.
/// In canonical order: constants first, low frequencies before high ones.
std::vector<ProductTerm> shortest_form(const Polynomial& polynomial);

}  // namespace geodesic::tools::derive
