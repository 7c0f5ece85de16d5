// The CubeMars driver in servo mode against the simulated drive: current for torque, and reports by
// the drive's own timer.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/drivers/cubemars/bench.hpp"

namespace geodesic::drivers::cubemars::test {
namespace {

using control::DriveCondition;

class CubemarsServo : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_GT(bench.run_until(DriveCondition::kDisabled), 0);
    EXPECT_TRUE(bench.sent.empty());  // nothing there asks without commanding
    ASSERT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
    bench.sent.clear();
  }

  void expect_out() {
    bench.run(20, enable(5.0));
    for (int i = 0; i < 300; ++i) {
      bench.cycle(enable(5.0));
      ASSERT_NE(bench.driver.state().condition, DriveCondition::kEnabled);
      ASSERT_EQ(bench.drive.torque_nm(bench.now_ns), 0.0);
      ASSERT_EQ(bench.frames, 0U);
    }
  }

  Bench bench{servo_options()};
};

TEST_F(CubemarsServo, TorqueGoesOutAsCurrent) {
  bench.cycle(enable(5.175));
  ASSERT_EQ(bench.sent.size(), 1U);
  EXPECT_EQ(bench.sent[0].id, 0x105U);
  EXPECT_TRUE(bench.sent[0].extended);
  EXPECT_NEAR(decode_servo(bench.sent[0])->value, 5.0, 1e-3);  // 5.175 / (0.115 * 9)
  EXPECT_NEAR(bench.drive.torque_nm(bench.now_ns), 5.175, 1e-3);
  bench.cycle(enable(100.0));
  EXPECT_NEAR(bench.drive.torque_nm(bench.now_ns), 18.0, 1e-2);
}

TEST_F(CubemarsServo, SpringAndDampingAreThisSides) {
  bench.drive.set_shaft(0.5, 2.0);
  bench.run(5, enable());
  DriveCommand command = enable(1.0);
  command.position_rad = 0.6;
  command.stiffness_nm_rad = 20.0;
  command.damping_nm_s_rad = 1.5;
  bench.cycle(command);
  EXPECT_NEAR(bench.drive.torque_nm(bench.now_ns), 1.0 + 20.0 * 0.1 - 1.5 * 2.0, 0.1);
  EXPECT_NEAR(bench.driver.state().position_rad, 0.5, 0.1 * std::numbers::pi / 180.0);
  EXPECT_NEAR(bench.driver.state().velocity_rad_s, 2.0, 0.01);
}

TEST_F(CubemarsServo, NothingIsOwedForACommand) {
  EXPECT_EQ(bench.driver.answers_due(1), 0U);
  EXPECT_TRUE(bench.driver.speaks_unasked());
  EXPECT_EQ(Driver(bench_options()).answers_due(1), 1U);
  EXPECT_FALSE(Driver(bench_options()).speaks_unasked());
}

TEST_F(CubemarsServo, DisablesByZeroCurrentAndThenSilence) {
  bench.cycle(enable(5.0));
  bench.sent.clear();
  bench.run(50, disable());
  ASSERT_EQ(bench.sent.size(), static_cast<std::size_t>(Driver::kReleases));
  for (const Frame& frame : bench.sent) {
    EXPECT_EQ(decode_servo(frame)->value, 0.0);
  }
  EXPECT_EQ(bench.driver.state().condition, DriveCondition::kDisabled);
  EXPECT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
}

TEST_F(CubemarsServo, SilenceOfTheDriveEndsTorqueForGood) {
  bench.cycle(enable(5.0));
  bench.deaf = true;
  bench.run(60, enable(5.0));
  bench.deaf = false;
  expect_out();
}

TEST_F(CubemarsServo, BeingSwitchedOnInOperationEndsTorqueForGood) {
  bench.run(5, enable(5.0));
  Frame announcement;
  announcement.id = 0x2C05;
  announcement.extended = true;
  announcement.length = 4;
  announcement.data = {0xFA, 0xFB, 0xFC, 0xFD};
  bench.driver.receive({announcement, bench.now_ns});
  expect_out();
  EXPECT_NE(bench.driver.complaint().quantity, nullptr);
}

TEST_F(CubemarsServo, AnErrorEndsTorqueForGood) {
  bench.cycle(enable(5.0));
  bench.drive.inject_error(7);
  bench.run(3, enable(5.0));
  EXPECT_EQ(bench.driver.state().error, 7);
  expect_out();
}

TEST_F(CubemarsServo, ADriveThatReportsTooSeldomIsNotBroughtUp) {
  Bench fresh(servo_options());
  fresh.drive.set_status_interval_ns(100'000'000);
  fresh.run(2000, enable(5.0));
  EXPECT_EQ(fresh.driver.state().condition, DriveCondition::kConfiguring);
  EXPECT_NE(fresh.driver.complaint().quantity, nullptr);
  EXPECT_TRUE(fresh.sent.empty());
  fresh.drive.set_status_interval_ns(2'000'000);
  EXPECT_GT(fresh.run_until(DriveCondition::kEnabled, enable()), 0);
}

TEST_F(CubemarsServo, ADriveInMitModeIsMissed) {
  Bench fresh(servo_options());
  fresh.drive.set_servo_mode(false);
  fresh.run(1100, enable(5.0));
  EXPECT_EQ(fresh.driver.state().condition, DriveCondition::kUnknown);
  ASSERT_NE(fresh.driver.complaint().fix, nullptr);
  EXPECT_TRUE(fresh.sent.empty());
}

TEST_F(CubemarsServo, AWrongGearRatioShowsWhenTheJointIsMoved) {
  DriveOptions wrong = servo_options();
  wrong.settings.values[kGearRatio] = 6.0;
  Bench fresh(servo_options());
  fresh.driver = Driver(wrong);
  ASSERT_GT(fresh.run_until(DriveCondition::kDisabled), 0);
  fresh.move(2.0, 6000);
  EXPECT_EQ(fresh.driver.state().condition, DriveCondition::kRefused);
  EXPECT_NEAR(fresh.driver.complaint().found, 1.5, 0.05);
}

TEST_F(CubemarsServo, NumbersThatAreNotFiniteBrake) {
  bench.drive.set_shaft(0.0, 2.0);
  bench.run(5, enable());
  bench.cycle(enable(std::nan("")));
  EXPECT_NEAR(bench.drive.torque_nm(bench.now_ns), -2.0 * Driver::kFallbackDamping, 0.02);
  EXPECT_TRUE(std::isnan(bench.driver.complaint().found));
}

}  // namespace
}  // namespace geodesic::drivers::cubemars::test
