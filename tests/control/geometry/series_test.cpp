// The coefficients of exponential maps against their defining quotients in 64-bit mantissas, and
// their Taylor series where even those would cancel.
#include "control/geometry/series.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <limits>

namespace geodesic::control {
namespace {

using Real = long double;

Real factorial(int n) {
  Real result = 1.0L;
  for (int i = 2; i <= n; ++i) {
    result *= static_cast<Real>(i);
  }
  return result;
}

/// Sum of (-1)^k weight(k) t^2k / (2k + first)!
Real taylor(Real t, int first, const std::function<Real(int)>& weight) {
  Real sum = 0.0L;
  Real power = 1.0L;
  for (int k = 0; k < 40; ++k) {
    sum += power * weight(k) / factorial(2 * k + first);
    power *= -t * t;
  }
  return sum;
}

struct Coefficient {
  const char* name;
  double (*found)(double);
  Real (*quotient)(Real);
  Real (*near_zero)(Real);
};

Real one(int /*k*/) {
  return 1.0L;
}

const Coefficient kCoefficients[] = {
    {"sinc", sinc, [](Real t) { return std::sin(t) / t; },
     [](Real t) { return taylor(t, 1, one); }},
    {"versine_second", versine_second, [](Real t) { return (1.0L - std::cos(t)) / (t * t); },
     [](Real t) { return taylor(t, 2, one); }},
    {"versine_third", versine_third, [](Real t) { return (t - std::sin(t)) / (t * t * t); },
     [](Real t) { return taylor(t, 3, one); }},
    {"versine_fourth", versine_fourth,
     [](Real t) { return (t * t + 2.0L * std::cos(t) - 2.0L) / (2.0L * t * t * t * t); },
     [](Real t) { return taylor(t, 4, one); }},
    {"versine_fifth", versine_fifth,
     [](Real t) {
       return (2.0L * t - 3.0L * std::sin(t) + t * std::cos(t)) / (2.0L * t * t * t * t * t);
     },
     [](Real t) { return taylor(t, 5, [](int k) { return static_cast<Real>(k + 1); }); }},
    {"cotangent_second", cotangent_second,
     [](Real t) { return (1.0L - 0.5L * t / std::tan(0.5L * t)) / (t * t); },
     [](Real t) {  // Bernoulli's numbers
       const Real z = t * t;
       return 1.0L / 12 +
              z * (1.0L / 720 +
                   z * (1.0L / 30240 +
                        z * (1.0L / 1209600 + z * (1.0L / 47900160 + z * (691.0L / 1307674368000 +
                                                                          z / 74724249600.0L)))));
     }},
};

TEST(GeometrySeries, ExactToRoundingAtEveryAngle) {
  constexpr double kEps = std::numeric_limits<double>::epsilon();
  for (const Coefficient& c : kCoefficients) {
    const auto expect = [&](double t, Real expected) {
      const Real error = std::abs((static_cast<Real>(c.found(t)) - expected) / expected);
      EXPECT_LE(static_cast<double>(error), 4.0 * kEps) << c.name << " at " << t;
      EXPECT_EQ(c.found(-t), c.found(t)) << c.name << " at " << t;
    };
    for (double t = 1e-300; t < 0.25; t *= 3.7) {
      expect(t, c.near_zero(static_cast<Real>(t)));
    }
    expect(0.0, c.near_zero(0.0L));
    for (double t = 0.25; t < 1.0; t += 0.011) {
      // Below 1 the fourth and fifth would cancel even here.
      const bool cotangent = c.found == cotangent_second;
      expect(t, cotangent ? c.quotient(static_cast<Real>(t)) : c.near_zero(static_cast<Real>(t)));
    }
    for (double t = 1.0; t < 3.1; t += 0.0037) {
      expect(t, c.quotient(static_cast<Real>(t)));
    }
    const double most = c.found == sinc || c.found == versine_second ? 3.1 : 6.0;
    for (double t = 3.1; t < most; t += 0.0037) {
      expect(t, c.quotient(static_cast<Real>(t)));
    }
  }
  // What two of them become at a full turn is the sine's own condition, not the quotient's.
  EXPECT_NEAR(sinc(6.0), std::sin(6.0) / 6.0, kEps);
}

}  // namespace
}  // namespace geodesic::control
