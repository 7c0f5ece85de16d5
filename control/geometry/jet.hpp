// Numbers that carry their rate of change along a curve, so that a templated function gives exact
// derivatives (automatic differentiation, forward mode). Vectors of them are in jet_vector.hpp.
#pragma once

#include <cmath>
#include <compare>

namespace geodesic::control {

/// The 1-jet of a curve of numbers: x(t) = value + rate t, with t^2 = 0. Whatever is computed of
/// jets is the jet of the result, by the chain rule, exact to rounding. Nested they hold mixed
/// derivatives: Jet<Jet<>> is the hyper-dual number (rate.rate is the second derivative along two
/// curves), Jet<Jet<Jet<>>> has third derivatives, and so on; since every level is a type of its
/// own, levels cannot be confused. No allocation, nothing thrown.
///
/// A function to be differentiated is a template of its scalar and finds the elementary functions
/// of double and Jet alike by `using std::sin;` in its body. Branches look at the value only.
///
/// Source: Griewank, Walther 2008, "Evaluating Derivatives", chapters 3 and 13; Fike, Alonso 2011,
/// "The development of hyper-dual numbers for exact second-derivative calculations".
/// @tparam S  double, or a Jet for the next higher order
template <class S = double>
struct Jet {
  S value{};
  S rate{};

  constexpr Jet() = default;
  /// A constant. Implicit, so that formulas read as they are written.
  constexpr Jet(double constant) : value(constant), rate(0.0) {}
  constexpr Jet(const S& value_, const S& rate_) : value(value_), rate(rate_) {}

  friend constexpr Jet operator+(const Jet& x) { return x; }
  friend constexpr Jet operator-(const Jet& x) { return {-x.value, -x.rate}; }

  friend constexpr Jet operator+(const Jet& x, const Jet& y) {
    return {x.value + y.value, x.rate + y.rate};
  }
  friend constexpr Jet operator-(const Jet& x, const Jet& y) {
    return {x.value - y.value, x.rate - y.rate};
  }
  friend constexpr Jet operator*(const Jet& x, const Jet& y) {
    return {x.value * y.value, x.value * y.rate + x.rate * y.value};
  }
  friend constexpr Jet operator/(const Jet& x, const Jet& y) {
    const S quotient = x.value / y.value;
    return {quotient, (x.rate - quotient * y.rate) / y.value};
  }

  // With constants: what is zero is not multiplied.
  friend constexpr Jet operator+(const Jet& x, double c) { return {x.value + c, x.rate}; }
  friend constexpr Jet operator+(double c, const Jet& x) { return {c + x.value, x.rate}; }
  friend constexpr Jet operator-(const Jet& x, double c) { return {x.value - c, x.rate}; }
  friend constexpr Jet operator-(double c, const Jet& x) { return {c - x.value, -x.rate}; }
  friend constexpr Jet operator*(const Jet& x, double c) { return {x.value * c, x.rate * c}; }
  friend constexpr Jet operator*(double c, const Jet& x) { return {c * x.value, c * x.rate}; }
  friend constexpr Jet operator/(const Jet& x, double c) { return {x.value / c, x.rate / c}; }
  friend constexpr Jet operator/(double c, const Jet& x) { return Jet(c) / x; }

  template <class T>
  constexpr Jet& operator+=(const T& y) {
    return *this = *this + y;
  }
  template <class T>
  constexpr Jet& operator-=(const T& y) {
    return *this = *this - y;
  }
  template <class T>
  constexpr Jet& operator*=(const T& y) {
    return *this = *this * y;
  }
  template <class T>
  constexpr Jet& operator/=(const T& y) {
    return *this = *this / y;
  }

