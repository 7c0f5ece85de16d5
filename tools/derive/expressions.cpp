// Between the normal form and GiNaC; see the header.
#include "tools/derive/expressions.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace geodesic::tools::derive {
namespace {

int position(const std::vector<GiNaC::symbol>& list, const GiNaC::ex& symbol) {
  const auto found = std::find_if(list.begin(), list.end(), [&](const GiNaC::symbol& known) {
    return known.is_equal(GiNaC::ex_to<GiNaC::symbol>(symbol));
  });
  return found == list.end() ? -1 : static_cast<int>(found - list.begin());
}

long double number(const GiNaC::ex& expression) {
  return GiNaC::ex_to<GiNaC::numeric>(expression).to_double();
}

// A whole number as an exact one, so that GiNaC can take exact differences of it.
GiNaC::numeric coefficient(long double value) {
  const auto rounded = static_cast<double>(value);
  const bool whole = std::abs(rounded) < 1e9 && rounded == std::round(rounded);
  return whole ? GiNaC::numeric(static_cast<long>(rounded)) : GiNaC::numeric(rounded);
}

}  // namespace

Expressions::Expressions(Symbols& symbols) : symbols_(&symbols) {
  for (std::size_t i = 0; i < symbols.angles.size(); ++i) {
    angles_.emplace_back("theta" + std::to_string(i + 1));
  }
  for (const Letter& letter : symbols.letters) letters_.emplace_back(letter.name);
}

GiNaC::ex Expressions::expression(const Polynomial& polynomial) const {
  GiNaC::exvector sum;
  for (const Term& term : polynomial.terms()) {
    GiNaC::exvector product{coefficient(term.value)};
    for (const auto& [letter, exponent] : symbols_->monomials.powers(term.key.monomial)) {
      product.push_back(GiNaC::pow(letters_[static_cast<std::size_t>(letter)], exponent));
    }
    GiNaC::ex argument = 0;
    for (std::size_t i = 0; i < angles_.size(); ++i) {
      if (term.key.wave[i] != 0) argument += static_cast<int>(term.key.wave[i]) * angles_[i];
    }
    if (!argument.is_zero()) {
      product.push_back(term.key.sine ? GiNaC::sin(argument) : GiNaC::cos(argument));
    }
    sum.emplace_back(GiNaC::mul(product));
  }
  return GiNaC::add(sum);
}

Wave Expressions::wave(const GiNaC::ex& argument) const {
  Wave wave{};
  const auto add = [&](const GiNaC::ex& part) {
    GiNaC::ex factor = 1;
    GiNaC::ex symbol = part;
    if (GiNaC::is_a<GiNaC::mul>(part) && part.nops() == 2) {
      const bool first = GiNaC::is_a<GiNaC::numeric>(part.op(0));
      factor = part.op(first ? 0 : 1);
      symbol = part.op(first ? 1 : 0);
    }
    const int at = GiNaC::is_a<GiNaC::symbol>(symbol) ? position(angles_, symbol) : -1;
    if (at < 0 || !GiNaC::is_a<GiNaC::numeric>(factor) ||
        !GiNaC::ex_to<GiNaC::numeric>(factor).is_integer()) {
      throw std::logic_error("an angle is no whole combination of joint angles");
    }
    wave[static_cast<std::size_t>(at)] =
        static_cast<std::int8_t>(GiNaC::ex_to<GiNaC::numeric>(factor).to_int());
  };
  if (GiNaC::is_a<GiNaC::add>(argument)) {
    for (const GiNaC::ex& part : argument) add(part);
  } else {
    add(argument);
  }
  return wave;
}

Polynomial Expressions::polynomial(const GiNaC::ex& expression) const {
  std::vector<Term> terms;
  if (GiNaC::is_a<GiNaC::add>(expression)) {
    for (const GiNaC::ex& part : expression) append(part, terms);
  } else {
    append(expression, terms);
  }
  return Polynomial::sum_of(std::move(terms));
}

void Expressions::append(const GiNaC::ex& expression, std::vector<Term>& terms) const {
  Polynomial product(1.0L);
  const auto multiply_by = [&](const Polynomial& factor) {
    product = multiply(symbols_->monomials, product, factor);
  };
  const auto factor = [&](const GiNaC::ex& ex) {
    if (GiNaC::is_a<GiNaC::numeric>(ex)) {
      product *= number(ex);
    } else if (GiNaC::is_a<GiNaC::symbol>(ex) && position(letters_, ex) >= 0) {
      multiply_by({symbols_->monomials.letter(position(letters_, ex)), 1.0L});
    } else if (GiNaC::is_a<GiNaC::power>(ex) && ex.op(1).info(GiNaC::info_flags::posint)) {
      const Polynomial base = polynomial(ex.op(0));
      for (int i = GiNaC::ex_to<GiNaC::numeric>(ex.op(1)).to_int(); i > 0; --i) multiply_by(base);
    } else if (GiNaC::is_the_function<GiNaC::cos_SERIAL>(ex)) {
      multiply_by(Polynomial::cosine(wave(ex.op(0))));
    } else if (GiNaC::is_the_function<GiNaC::sin_SERIAL>(ex)) {
      multiply_by(Polynomial::sine(wave(ex.op(0))));
    } else if (GiNaC::is_a<GiNaC::add>(ex) || GiNaC::is_a<GiNaC::mul>(ex)) {
      multiply_by(polynomial(ex));
    } else {
      throw std::logic_error("an expression is no trigonometric polynomial");
    }
  };
  if (GiNaC::is_a<GiNaC::mul>(expression)) {
    for (const GiNaC::ex& part : expression) factor(part);
  } else {
    factor(expression);
  }
  terms.insert(terms.end(), product.terms().begin(), product.terms().end());
}

GiNaC::ex Expressions::derivative(const GiNaC::ex& expression, int dof) const {
  GiNaC::ex sum = 0;
  for (std::size_t i = 0; i < angles_.size(); ++i) {
    const Angle& angle = symbols_->angles[i];
    if (angle.dof == dof) sum += coefficient(angle.ratio) * expression.diff(angles_[i]);
  }
  for (std::size_t i = 0; i < letters_.size(); ++i) {
    if (symbols_->letters[i].dof == dof) sum += expression.diff(letters_[i]);
  }
  return sum;
}

}  // namespace geodesic::tools::derive
