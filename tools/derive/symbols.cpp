// Values of closed forms; see the header.
#include "tools/derive/symbols.hpp"

#include <cmath>

namespace geodesic::tools::derive {

double evaluate(const Symbols& symbols, const Polynomial& polynomial, const Eigen::VectorXd& q) {
  long double sum = 0.0L;
  for (const Term& term : polynomial.terms()) {
    long double angle = 0.0L;
    for (std::size_t i = 0; i < symbols.angles.size(); ++i) {
      const Angle& variable = symbols.angles[i];
      angle += static_cast<long double>(term.key.wave[i]) * variable.ratio * q[variable.dof];
    }
    long double product = term.value * (term.key.sine ? std::sin(angle) : std::cos(angle));
    for (const auto& [letter, exponent] : symbols.monomials.powers(term.key.monomial)) {
      const Letter& factor = symbols.letters[static_cast<std::size_t>(letter)];
      const double value = factor.dof >= 0 ? q[factor.dof] : factor.value;
      for (int i = 0; i < exponent; ++i) product *= value;
    }
    sum += product;
  }
  return static_cast<double>(sum);
}

}  // namespace geodesic::tools::derive