  friend constexpr bool operator==(const Jet& x, const Jet& y) { return x.value == y.value; }
  friend constexpr std::partial_ordering operator<=>(const Jet& x, const Jet& y) {
    return x.value <=> y.value;
  }
};

namespace jet_detail {

/// f(x), given f and its derivative at x.value: the chain rule.
template <class S>
constexpr Jet<S> chain(const Jet<S>& x, const S& f, const S& slope) {
  return {f, slope * x.rate};
}

}  // namespace jet_detail

template <class S>
Jet<S> sin(const Jet<S>& x) {
  using std::cos;
  using std::sin;
  return jet_detail::chain(x, sin(x.value), cos(x.value));
}

template <class S>
Jet<S> cos(const Jet<S>& x) {
  using std::cos;
  using std::sin;
  return jet_detail::chain<S>(x, cos(x.value), -sin(x.value));
}

template <class S>
Jet<S> tan(const Jet<S>& x) {
  using std::tan;
  const S t = tan(x.value);
  return jet_detail::chain<S>(x, t, 1.0 + t * t);
}

/// Its derivatives are infinite at -1 and 1.
template <class S>
Jet<S> asin(const Jet<S>& x) {
  using std::asin;
  using std::sqrt;
  return jet_detail::chain<S>(x, asin(x.value), 1.0 / sqrt((1.0 - x.value) * (1.0 + x.value)));
}

/// Its derivatives are infinite at -1 and 1.
template <class S>
Jet<S> acos(const Jet<S>& x) {
  using std::acos;
  using std::sqrt;
  return jet_detail::chain<S>(x, acos(x.value), -1.0 / sqrt((1.0 - x.value) * (1.0 + x.value)));
}

template <class S>
Jet<S> atan(const Jet<S>& x) {
  using std::atan;
  return jet_detail::chain<S>(x, atan(x.value), 1.0 / (1.0 + x.value * x.value));
}

/// Angle of the point (x, y); undefined at the origin.
template <class S>
Jet<S> atan2(const Jet<S>& y, const Jet<S>& x) {
  using std::atan2;
  return {atan2(y.value, x.value),
          (x.value * y.rate - y.value * x.rate) / (x.value * x.value + y.value * y.value)};
}

template <class S>
Jet<S> sinh(const Jet<S>& x) {
  using std::cosh;
  using std::sinh;
  return jet_detail::chain<S>(x, sinh(x.value), cosh(x.value));
}

template <class S>
Jet<S> cosh(const Jet<S>& x) {
  using std::cosh;
  using std::sinh;
  return jet_detail::chain<S>(x, cosh(x.value), sinh(x.value));
}

template <class S>
Jet<S> tanh(const Jet<S>& x) {
  using std::tanh;
  const S t = tanh(x.value);
  return jet_detail::chain<S>(x, t, 1.0 - t * t);
}

template <class S>
Jet<S> exp(const Jet<S>& x) {
  using std::exp;
  const S e = exp(x.value);
  return jet_detail::chain<S>(x, e, e);
}

template <class S>
Jet<S> log(const Jet<S>& x) {
  using std::log;
  return jet_detail::chain<S>(x, log(x.value), 1.0 / x.value);
}

/// Its derivatives are infinite at 0, whatever x's rate.
template <class S>
Jet<S> sqrt(const Jet<S>& x) {
  using std::sqrt;
  const S root = sqrt(x.value);
  return jet_detail::chain<S>(x, root, 0.5 / root);
}

/// Distance of (x, y) from the origin, where it has no derivative.
template <class S>
Jet<S> hypot(const Jet<S>& x, const Jet<S>& y) {
  using std::hypot;
  const S h = hypot(x.value, y.value);
  return {h, (x.value * x.rate + y.value * y.rate) / h};
}

/// Not differentiable at 0, where the derivative from the right is taken.
template <class S>
Jet<S> abs(const Jet<S>& x) {
  return x.value < 0.0 ? -x : x;
}

/// Any base if the exponent is a whole number, 0 included: the powers of a polynomial end at x^0.
template <class S>
Jet<S> pow(const Jet<S>& x, double exponent) {
  using std::pow;
  if (exponent == 0.0) {
    return 1.0;
  }
  return jet_detail::chain<S>(x, pow(x.value, exponent), exponent * pow(x.value, exponent - 1.0));
}

/// Base positive.
template <class S>
Jet<S> pow(const Jet<S>& x, const Jet<S>& exponent) {
  return exp(exponent * log(x));
}

/// Base positive.
template <class S>
Jet<S> pow(double base, const Jet<S>& exponent) {
  return exp(exponent * std::log(base));
}

}  // namespace geodesic::control
