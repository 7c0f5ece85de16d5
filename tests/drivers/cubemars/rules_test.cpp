// The rules that hold for every drive protocol, each as a test of the CubeMars family.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "drivers/cubemars/family.hpp"
#include "tests/drivers/cubemars/bench.hpp"

namespace geodesic::drivers::cubemars::test {
namespace {

using control::DriveCondition;

TEST(CubemarsRules, NumbersThatAreNotFiniteAreRefusedBeforeEncoding) {
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity(),
                           -std::numeric_limits<double>::infinity()}) {
    EXPECT_FALSE(encode_mit(1, {.position_rad = bad}, kRanges));
    EXPECT_FALSE(encode_mit(1, {.velocity_rad_s = bad}, kRanges));
    EXPECT_FALSE(encode_mit(1, {.stiffness_nm_rad = bad}, kRanges));
    EXPECT_FALSE(encode_mit(1, {.damping_nm_s_rad = bad}, kRanges));
    EXPECT_FALSE(encode_mit(1, {.torque_nm = bad}, kRanges));
    EXPECT_FALSE(encode_servo(1, {Function::kCurrent, bad}));
    for (double DriveCommand::*member :
         {&DriveCommand::torque_nm, &DriveCommand::position_rad, &DriveCommand::velocity_rad_s,
          &DriveCommand::stiffness_nm_rad, &DriveCommand::damping_nm_s_rad}) {
      Bench bench;
      ASSERT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
      bench.drive.set_shaft(0.0, 2.0);
      DriveCommand command = enable(5.0);
      command.*member = bad;
      bench.cycle(command);
      EXPECT_NEAR(bench.drive.torque_nm(bench.now_ns), -2.0 * Driver::kFallbackDamping, 0.03);
      ASSERT_NE(bench.driver.complaint().quantity, nullptr);
      EXPECT_TRUE(std::isnan(bench.driver.complaint().found));
    }
  }
}

TEST(CubemarsRules, CommandsAreClampedToTheDrivesLimits) {
  const auto high = decode_mit(*encode_mit(1, {1e3, 1e3, 1e4, 1e3, 1e3}, kRanges), kRanges);
  const auto low = decode_mit(*encode_mit(1, {-1e3, -1e3, -1.0, -1.0, -1e3}, kRanges), kRanges);
  EXPECT_DOUBLE_EQ(high->position_rad, 12.5);
  EXPECT_DOUBLE_EQ(high->velocity_rad_s, 50.0);
  EXPECT_DOUBLE_EQ(high->stiffness_nm_rad, 500.0);
  EXPECT_DOUBLE_EQ(high->damping_nm_s_rad, 5.0);
  EXPECT_DOUBLE_EQ(high->torque_nm, 18.0);
  EXPECT_DOUBLE_EQ(low->torque_nm, -18.0);
  EXPECT_DOUBLE_EQ(low->damping_nm_s_rad, 0.0);
  Bench servo(servo_options());
  ASSERT_GT(servo.run_until(DriveCondition::kEnabled, enable()), 0);
  servo.cycle(enable(-1e6));
  EXPECT_NEAR(decode_servo(servo.sent.back())->value * 0.115 * 9.0, -18.0, 1e-3);
}

TEST(CubemarsRules, NumbersAreRoundedToNearestSoThatTheMeanErrorVanishes) {
  double sum = 0.0;
  constexpr int kSamples = 20'000;
  for (int i = 0; i < kSamples; ++i) {
    const double torque = -17.0 + 34.0 * i / kSamples;
    sum += decode_mit(*encode_mit(1, {.torque_nm = torque}, kRanges), kRanges)->torque_nm - torque;
  }
  EXPECT_LT(std::abs(sum / kSamples), 0.02 * 36.0 / 4095.0);  // truncation: half a code
}

TEST(CubemarsRules, ScalingIsConfigurationNeverGuessed) {
  DriveOptions options = bench_options();
  options.velocity_range_rad_s = 0.0;
  EXPECT_FALSE(check(options).empty());
  // And held against what the drive shows: driver_test, AWrongVelocityRangeShows...
  Bench bench;
  bench.drive.set_ranges(22.5, 18.0);
  ASSERT_GT(bench.run_until(DriveCondition::kDisabled), 0);
  bench.move(3.0, 6000);
  EXPECT_EQ(bench.driver.state().condition, DriveCondition::kRefused);
}

TEST(CubemarsRules, RepliesHaveATimeOutOfTheirOwn) {
  Bench bench;
  bench.cut = true;
  bench.run(21);
  EXPECT_EQ(bench.sent.size(), 2U);
  bench.cut = false;
  bench.drive.set_watchdog_ns(0);  // the drive has none, and it cannot be set by CAN
  ASSERT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
  bench.cycle(enable(5.0));
  bench.deaf = true;
  bench.run(30, enable(5.0));  // our own ends it
  EXPECT_FALSE(bench.drive.enabled());
}

TEST(CubemarsRules, AfterAFaultOrWatchdogTorqueDoesNotComeBackByItself) {
  DriveOptions options = bench_options();
  options.clear_errors = true;
  Bench bench(options);
  ASSERT_GT(bench.run_until(DriveCondition::kEnabled, enable(5.0)), 0);
  bench.cut = true;
  bench.run(30, enable(5.0));
  bench.cut = false;
  bench.run(500, enable(5.0));
  EXPECT_EQ(bench.driver.state().condition, DriveCondition::kDisabled);
  EXPECT_EQ(bench.drive.torque_nm(bench.now_ns), 0.0);
  bench.driver.restart();  // nor by a restart, while it is still told to be enabled
  bench.run(100, enable(5.0));
  EXPECT_FALSE(bench.drive.enabled());
  bench.cycle();
  EXPECT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
}

TEST(CubemarsRules, NoControlFrameEverEqualsASpecialFrame) {
  for (std::uint32_t code = 0xFF0; code <= 0xFFF; ++code) {
    const double torque = from_code(code, -18.0, 18.0, 12);
    const auto frame = encode_mit(1, {12.5, 50.0, 500.0, 5.0, torque}, kRanges);
    ASSERT_TRUE(frame);
    EXPECT_FALSE(decode_special(*frame)) << code;
    EXPECT_NEAR(decode_mit(*frame, kRanges)->torque_nm, torque, 1e-12);
  }
}

}  // namespace
}  // namespace geodesic::drivers::cubemars::test
