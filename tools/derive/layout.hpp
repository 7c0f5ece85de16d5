// Writes a polynomial the way a person would: shortest form, letters in the order of textbooks,
// terms of a mass or of a sine together. Text, LaTeX, or with a sign for every product (JSON).
#pragma once

#include <string>
#include <vector>

#include "tools/derive/products.hpp"
#include "tools/derive/symbols.hpp"

namespace geodesic::tools::derive {

enum class Notation : std::uint8_t {
  kText,   ///< m2 l1 lc2 cos(q1 + q2)
  kLatex,  ///< m_{2} l_{1} l_{c2} \cos(q_{1} + q_{2})
  kPlain,  ///< m2*l1*lc2*cos(q1 + q2), digits enough to read the same double
};

/// What terms are gathered by.
enum class Gather : std::uint8_t {
  kMass,  ///< m1 (...) + I1 + m2 (...): metrics
  kWave,  ///< (m1 lc1 + m2 l1) g cos q1 + ...: torques
};

class Layout {
 public:
  /// @param digits  of numbers, except in kPlain. Refers to `symbols`, and adds
  /// monomials to its table.
  Layout(Symbols& symbols, Notation notation, int digits);

  /// "0" for nothing.
  std::string write(const Polynomial& polynomial, Gather gather) const;

  std::string number(double value) const;
  Notation notation() const noexcept { return notation_; }

 private:
  using Terms = std::vector<ProductTerm>;
  std::string sum(const Terms& terms) const;
  std::string term(const ProductTerm& term, const std::string& bracket = "") const;
  std::string gathered_by_mass(const Terms& terms) const;
  std::string gathered_by_wave(const Terms& terms) const;
  std::string coefficient(double magnitude, bool alone, bool with_letters) const;
  std::string power(const std::string& base, int exponent) const;
  std::string wave(const TrigPower& factor) const;
  MonomialTable::Powers ordered(Monomial monomial) const;
  int head(Monomial monomial) const;
  bool comes_first(const ProductTerm& a, const ProductTerm& b) const;

  Symbols* symbols_;
  Notation notation_;
  int digits_;
  std::vector<int> rank_;       ///< of each letter in a product
  std::vector<int> head_rank_;  ///< of each letter at the head of a term
};

/// `text` in lines of at most `width` where there is a + or - to break before; every line but the
/// first begins with `indent`.
std::string wrapped(const std::string& text, std::size_t width, const std::string& indent);

/// Joins signed terms: {"a", "-b", "c"} to "a - b + c"; "0" for none.
std::string signed_sum(const std::vector<std::string>& terms);

}  // namespace geodesic::tools::derive
