// Error diffusion: what a drive makes of torque codes is exact in the mean and never more than a
// code away. GEODESIC_DIFFUSION_CSV=FILE writes the figures of diffusion_plot.py.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <numbers>

#include "tests/drivers/damiao/bench.hpp"

namespace geodesic::drivers::damiao::test {
namespace {

constexpr double kRangeNm = 54.0;  // a DM8009: one code is 26 mN·m
constexpr double kCodeNm = 2.0 * kRangeNm / 4095.0;

DriveOptions options(bool diffusion) {
  DriveOptions result = bench_options();
  result.torque_range_nm = kRangeNm;
  result.error_diffusion = diffusion;
  return result;
}

class DamiaoDiffusion : public ::testing::Test {
 protected:
  DamiaoDiffusion() {
    for (Bench* bench : {&with, &without}) {
      bench->run_until(control::DriveCondition::kDisabled);
      bench->run_until(control::DriveCondition::kEnabled, enable());
    }
  }

  /// One cycle. @return what the drive makes of it
  static double made(Bench& bench, double torque_nm) {
    bench.cycle(enable(torque_nm));
    return bench.drive.torque_nm(bench.now_ns + 100'000);
  }

  /// The code next to a torque.
  static double nearest(double torque_nm) {
    return std::round((torque_nm + kRangeNm) / kCodeNm) * kCodeNm - kRangeNm;
  }

  Bench with{options(true)};
  Bench without{options(false)};
};

TEST_F(DamiaoDiffusion, TheMeanIsExactAndNoInstantIsMoreThanACodeAway) {
  constexpr int kCycles = 4000;
  for (const double torque : {0.0, 0.003, -1.2345, 7.77, -31.4, 53.9}) {
    double sum = 0.0;
    double plain = 0.0;
    for (int i = 0; i < kCycles; ++i) {
      const double one = made(with, torque);
      EXPECT_LE(std::abs(one - torque), kCodeNm + 1e-6) << torque << ", " << i;
      sum += one - torque;
      plain += made(without, torque) - torque;
    }
    EXPECT_LT(std::abs(sum) / kCycles, kCodeNm / 1000.0) << torque;
    // Rounding alone stays off by the same for ever.
    EXPECT_NEAR(plain / kCycles, nearest(torque) - torque, 1e-5) << torque;
  }
}

TEST_F(DamiaoDiffusion, TheImpulseIsExactWhileTheTorqueMoves) {
  double sum = 0.0;
  for (int i = 0; i < 5000; ++i) {
    const double wanted = 2.0 * std::sin(i * 2e-3) + 0.1 * std::sin(i * 0.71);
    const double one = made(with, wanted);
    EXPECT_LE(std::abs(one - wanted), kCodeNm + 1e-6) << i;
    sum += one - wanted;
    // At no instant is more than half a code owed.
    EXPECT_LE(std::abs(sum), 0.5 * kCodeNm + 1e-3) << i;
  }
}

TEST_F(DamiaoDiffusion, NothingIsOwedOnceTheDriveDoesNotFollow) {
  const double torque = nearest(5.0) + 0.45 * kCodeNm;  // two codes' mean at once, rounded down
  const auto fresh_after = [&](auto&& pause) {
    while (made(with, torque) > torque) {
    }
    pause();
    ASSERT_GE(with.run_until(control::DriveCondition::kEnabled, enable()), 0);
    EXPECT_NEAR(made(with, torque), nearest(torque), 1e-5);  // owes nothing
  };
  fresh_after([&] { with.run(5, disable()); });
  fresh_after([&] {
    with.driver.restart();
    with.run(50, disable());
  });
  fresh_after([&] {
    with.drive.inject_error(9);
    with.run(3, enable(torque));
    with.drive.power_cycle();
    with.run(300, {});
  });
  while (made(with, torque) > torque) {
  }
  with.cycle(enable(std::numeric_limits<double>::quiet_NaN()));
  EXPECT_NEAR(made(with, torque), nearest(torque), 1e-5);
}

TEST_F(DamiaoDiffusion, WhatClampingTakesAwayIsNotOwed) {
  for (int i = 0; i < 100; ++i) EXPECT_NEAR(made(with, 80.0), kRangeNm, 1e-5);
  double sum = 0.0;
  for (int i = 0; i < 1000; ++i) sum += made(with, -3.3) + 3.3;
  EXPECT_LE(std::abs(sum), kCodeNm);
  for (int i = 0; i < 100; ++i) EXPECT_NEAR(made(with, kRangeNm + 0.3 * kCodeNm), kRangeNm, 1e-5);
  EXPECT_LE(std::abs(made(with, 1.0) - 1.0), kCodeNm + 1e-6);
}

TEST_F(DamiaoDiffusion, WritesWhatThePlotShows) {
  const char* file = std::getenv("GEODESIC_DIFFUSION_CSV");
  std::ofstream csv;
  if (file != nullptr) csv.open(file);
  csv << "time,wanted,rounded,diffused,torque_code\n";
  double error_with = 0.0;
  double error_without = 0.0;
  for (int i = 0; i < 400; ++i) {  // gravity of a link that turns slowly
    const double time = 1e-3 * i;
    const double wanted = 0.05 + 0.06 * std::sin(2.0 * std::numbers::pi * 2.0 * time);
    const double rounded = made(without, wanted);
    const double diffused = made(with, wanted);
    csv << time << ',' << wanted << ',' << rounded << ',' << diffused << ',' << kCodeNm << '\n';
    error_without += rounded - wanted;
    error_with += diffused - wanted;
    EXPECT_LE(std::abs(error_with), 0.5 * kCodeNm + 1e-4);
  }
  EXPECT_GT(std::abs(error_without), std::abs(error_with));
}

}  // namespace
}  // namespace geodesic::drivers::damiao::test
