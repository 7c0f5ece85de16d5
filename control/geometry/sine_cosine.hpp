// Sine and cosine of many angles at once, the same to the bit on every machine: the C library's
// differ in the last bit between processors with and without fused multiply-add. Nothing else.
#pragma once

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <numbers>

namespace geodesic::control {

struct SineCosine {
  double sine = 0.0;
  double cosine = 1.0;
};

namespace sine_cosine_detail {

/// Two numbers that every x86-64 (and every aarch64) computes on at once, operation by operation as
/// IEEE 754 says: no machine can round otherwise.
using Lanes = double __attribute__((vector_size(16)));
using Bits = long long __attribute__((vector_size(16)));

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

/// |x| <= kFar. Errors below 1.5e-16: the series' first term left out is below 1e-19 at pi/4.
inline void pair(Lanes x, Lanes& sine, Lanes& cosine) noexcept {
  const Lanes shifted = x * (2.0 * std::numbers::inv_pi) + kToInteger;
  const Lanes turn = shifted - kToInteger;
  const Lanes r = ((x - turn * kQuarter1) - turn * kQuarter2) - turn * kQuarter3;
  const Lanes z = r * r;
  const Lanes w = z * z;
  constexpr auto f = inverse_factorial;
  // Taylor's series, even and odd powers of z apart: half the latency.
  const Lanes sine_even = -f(3) + w * (-f(7) + w * (-f(11) + w * -f(15)));
  const Lanes sine_odd = f(5) + w * (f(9) + w * (f(13) + w * f(17)));
  const Lanes cosine_even = f(4) + w * (f(8) + w * (f(12) + w * f(16)));
  const Lanes cosine_odd = -f(6) + w * (-f(10) + w * (-f(14) + w * -f(18)));
  const Lanes s = r + r * (z * (sine_even + z * sine_odd));
  const Lanes c = 1.0 - (0.5 * z - w * (cosine_even + z * cosine_odd));
  // Quarter turn k: sine and cosine change places where k is odd, signs follow its second bit.
  const Bits k = std::bit_cast<Bits>(shifted);
  const Bits odd = -(k & 1);
  const Bits s_bits = std::bit_cast<Bits>(s);
  const Bits c_bits = std::bit_cast<Bits>(c);
  const Bits sine_bits = ((s_bits & ~odd) | (c_bits & odd)) ^ ((k & 2) << 62);
  const Bits cosine_bits = ((c_bits & ~odd) | (s_bits & odd)) ^ (((k + 1) & 2) << 62);
  sine = std::bit_cast<Lanes>(sine_bits);
  cosine = std::bit_cast<Lanes>(cosine_bits);
}

/// Far angles lose whole turns first: std::remainder is exact, and 2 pi's own rounding shifts the
/// angle by less than half a unit in its last place. What is not finite becomes NaN.
inline double near(double angle) noexcept {
  return std::abs(angle) <= kFar ? angle : std::remainder(angle, 2.0 * std::numbers::pi);
}

}  // namespace sine_cosine_detail

/// @param n  angles [rad]; each array has room for one more where n is odd. Real-time.
inline void sine_cosine(const double* angle, std::size_t n, double* sine, double* cosine) noexcept {
  using namespace sine_cosine_detail;
  for (std::size_t i = 0; i < n; i += 2) {
    const Lanes x{near(angle[i]), i + 1 < n ? near(angle[i + 1]) : 0.0};
    Lanes s;
    Lanes c;
    pair(x, s, c);
    std::memcpy(sine + i, &s, sizeof s);
    std::memcpy(cosine + i, &c, sizeof c);
  }
}

/// Of one angle [rad]. Real-time.
inline SineCosine sine_cosine(double angle) noexcept {
  using namespace sine_cosine_detail;
  const double x = near(angle);
  Lanes s;
  Lanes c;
  pair(Lanes{x, x}, s, c);
  return {s[0], c[0]};
}

}  // namespace geodesic::control
