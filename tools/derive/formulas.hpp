// The formulas of a derivation as pairs of left and right sides, in one notation. Which of them a
// document holds, and how it looks, is sheet.cpp's matter.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "tools/derive/closed_form.hpp"
#include "tools/derive/layout.hpp"

namespace geodesic::tools::derive {

struct Formula {
  std::string left;  ///< "M12 = M21"
  std::string right;
};

/// A Christoffel symbol by its three indices, 0-based, and what it is: sign * values[value].
struct SymbolOfConnection {
  int i = 0;
  int j = 0;
  int k = 0;
  int value = 0;
  int sign = 1;
};

/// The symbols that are not 0 (k >= j: they are symmetric), and their different values.
struct Connection {
  std::vector<SymbolOfConnection> symbols;
  std::vector<Polynomial> values;
};
Connection distinct(const std::vector<std::vector<std::vector<Polynomial>>>& symbols);

class Formulas {
 public:
  Formulas(ClosedForm& form, Notation notation, int digits);

  std::vector<Formula> metric() const;
  std::vector<Formula> gravity() const;
  /// h1 = ..., then which symbols are which of them. `letter`: what values are called.
  std::vector<Formula> values(const Connection& connection, const std::string& letter) const;
  std::vector<Formula> symbols(const Connection& connection, const std::string& letter,
                               bool second_kind) const;
  /// tau_i = sum of M_ij a_j + Gamma_i,jk v_j v_k + g_i by the names above.
  std::vector<Formula> equations(const Connection& connection) const;
  Formula determinant() const;

  const Layout& layout() const noexcept { return layout_; }

 private:
  std::string name(const std::string& letter, const std::vector<int>& indices) const;
  std::string value_name(const Connection& connection, const std::string& letter, int value) const;
  std::string product(const std::string& a, const std::string& b) const;
  std::string rates(int j, int k, int factor) const;

  ClosedForm* form_;
  Layout layout_;
};

}  // namespace geodesic::tools::derive
