// Arithmetic of trigonometric polynomials; see the header.
#include "tools/derive/polynomial.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

namespace geodesic::tools::derive {
namespace {

// Figures come from files with 16 digits, so what cancels to this part of its summands is rounding.
constexpr long double kCancelled = 1e-13L;

bool is_constant(const Wave& wave) {
  return std::all_of(wave.begin(), wave.end(), [](std::int8_t k) { return k == 0; });
}

Wave combine(const Wave& a, const Wave& b, int sign) {
  Wave sum{};
  for (std::size_t i = 0; i < sum.size(); ++i) {
    sum[i] = static_cast<std::int8_t>(a[i] + sign * b[i]);
  }
  return sum;
}

// cos(-x) = cos(x), sin(-x) = -sin(x): the sign of a wave is moved into the coefficient.
void make_canonical(Term& term) {
  const auto first = std::find_if(term.key.wave.begin(), term.key.wave.end(),
                                  [](std::int8_t k) { return k != 0; });
  if (first == term.key.wave.end()) {
    if (term.key.sine) term.value = term.magnitude = 0.0L;
    return;
  }
  if (*first > 0) return;
  for (std::int8_t& k : term.key.wave) k = static_cast<std::int8_t>(-k);
  if (term.key.sine) term.value = -term.value;
}

// The product of two waves as a sum: cos a cos b = (cos(a - b) + cos(a + b)) / 2 and its three
// sisters. The monomial is the caller's.
void append_product(const Term& a, const Term& b, Monomial monomial, std::vector<Term>& out) {
  const long double value = a.value * b.value;
  const long double magnitude = a.magnitude * b.magnitude;
  if (is_constant(b.key.wave)) {
    out.push_back({{monomial, a.key.wave, a.key.sine}, value, magnitude});
    return;
  }
  if (is_constant(a.key.wave)) {
    out.push_back({{monomial, b.key.wave, b.key.sine}, value, magnitude});
    return;
  }
  const bool sine = a.key.sine != b.key.sine;
  // Signs of the halves at a + b and at a - b.
  const long double at_sum = a.key.sine && b.key.sine ? -0.5L : 0.5L;
  const long double at_difference = !a.key.sine && b.key.sine ? -0.5L : 0.5L;
  out.push_back(
      {{monomial, combine(a.key.wave, b.key.wave, 1), sine}, at_sum * value, magnitude / 2});
  out.push_back({{monomial, combine(a.key.wave, b.key.wave, -1), sine},
                 at_difference * value,
                 magnitude / 2});
}

}  // namespace

Polynomial::Polynomial(long double number) : Polynomial(Monomial{0}, number) {}

Polynomial::Polynomial(Monomial monomial, long double factor) {
  if (factor != 0.0L) terms_.push_back({{monomial, Wave{}, false}, factor, std::abs(factor)});
}

Polynomial Polynomial::cosine(const Wave& wave) {
  return sum_of({{{0, wave, false}, 1.0L, 1.0L}});
}

Polynomial Polynomial::sine(const Wave& wave) {
  return sum_of({{{0, wave, true}, 1.0L, 1.0L}});
}

Polynomial Polynomial::sum_of(std::vector<Term> terms) {
  for (Term& term : terms) make_canonical(term);
  std::sort(terms.begin(), terms.end(), [](const Term& a, const Term& b) { return a.key < b.key; });
  Polynomial result;
  for (auto term = terms.begin(); term != terms.end();) {
    Term sum = *term++;
    for (; term != terms.end() && term->key == sum.key; ++term) {
      sum.value += term->value;
      sum.magnitude += term->magnitude;
    }
    if (std::abs(sum.value) > kCancelled * sum.magnitude) result.terms_.push_back(sum);
  }
  return result;
}

Polynomial& Polynomial::add(const Polynomial& other, long double factor) {
  std::vector<Term> sum;
  sum.reserve(terms_.size() + other.terms_.size());
  auto mine = terms_.begin();
  for (const Term& theirs : other.terms_) {
    while (mine != terms_.end() && mine->key < theirs.key) sum.push_back(*mine++);
    Term term{theirs.key, factor * theirs.value, std::abs(factor) * theirs.magnitude};
    if (mine != terms_.end() && mine->key == theirs.key) {
      term.value += mine->value;
      term.magnitude += mine->magnitude;
      ++mine;
    }
    if (std::abs(term.value) > kCancelled * term.magnitude) sum.push_back(term);
  }
  sum.insert(sum.end(), mine, terms_.end());
  terms_ = std::move(sum);
  return *this;
}

Polynomial& Polynomial::operator+=(const Polynomial& other) {
  return add(other, 1.0L);
}

Polynomial& Polynomial::operator-=(const Polynomial& other) {
  return add(other, -1.0L);
}

Polynomial& Polynomial::operator*=(long double factor) {
  if (factor == 0.0L) {
    terms_.clear();
    return *this;
  }
  for (Term& term : terms_) {
    term.value *= factor;
    term.magnitude *= std::abs(factor);
  }
  return *this;
}

bool same(const Polynomial& a, const Polynomial& b) {
  if (a.terms().size() != b.terms().size()) return false;
  return std::equal(
      a.terms().begin(), a.terms().end(), b.terms().begin(), [](const Term& x, const Term& y) {
        return x.key == y.key &&
               std::abs(x.value - y.value) <= kCancelled * (x.magnitude + y.magnitude);
      });
}

Monomial MonomialTable::intern(const Powers& powers) {
  const auto [place, fresh] = numbers_.try_emplace(powers, static_cast<Monomial>(powers_.size()));
  if (fresh) powers_.push_back(powers);
  return place->second;
}

Monomial MonomialTable::product(Monomial a, Monomial b) {
  if (a == 0 || b == 0) return a + b;
  const auto [place, fresh] = products_.try_emplace(std::minmax(a, b), 0);
  if (!fresh) return place->second;
  Powers powers = powers_[a];
  for (const Power& factor : powers_[b]) {
    const auto at = std::find_if(powers.begin(), powers.end(),
                                 [&](const Power& mine) { return mine.letter >= factor.letter; });
    if (at != powers.end() && at->letter == factor.letter) {
      at->exponent += factor.exponent;
    } else {
      powers.insert(at, factor);
    }
  }
  return place->second = intern(powers);
}

Polynomial multiply(MonomialTable& table, const Polynomial& a, const Polynomial& b) {
  std::vector<Term> terms;
  terms.reserve(2 * a.terms().size() * b.terms().size());
  for (const Term& x : a.terms()) {
    for (const Term& y : b.terms()) {
      append_product(x, y, table.product(x.key.monomial, y.key.monomial), terms);
    }
  }
  return Polynomial::sum_of(std::move(terms));
}

Polynomial turn(const Polynomial& a, const Polynomial& b, const Wave& wave, long double sign) {
  const Term cosine{{0, wave, false}, 1.0L, 1.0L};
  const Term sine{{0, wave, true}, sign, 1.0L};
  std::vector<Term> terms;
  terms.reserve(2 * (a.terms().size() + b.terms().size()));
  for (const Term& x : a.terms()) append_product(x, cosine, x.key.monomial, terms);
  for (const Term& x : b.terms()) append_product(x, sine, x.key.monomial, terms);
  return Polynomial::sum_of(std::move(terms));
}

}  // namespace geodesic::tools::derive
