// Sine and cosine against the C library's in long double; their bits must not depend on what stands
// beside an angle in the array.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <vector>

#include "control/geometry/sine_cosine.hpp"
#include "control/mechanism/compact_dispatch.hpp"

namespace geodesic::control {
namespace {

double error(double found, long double expected) {
  return static_cast<double>(std::abs(static_cast<long double>(found) - expected));
}

TEST(SineCosine, IsRightToTheLastBitOrTwo) {
  std::mt19937_64 random(3);
  for (const double range : {1e-9, 1e-3, 1.0, 4.0, 100.0, 1e4, 1e6}) {
    std::uniform_real_distribution<double> angle(-range, range);
    for (int i = 0; i < 20'000; ++i) {
      const double x = angle(random);
      const auto [s, c] = sine_cosine(x);
      ASSERT_LE(error(s, std::sin(static_cast<long double>(x))), 2.3e-16) << x;
      ASSERT_LE(error(c, std::cos(static_cast<long double>(x))), 2.3e-16) << x;
    }
  }
}

TEST(SineCosine, KeepsSmallAnglesAndExactPoints) {
  EXPECT_EQ(sine_cosine(0.0).sine, 0.0);
  EXPECT_EQ(sine_cosine(0.0).cosine, 1.0);
  for (const double x : {1e-300, -1e-20, 1e-10, -1e-8}) {
    EXPECT_EQ(sine_cosine(x).sine, x);
  }
}

TEST(SineCosine, FarAnglesStayWithinTheirOwnRounding) {
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> exponent(6.0, 12.0);
  for (int i = 0; i < 10'000; ++i) {
    const double x = std::pow(10.0, exponent(random));
    const double last_place = std::nextafter(x, 2.0 * x) - x;
    const auto [s, c] = sine_cosine(x);
    ASSERT_LE(error(s, std::sin(static_cast<long double>(x))), last_place + 1e-15) << x;
    ASSERT_LE(error(c, std::cos(static_cast<long double>(x))), last_place + 1e-15) << x;
  }
}

TEST(SineCosine, WhatIsNotFiniteGivesNotANumber) {
  for (const double x :
       {std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity(),
        std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_TRUE(std::isnan(sine_cosine(x).sine));
    EXPECT_TRUE(std::isnan(sine_cosine(x).cosine));
  }
}

TEST(SineCosine, OfManyIsThatOfEachToTheBit) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> angle(-20.0, 20.0);
  for (std::size_t n = 1; n <= 9; ++n) {
    std::vector<double> x(n);
    std::vector<double> s(n + 1);
    std::vector<double> c(n + 1);
    for (double& each : x) {
      each = angle(random);
    }
    sine_cosine(x.data(), n, s.data(), c.data());
    for (std::size_t i = 0; i < n; ++i) {
      EXPECT_EQ(s[i], sine_cosine(x[i]).sine);
      EXPECT_EQ(c[i], sine_cosine(x[i]).cosine);
    }
  }
}

TEST(SineCosine, VectorsOfAnyLengthGiveTheSameBits) {
  constexpr std::size_t kAngles = 4096;
  std::mt19937_64 random(6);
  std::uniform_real_distribution<double> angle(-20.0, 20.0);
  std::vector<double> x(kAngles);
  for (std::size_t i = 0; i < kAngles; ++i) {
    x[i] = (i % 100 == 99 ? 1e6 : 1.0) * angle(random);  // some are far
  }
  for (int r = 0; r <= static_cast<int>(widest_registers()); ++r) {
    std::vector<double> s(kAngles);
    std::vector<double> c(kAngles);
    run_with(static_cast<Registers>(r), [&](auto lanes) noexcept {
      for (std::size_t i = 0; i < kAngles; i += lanes()) {
        double some[lanes()];
        std::copy_n(&x[i], lanes(), some);
        sine_cosine(some, &s[i], &c[i]);
      }
    });
    for (std::size_t i = 0; i < kAngles; ++i) {
      ASSERT_EQ(s[i], sine_cosine(x[i]).sine) << "registers " << r << ", " << x[i];
      ASSERT_EQ(c[i], sine_cosine(x[i]).cosine) << "registers " << r << ", " << x[i];
    }
  }
}

/// The bits of any machine: these were written down once.
TEST(SineCosine, GivesTheSameBitsEverywhere) {
  std::uint64_t digest = 0xcbf29ce484222325U;
  for (int i = 0; i < 100'000; ++i) {
    const auto [s, c] = sine_cosine(0.001 * static_cast<double>(i - 50'000));
    for (const double value : {s, c}) {
      digest = (digest ^ std::bit_cast<std::uint64_t>(value)) * 0x100000001b3U;
    }
  }
  EXPECT_EQ(digest, 0x6fa2b58984c56effU);
}

}  // namespace
}  // namespace geodesic::control
