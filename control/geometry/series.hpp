// Coefficients of exponential maps and their Jacobians as functions of an angle, each exact to
// rounding at every angle: a series where the quotient would cancel. No vectors, no matrices.
#pragma once

#include <array>
#include <cmath>
#include <numbers>

namespace geodesic::control {

/// sin(t) / t, continued by 1 at 0. Exact to rounding everywhere: the division loses nothing.
inline double sinc(double t) noexcept {
  return t == 0.0 ? 1.0 : std::sin(t) / t;
}

/// (1 - cos t) / t^2, written so that small angles lose no digit.
inline double versine_second(double t) noexcept {
  const double half_sinc = sinc(0.5 * t);
  return 0.5 * half_sinc * half_sinc;
}

namespace series_detail {
/// Up to here the series below converge fast and without cancellation; beyond, the quotients lose
/// no digit. It is more than pi, so that no logarithm meets the seam.
inline constexpr double kEnd = 3.25;
/// Terms; the first left out is below 1e-19 of the sum at kEnd.
inline constexpr int kTerms = 15;
}  // namespace series_detail

/// (t - sin t) / t^3 = 1/3! - t^2/5! + t^4/7! - ...
inline double versine_third(double t) noexcept {
  if (std::abs(t) > series_detail::kEnd) {
    return (t - std::sin(t)) / (t * t * t);
  }
  double sum = 0.0;
  for (int k = series_detail::kTerms; k >= 0; --k) {
    sum = (1.0 - t * t * sum) / static_cast<double>((2 * k + 2) * (2 * k + 3));
  }
  return sum;
}

/// (t^2 + 2 cos t - 2) / (2 t^4) = 1/4! - t^2/6! + t^4/8! - ...
inline double versine_fourth(double t) noexcept {
  if (std::abs(t) > series_detail::kEnd) {
    return (t * t + 2.0 * std::cos(t) - 2.0) / (2.0 * t * t * t * t);
  }
  double sum = 0.0;
  for (int k = series_detail::kTerms; k >= 0; --k) {
    sum = (1.0 - t * t * sum) / static_cast<double>((2 * k + 3) * (2 * k + 4));
  }
  return 0.5 * sum;
}

/// (2 t - 3 sin t + t cos t) / (2 t^5) = 1/5! - 2 t^2/7! + 3 t^4/9! - ...
inline double versine_fifth(double t) noexcept {
  if (std::abs(t) > series_detail::kEnd) {
    return (2.0 * t - 3.0 * std::sin(t) + t * std::cos(t)) / (2.0 * t * t * t * t * t);
  }
  double sum = 1.0;
  for (int k = series_detail::kTerms; k >= 0; --k) {
    const double ratio =
        static_cast<double>(k + 2) / static_cast<double>((k + 1) * (2 * k + 6) * (2 * k + 7));
    sum = 1.0 - t * t * ratio * sum;
  }
  return sum / 120.0;
}

/// (1 - (t/2) cot(t/2)) / t^2, |t| < 2 pi: what is quadratic in the inverse Jacobian of exp.
/// Small angles by the partial fractions of the cotangent, 2 sum over n of 1 / ((2 pi n)^2 - t^2),
/// the first fraction apart and the others as a power series whose coefficients are zeta(2k) - 1.
inline double cotangent_second(double t) noexcept {
  if (std::abs(t) > 2.0) {
    const double half = 0.5 * t;
    return (1.0 - half * std::cos(half) / std::sin(half)) / (t * t);
  }
  constexpr std::array<double, 12> kZetaLessOne = {
      0.64493406684822643647,   0.082323233711138191516,  0.017343061984449139715,
      0.0040773561979443393787, 9.9457512781808533714e-4, 2.4608655330804829863e-4,
      6.1248135058704829258e-5, 1.5282259408651871733e-5, 3.8172932649998398565e-6,
      9.5396203387279611315e-7, 2.3845050272773299000e-7, 5.9608189051259479612e-8};
  const double turns = t * (0.5 * std::numbers::inv_pi);
  const double u = turns * turns;
  double sum = 0.0;
  for (std::size_t k = kZetaLessOne.size(); k-- > 0;) {
    sum = kZetaLessOne[k] + u * sum;
  }
  return (0.5 * std::numbers::inv_pi * std::numbers::inv_pi) * (1.0 / (1.0 - u) + sum);
}

}  // namespace geodesic::control
