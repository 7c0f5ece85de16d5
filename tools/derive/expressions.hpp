// Polynomials as GiNaC expressions and back: GiNaC differentiates, the normal form simplifies.
#pragma once

#include <ginac/ginac.h>

#include <vector>

#include "tools/derive/symbols.hpp"

namespace geodesic::tools::derive {

/// One GiNaC symbol for every angle and every letter. Refers to `symbols`, which must outlive it.
class Expressions {
 public:
  explicit Expressions(Symbols& symbols);

  GiNaC::ex expression(const Polynomial& polynomial) const;

  /// The normal form of a sum, product or power of numbers, symbols of this object and sines and
  /// cosines of their whole combinations. @throws std::logic_error for anything else.
  Polynomial polynomial(const GiNaC::ex& expression) const;

  /// d expression / d q[dof], by the chain rule over the angles that follow q[dof].
  GiNaC::ex derivative(const GiNaC::ex& expression, int dof) const;

  /// The symbol of an angle, or of a letter.
  const GiNaC::symbol& angle(int number) const { return angles_[static_cast<std::size_t>(number)]; }
  const GiNaC::symbol& letter(int number) const {
    return letters_[static_cast<std::size_t>(number)];
  }

 private:
  Wave wave(const GiNaC::ex& argument) const;
  void append(const GiNaC::ex& expression, std::vector<Term>& terms) const;

  Symbols* symbols_;
  std::vector<GiNaC::symbol> angles_;
  std::vector<GiNaC::symbol> letters_;
};

}  // namespace geodesic::tools::derive
