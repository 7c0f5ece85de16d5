// Sine and cosine of many angles at once, the same to the bit on every machine: the C library's
// differ in the last bit between processors with and without fused multiply-add. Nothing else.
#pragma once

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>

namespace geodesic::control {

struct SineCosine {
  double sine = 0.0;
  double cosine = 1.0;
};

namespace sine_cosine_detail {

/// pi/2 in three parts; the first two have 33 bits, so that their products with a quarter turn's
/// number below 2^20 are exact (Cody, Waite 1980).
inline constexpr double kQuarter1 = 0x1.921fb544p+0;
inline constexpr double kQuarter2 = 0x1.0b4611a6p-34;
inline constexpr double kQuarter3 = 0x1.3198a2e037073p-69;
/// Adding it leaves the nearest integer in the low bits of the sum.
inline constexpr double kToInteger = 0x1.8p+52;
/// Beyond, a turn's number has too many bits.
inline constexpr double kFar = 1e6;

constexpr double inverse_factorial(int n) {
  double factorial = 1.0;
  for (int i = 2; i <= n; ++i) {
    factorial *= static_cast<double>(i);
  }
  return 1.0 / factorial;
}

/// |x| <= kFar. Errors below 1.5e-16: the series' first term left out is below 1e-19 at pi/4. No
/// branch and no call, so that a compiler makes vectors of a loop over it; each operation rounds as
/// IEEE 754 says, so that vectors of any width give the same bits.
[[gnu::always_inline]] inline void near_zero(double x, double& sine, double& cosine) noexcept {
  const double shifted = x * (2.0 * std::numbers::inv_pi) + kToInteger;
  const double turn = shifted - kToInteger;
  const double r = ((x - turn * kQuarter1) - turn * kQuarter2) - turn * kQuarter3;
  const double z = r * r;
  const double w = z * z;
  constexpr auto f = [](int n) { return inverse_factorial(n); };
  constexpr double s[] = {f(3), f(5), f(7), f(9), f(11), f(13), f(15), f(17)};
  constexpr double c[] = {f(4), f(6), f(8), f(10), f(12), f(14), f(16), f(18)};
  // Taylor's series, even and odd powers of z apart: half the latency.
  const double sine_even = -s[0] + w * (-s[2] + w * (-s[4] + w * -s[6]));
  const double sine_odd = s[1] + w * (s[3] + w * (s[5] + w * s[7]));
  const double cosine_even = c[0] + w * (c[2] + w * (c[4] + w * c[6]));
  const double cosine_odd = -c[1] + w * (-c[3] + w * (-c[5] + w * -c[7]));
  const double near_sine = r + r * (z * (sine_even + z * sine_odd));
  const double near_cosine = 1.0 - (0.5 * z - w * (cosine_even + z * cosine_odd));
  // Quarter turn k: sine and cosine change places where k is odd, signs follow its second bit.
  const auto k = std::bit_cast<std::uint64_t>(shifted);
  const std::uint64_t odd = 0U - (k & 1U);
  const auto s_bits = std::bit_cast<std::uint64_t>(near_sine);
  const auto c_bits = std::bit_cast<std::uint64_t>(near_cosine);
  sine = std::bit_cast<double>(((s_bits & ~odd) | (c_bits & odd)) ^ ((k & 2U) << 62U));
  cosine = std::bit_cast<double>(((c_bits & ~odd) | (s_bits & odd)) ^ (((k + 1U) & 2U) << 62U));
}

/// Far angles lose whole turns first: std::remainder is exact, and 2 pi's own rounding shifts the
/// angle by less than half a unit in its last place. What is not finite becomes NaN.
inline double near(double angle) noexcept {
  return std::abs(angle) <= kFar ? angle : std::remainder(angle, 2.0 * std::numbers::pi);
}

}  // namespace sine_cosine_detail

/// So many angles at once as `x` has.
/// @param x  [rad]; far ones are brought near    Real-time.
template <std::size_t kLanes>
[[gnu::always_inline]] inline void sine_cosine(double (&x)[kLanes], double* sine,
                                               double* cosine) noexcept {
  using namespace sine_cosine_detail;
  // Bits of positive numbers are ordered as the numbers are: a far one, or none, borrows.
  constexpr auto kFarBits = std::bit_cast<std::uint64_t>(kFar);
  std::uint64_t borrowed = 0;
  for (const double each : x) {
    borrowed |= kFarBits - (std::bit_cast<std::uint64_t>(each) & (~std::uint64_t{0} >> 1U));
  }
  if ((borrowed >> 63U) != 0U) [[unlikely]] {
    for (double& each : x) {
      each = near(each);
    }
  }
  double s[kLanes];
  double c[kLanes];
  for (std::size_t k = 0; k < kLanes; ++k) {
    near_zero(x[k], s[k], c[k]);
  }
  for (std::size_t k = 0; k < kLanes; ++k) {
    sine[k] = s[k];
    cosine[k] = c[k];
  }
}

/// @param n  angles [rad]; each array has room for one more where n is odd. Real-time.
inline void sine_cosine(const double* angle, std::size_t n, double* sine, double* cosine) noexcept {
  for (std::size_t i = 0; i < n; i += 2) {
    double x[2] = {angle[i], i + 1 < n ? angle[i + 1] : 0.0};
    sine_cosine(x, sine + i, cosine + i);
  }
}

/// Of one angle [rad]. Real-time.
inline SineCosine sine_cosine(double angle) noexcept {
  SineCosine result;
  sine_cosine_detail::near_zero(sine_cosine_detail::near(angle), result.sine, result.cosine);
  return result;
}

}  // namespace geodesic::control
