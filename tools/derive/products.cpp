// Sums of waves to products; see the header.
#include "tools/derive/products.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <tuple>

namespace geodesic::tools::derive {
namespace {

constexpr long double kEqual = 1e-12L;

// A term on its way: one wave that may still be split, and the factors that were split off.
struct Shape {
  Monomial monomial = 0;
  std::vector<TrigPower> split;
  Wave wave{};
  bool sine = false;
  // NOLINTNEXTLINE(modernize-use-nullptr): the compiler compares with 0
  auto operator<=>(const Shape&) const = default;
};
using Terms = std::map<Shape, long double>;

bool is_zero(const Wave& wave) {
  return std::all_of(wave.begin(), wave.end(), [](std::int8_t k) { return k == 0; });
}

// Moves the sign of a wave into the coefficient.
void make_canonical(Wave& wave, bool sine, long double& value) {
  const auto first = std::find_if(wave.begin(), wave.end(), [](std::int8_t k) { return k != 0; });
  if (first == wave.end() || *first > 0) return;
  for (std::int8_t& k : wave) k = static_cast<std::int8_t>(-k);
  if (sine) value = -value;
}

void split_off(std::vector<TrigPower>& split, std::size_t angle, int multiple, bool sine) {
  Wave unit{};
  unit[angle] = static_cast<std::int8_t>(multiple);
  const auto known = std::find_if(split.begin(), split.end(), [&](const TrigPower& power) {
    return power.wave == unit && power.sine == sine;
  });
  if (known != split.end()) {
    ++known->exponent;
  } else {
    split.push_back({unit, sine, 1});
    std::sort(split.begin(), split.end());
  }
}

// Tries to join `term`, a wave w = a + t, where t is a multiple of an angle, with its partner a -
// t. The pair becomes one term with a's wave and a factor of t alone.
bool join(Terms& terms, Terms::iterator term, std::size_t angle, int step) {
  Shape middle = term->first;
  middle.wave[angle] = static_cast<std::int8_t>(middle.wave[angle] - step);
  Shape other = middle;
  other.wave[angle] = static_cast<std::int8_t>(other.wave[angle] - step);
  long double other_sign = 1.0L;
  make_canonical(other.wave, other.sine, other_sign);
  if (other == term->first || (other.sine && is_zero(other.wave))) return false;
  const auto partner = terms.find(other);
  if (partner == terms.end()) return false;
  // f(a + t) with coefficient A, f(a - t) with coefficient B; t = step * angle.
  const long double a = term->second;
  const long double b = other_sign * partner->second;
  const bool even = std::abs(a - b) <= kEqual * std::abs(a);
  if (!even && std::abs(a + b) > kEqual * std::abs(a)) return false;
  // cos: A = B 2A cos a cos t, A = -B -2A sin a sin t; sin: 2A sin a cos t, 2A cos a sin t.
  long double value = 2.0L * a;
  if (!even) {
    value *= (step < 0 ? -1.0L : 1.0L) * (middle.sine ? 1.0L : -1.0L);
    middle.sine = !middle.sine;
  }
  make_canonical(middle.wave, middle.sine, value);
  if (middle.sine && is_zero(middle.wave)) return false;
  split_off(middle.split, angle, std::abs(step), !even);
  terms.erase(partner);
  terms.erase(term);
  long double& sum = terms[middle];
  sum += value;
  if (std::abs(sum) <= kEqual * std::abs(value)) terms.erase(middle);
  return true;
}

bool join_all(Terms& terms, std::size_t angle) {
  bool any = false;
  for (bool again = true; again;) {
    again = false;
    std::vector<Shape> shapes;
    for (const auto& [shape, value] : terms) {
      if (shape.wave[angle] != 0) shapes.push_back(shape);
    }
    for (const Shape& shape : shapes) {
      for (const int step : {1, -1, 2, -2}) {
        const auto term = terms.find(shape);
        if (term == terms.end() || !join(terms, term, angle, step)) continue;
        again = any = true;
      }
    }
  }
  return any;
}

Terms joined(const Polynomial& polynomial, bool ascending) {
  Terms terms;
  for (const Term& term : polynomial.terms()) {
    terms[{term.key.monomial, {}, term.key.wave, term.key.sine}] = term.value;
  }
  std::vector<std::size_t> angles;
  for (std::size_t i = 0; i < kMaxAngles; ++i) {
    if (std::any_of(terms.begin(), terms.end(),
                    [&](const auto& term) { return term.first.wave[i] != 0; })) {
      angles.push_back(i);
    }
  }
  if (!ascending) std::reverse(angles.begin(), angles.end());
  for (bool again = true; again;) {
    again = false;
    for (const std::size_t angle : angles) again = join_all(terms, angle) || again;
  }
  return terms;
}

ProductTerm finished(const Shape& shape, long double value) {
  ProductTerm term{shape.monomial, static_cast<double>(value), shape.split};
  if (is_zero(shape.wave)) return term;
  const auto same = std::find_if(term.factors.begin(), term.factors.end(), [&](const auto& power) {
    return power.wave == shape.wave && power.sine == shape.sine;
  });
  if (same != term.factors.end()) {
    ++same->exponent;
  } else {
    term.factors.push_back({shape.wave, shape.sine, 1});
  }
  // Factors of low angles first, cosines before sines.
  std::sort(term.factors.begin(), term.factors.end(), [](const TrigPower& a, const TrigPower& b) {
    return std::tie(b.wave, a.sine) < std::tie(a.wave, b.sine);
  });
  return term;
}

// Constants, then by how many angles, multiples counted, a term has.
int frequency(const ProductTerm& term) {
  int sum = 0;
  for (const TrigPower& power : term.factors) {
    for (const std::int8_t k : power.wave) sum += power.exponent * std::abs(k);
  }
  return sum;
}

}  // namespace

std::vector<ProductTerm> shortest_form(const Polynomial& polynomial) {
  Terms best = joined(polynomial, true);
  if (Terms other = joined(polynomial, false); other.size() < best.size()) best = std::move(other);
  // The same product may have come about in two orders.
  std::map<std::pair<Monomial, std::vector<TrigPower>>, double> sum;
  for (const auto& [shape, value] : best) {
    const ProductTerm term = finished(shape, value);
    sum[{term.monomial, term.factors}] += term.value;
  }
  std::vector<ProductTerm> list;
  list.reserve(sum.size());
  for (const auto& [product, value] : sum) list.push_back({product.first, value, product.second});
  std::stable_sort(list.begin(), list.end(), [](const ProductTerm& a, const ProductTerm& b) {
    const int fa = frequency(a);
    const int fb = frequency(b);
    if (fa != fb) return fa < fb;
    if (a.factors.size() != b.factors.size()) return a.factors.size() < b.factors.size();
    return b.factors < a.factors;  // q1 before q2
  });
  return list;
}

}  // namespace geodesic::tools::derive
