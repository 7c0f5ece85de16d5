// Jets against derivatives worked out by hand: every elementary function to third order, products
// and mixed derivatives, constants, comparisons, matrices.
#include "control/geometry/jet.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "control/geometry/jet_vector.hpp"

namespace geodesic::control {
namespace {

using Jet1 = Jet<>;
using Jet2 = Jet<Jet1>;
using Jet3 = Jet<Jet2>;

/// f and its first three derivatives.
using Derivatives = std::array<double, 4>;

/// x, moving along all three levels at once.
Jet3 moving(double x) {
  return {{{x, 1.0}, {1.0, 0.0}}, {{1.0, 0.0}, {0.0, 0.0}}};
}

Derivatives derivatives(const Jet3& y) {
  // All levels were seeded alike, so mixed derivatives must agree.
  EXPECT_EQ(y.rate.value.value, y.value.value.rate);
  EXPECT_NEAR(y.value.rate.rate, y.rate.value.rate, 1e-13 * (1.0 + std::abs(y.value.rate.rate)));
  return {y.value.value.value, y.rate.value.value, y.rate.rate.value, y.rate.rate.rate};
}

void expect_derivatives(const char* name, double x, const Jet3& y, const Derivatives& expected) {
  const Derivatives found = derivatives(y);
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_NEAR(found[i], expected[i], 4e-15 * (1.0 + std::abs(expected[i])))
        << name << ", derivative " << i << " at " << x;
  }
}

TEST(Jet, TrigonometricFunctions) {
  for (const double x : {-2.3, -0.4, 0.0, 0.7, 1.2, 3.0}) {
    const double s = std::sin(x), c = std::cos(x), t = std::tan(x), u = 1.0 + t * t;
    expect_derivatives("sin", x, sin(moving(x)), {s, c, -s, -c});
    expect_derivatives("cos", x, cos(moving(x)), {c, -s, -c, s});
    expect_derivatives("tan", x, tan(moving(x)),
                       {t, u, 2.0 * t * u, 2.0 * u * u + 4.0 * t * t * u});
    const double w = 1.0 + x * x;
    expect_derivatives(
        "atan", x, atan(moving(x)),
        {std::atan(x), 1.0 / w, -2.0 * x / (w * w), (6.0 * x * x - 2.0) / (w * w * w)});
  }
  for (const double x : {-0.6, 0.0, 0.25, 0.8}) {
    const double r = 1.0 / std::sqrt(1.0 - x * x), r3 = r * r * r;
    const Derivatives d = {std::asin(x), r, x * r3, (1.0 + 2.0 * x * x) * r3 * r * r};
    expect_derivatives("asin", x, asin(moving(x)), d);
    expect_derivatives("acos", x, acos(moving(x)), {std::acos(x), -d[1], -d[2], -d[3]});
  }
}

TEST(Jet, ExponentialFunctions) {
  for (const double x : {-1.7, 0.0, 0.3, 2.0}) {
    const double e = std::exp(x), sh = std::sinh(x), ch = std::cosh(x), t = std::tanh(x);
    const double u = 1.0 - t * t;
    expect_derivatives("exp", x, exp(moving(x)), {e, e, e, e});
    expect_derivatives("sinh", x, sinh(moving(x)), {sh, ch, sh, ch});
    expect_derivatives("cosh", x, cosh(moving(x)), {ch, sh, ch, sh});
    expect_derivatives("tanh", x, tanh(moving(x)),
                       {t, u, -2.0 * t * u, -2.0 * u * u + 4.0 * t * t * u});
    const double l = std::numbers::ln2, p = std::pow(2.0, x);
    expect_derivatives("2^x", x, pow(2.0, moving(x)), {p, l * p, l * l * p, l * l * l * p});
  }
}

TEST(Jet, RootsAndPowers) {
  for (const double x : {0.1, 1.0, 2.5}) {
    const double r = std::sqrt(x), l = std::log(x);
    expect_derivatives("sqrt", x, sqrt(moving(x)),
                       {r, 0.5 / r, -0.25 / (x * r), 0.375 / (x * x * r)});
    expect_derivatives("log", x, log(moving(x)), {l, 1.0 / x, -1.0 / (x * x), 2.0 / (x * x * x)});
    const double p = std::pow(x, 1.7);
    expect_derivatives(
        "x^1.7", x, pow(moving(x), 1.7),
        {p, 1.7 * p / x, 1.7 * 0.7 * p / (x * x), 1.7 * 0.7 * -0.3 * p / (x * x * x)});
    const double xx = std::pow(x, x), k = l + 1.0;
    expect_derivatives(
        "x^x", x, pow(moving(x), moving(x)),
        {xx, xx * k, xx * (k * k + 1.0 / x), xx * (k * k * k + 3.0 * k / x - 1.0 / (x * x))});
  }
  for (const double x : {-2.0, 0.0, 1.5}) {
    expect_derivatives("x^2", x, pow(moving(x), 2.0), {x * x, 2.0 * x, 2.0, 0.0});
    expect_derivatives("x^0", x, pow(moving(x), 0.0), {1.0, 0.0, 0.0, 0.0});
  }
  expect_derivatives("|x|", -1.5, abs(moving(-1.5)), {1.5, -1.0, 0.0, 0.0});
  expect_derivatives("|x|", 1.5, abs(moving(1.5)), {1.5, 1.0, 0.0, 0.0});
}

TEST(Jet, Quotients) {
  for (const double x : {-1.1, 0.4, 3.0}) {
    const Jet3 j = moving(x);
    const double i = 1.0 / x;
    expect_derivatives("1/x", x, 1.0 / j, {i, -i * i, 2.0 * i * i * i, -6.0 * i * i * i * i});
    expect_derivatives("x/2", x, j / 2.0, {x / 2.0, 0.5, 0.0, 0.0});
    // (x^2 + 1) / x = x + 1/x
    expect_derivatives("(x^2+1)/x", x, (j * j + 1.0) / j,
                       {x + i, 1.0 - i * i, 2.0 * i * i * i, -6.0 * i * i * i * i});
    expect_derivatives("3 - x", x, 3.0 - j, {3.0 - x, -1.0, 0.0, 0.0});
    Jet3 sum = j;
    sum += j;
    sum *= j;
    sum -= 2.0;
    sum /= j;  // 2 x - 2 / x
    expect_derivatives(
        "(2x^2-2)/x", x, sum,
        {2.0 * x - 2.0 * i, 2.0 + 2.0 * i * i, -4.0 * i * i * i, 12.0 * i * i * i * i});
  }
}

/// Two variables, each moving on a level of its own: all four quadrants.
TEST(Jet, MixedDerivativesOfAngleAndDistance) {
  for (const double angle : {0.3, 1.9, -2.7, -0.8}) {
    const double x = 1.3 * std::cos(angle), y = 1.3 * std::sin(angle);
    const double r2 = x * x + y * y, r = std::sqrt(r2);
    const Jet2 jx{{x, 1.0}, {0.0, 0.0}}, jy{{y, 0.0}, {1.0, 0.0}};
    const Jet2 a = atan2(jy, jx);
    EXPECT_NEAR(a.value.value, std::atan2(y, x), 1e-15);
    EXPECT_NEAR(a.value.rate, -y / r2, 1e-15);                     // d/dx
    EXPECT_NEAR(a.rate.value, x / r2, 1e-15);                      // d/dy
    EXPECT_NEAR(a.rate.rate, (y * y - x * x) / (r2 * r2), 1e-15);  // d2/dxdy
    const Jet2 h = hypot(jx, jy);
    EXPECT_NEAR(h.value.value, r, 1e-15);
    EXPECT_NEAR(h.value.rate, x / r, 1e-15);
    EXPECT_NEAR(h.rate.value, y / r, 1e-15);
    EXPECT_NEAR(h.rate.rate, -x * y / (r2 * r), 1e-15);
    const Jet2 p = pow(jx * jx, jy);  // (x^2)^y
    const double l = std::log(x * x), v = std::pow(x * x, y);
    EXPECT_NEAR(p.rate.rate, v * (2.0 / x + 2.0 * y * l / x),
                1e-14 * (1.0 + std::abs(p.rate.rate)));
  }
}

TEST(Jet, ConstantsAndBranchesLookAtTheValue) {
  const Jet2 constant = 3.0;
  EXPECT_EQ(constant.value.value, 3.0);
  EXPECT_EQ(constant.rate.value, 0.0);
  EXPECT_EQ(constant.value.rate, 0.0);
  const Jet1 a{1.0, 5.0}, b{1.0, 7.0};
  EXPECT_TRUE(a == b && a == 1.0 && a < 2.0 && 0.5 < a && a >= b && a != 3.0);
  EXPECT_FALSE(Jet1(std::nan("")) <= 1.0);
  const Jet1 minus = -a;
  EXPECT_EQ(minus.rate, -5.0);
  EXPECT_EQ((+a).rate, 5.0);
}

TEST(Jet, MatricesOfJetsAndOfNumbersMultiply) {
  Eigen::Matrix2d m;
  m << 2.0, -1.0, 0.5, 3.0;
  const Eigen::Vector2d x(0.3, -0.7), rate(1.1, 0.2);
  const Eigen::Matrix<Jet1, 2, 1> y = m * along(x, rate);
  EXPECT_LE((values(y) - m * x).norm(), 1e-15);
  EXPECT_LE((rates(y) - m * rate).norm(), 1e-15);
  const Jet1 form = along(x, rate).dot(y);
  EXPECT_NEAR(form.rate, rate.dot(m * x) + x.dot(m * rate), 1e-15);
  EXPECT_NEAR(along(x, rate).norm().rate, x.dot(rate) / x.norm(), 1e-15);
  EXPECT_EQ(rates(vary(x, 1)), Eigen::Vector2d(0.0, 1.0));
  EXPECT_EQ(rates(still(x)), Eigen::Vector2d(0.0, 0.0));
}

}  // namespace
}  // namespace geodesic::control
