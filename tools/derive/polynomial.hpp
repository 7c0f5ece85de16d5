// Trigonometric polynomials in normal form: sums of number * monomial of letters * cos or sin of an
// integer combination of angles. Every entry of a tree's metric is one, and the form is unique, so
// equal expressions are equal term by term. Nothing here knows of mechanisms or of printing.
#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

namespace geodesic::tools::derive {

/// Most angle variables an expression may have.
inline constexpr int kMaxAngles = 32;

/// k . theta for angle variables theta; the first number that is not 0 is positive.
using Wave = std::array<std::int8_t, kMaxAngles>;

/// A product of letters with exponents, by its number in a MonomialTable. 0 is the product of none.
using Monomial = std::uint32_t;

/// What a coefficient stands before: monomial * cos(wave), or monomial * sin(wave).
struct Key {
  Monomial monomial = 0;
  Wave wave{};
  bool sine = false;
  // NOLINTNEXTLINE(modernize-use-nullptr): the compiler compares with 0
  auto operator<=>(const Key&) const = default;
};

struct Term {
  Key key;
  long double value = 0.0L;
  /// Sum of the magnitudes that were added up to `value`: where they cancelled to rounding, the
  /// term is none.
  long double magnitude = 0.0L;
};

/// Immutable but by assignment; terms in order of their keys, none with value 0.
class Polynomial {
 public:
  Polynomial() = default;
  explicit Polynomial(long double number);
  Polynomial(Monomial monomial, long double factor);
  /// cos(wave), or sin(wave); the wave may have either sign.
  static Polynomial cosine(const Wave& wave);
  static Polynomial sine(const Wave& wave);
  /// Terms in any order, several of a key, waves of either sign.
  static Polynomial sum_of(std::vector<Term> terms);

  const std::vector<Term>& terms() const noexcept { return terms_; }
  bool is_zero() const noexcept { return terms_.empty(); }

  Polynomial& operator+=(const Polynomial& other);
  Polynomial& operator-=(const Polynomial& other);
  Polynomial& operator*=(long double factor);

 private:
  Polynomial& add(const Polynomial& other, long double factor);
  std::vector<Term> terms_;
};

inline Polynomial operator+(Polynomial a, const Polynomial& b) {
  return a += b;
}
inline Polynomial operator-(Polynomial a, const Polynomial& b) {
  return a -= b;
}
inline Polynomial operator*(long double factor, Polynomial a) {
  return a *= factor;
}

/// Whether all terms agree but for rounding.
bool same(const Polynomial& a, const Polynomial& b);

/// Products of letters, each once.
class MonomialTable {
 public:
  /// Letter number and exponent, letters ascending, exponents not 0.
  struct Power {
    int letter = 0;
    int exponent = 1;
    // NOLINTNEXTLINE(modernize-use-nullptr): the compiler compares with 0
    auto operator<=>(const Power&) const = default;
  };
  using Powers = std::vector<Power>;

  MonomialTable() : powers_(1), numbers_{{{}, 0}} {}
  Monomial intern(const Powers& powers);
  Monomial letter(int number) { return intern({{number, 1}}); }
  Monomial product(Monomial a, Monomial b);
  const Powers& powers(Monomial monomial) const { return powers_[monomial]; }

 private:
  std::vector<Powers> powers_;
  std::map<Powers, Monomial> numbers_;
  std::map<std::pair<Monomial, Monomial>, Monomial> products_;
};

Polynomial multiply(MonomialTable& table, const Polynomial& a, const Polynomial& b);

/// a cos(wave) + sign * b sin(wave): a step of a rotation. The cheap special case of multiply().
Polynomial turn(const Polynomial& a, const Polynomial& b, const Wave& wave, long double sign);

}  // namespace geodesic::tools::derive
