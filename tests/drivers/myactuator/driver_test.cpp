// The MyActuator driver in operation against the simulated drive: torque, faults, disabling.
#include "drivers/myactuator/driver.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "rt/thread_health.hpp"
#include "tests/drivers/myactuator/bench.hpp"

namespace geodesic::drivers::myactuator::test {
namespace {

using control::DriveCondition;

/// Each of the two modes, configured and enabled.
class MyactuatorDriver : public ::testing::TestWithParam<bool> {
 protected:
  void SetUp() override {
    ASSERT_GT(bench.run_until(DriveCondition::kDisabled), 0);
    EXPECT_FALSE(bench.drive.enabled());
    ASSERT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
    ASSERT_TRUE(bench.drive.enabled());
    bench.sent.clear();
  }

  bool motion() const { return GetParam(); }
  static DriveOptions options() { return GetParam() ? motion_options() : bench_options(); }

  /// Torque stays away for as long as the mode stays kEnable.
  void expect_out() {
    bench.cycle(enable(5.0));
    bench.sent.clear();
    for (int i = 0; i < 500; ++i) {
      bench.cycle(enable(5.0));
      ASSERT_NE(bench.driver.state().condition, DriveCondition::kEnabled);
      ASSERT_EQ(bench.drive.torque_nm(bench.now_ns), 0.0);
    }
    EXPECT_EQ(bench.sent_torques(), 0U);
    EXPECT_NE(bench.driver.complaint().quantity, nullptr);
  }

  Bench bench{options()};
};

TEST_P(MyactuatorDriver, FollowsTorque) {
  for (const double torque : {0.0, 1.5, -20.0, 24.0, 100.0}) {
    bench.cycle(enable(torque));
    EXPECT_NEAR(bench.drive.torque_nm(bench.now_ns), std::min(torque, 24.0), 0.011);
    EXPECT_TRUE(bench.reported);
    EXPECT_GE(bench.frames, motion() ? 1U : 2U);
    EXPECT_LE(bench.frames, motion() ? 2U : 3U);
  }
  bench.cycle(enable(24.0));
  EXPECT_NEAR(bench.driver.state().torque_nm, 24.0, 0.02);
}

TEST_P(MyactuatorDriver, SpringAndDampingAreTheDrivesOrThisSides) {
  bench.drive.set_shaft(0.5, 2.0);
  bench.run(3, enable());
  DriveCommand command = enable(1.0);
  command.position_rad = 0.6;
  command.velocity_rad_s = 1.0;
  command.stiffness_nm_rad = 20.0;
  command.damping_nm_s_rad = 1.5;
  bench.cycle(command);
  EXPECT_NEAR(bench.drive.torque_nm(bench.now_ns), 1.0 + 20.0 * 0.1 - 1.5 * 1.0, 0.06);
}

TEST_P(MyactuatorDriver, ReportsWhatItMeasures) {
  bench.drive.set_shaft(-3.25, 7.5);
  bench.drive.set_temperature(61.0);
  bench.run(60, enable());
  const DriveState& state = bench.driver.state();
  EXPECT_NEAR(state.position_rad, -3.25, 4e-4);
  EXPECT_NEAR(state.velocity_rad_s, 7.5, 0.03);
  EXPECT_EQ(state.temperature_c, 61.0);
  EXPECT_EQ(state.stamp_ns, bench.now_ns + 300'000);
}

TEST_P(MyactuatorDriver, DisablesByZeroTorqueThenShutDown) {
  bench.cycle(enable(5.0));
  bench.sent.clear();
  bench.run(4, disable());
  EXPECT_EQ(bench.sent_torques(), 1U);
  EXPECT_GE(bench.sent_requests(Command::kShutdown), 1U);
  EXPECT_EQ(bench.driver.state().condition, DriveCondition::kDisabled);
  EXPECT_FALSE(bench.drive.enabled());
  EXPECT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
}

TEST_P(MyactuatorDriver, MonitorsWithoutCommanding) {
  bench.run(5, disable());
  bench.sent.clear();
  bench.run(100);
  EXPECT_EQ(bench.sent_torques(), 0U);
  // In motion mode a cycle has room for one of them.
  EXPECT_EQ(bench.sent_requests(Command::kAngle), GetParam() ? 50U : 100U);
  EXPECT_EQ(bench.sent_requests(Command::kStatus2), GetParam() ? 50U : 100U);
  EXPECT_GE(bench.sent_requests(Command::kStatus1), 1U);
  EXPECT_TRUE(bench.reported);
}

TEST_P(MyactuatorDriver, TheDrivesWatchdogEndsTorqueAndItStaysAway) {
  bench.cycle(enable(5.0));
  bench.cut = true;
  bench.run(49, enable(5.0));
  EXPECT_GT(bench.drive.torque_nm(bench.now_ns), 4.9);
  bench.run(5, enable(5.0));
  EXPECT_EQ(bench.drive.torque_nm(bench.now_ns), 0.0);
  bench.cut = false;
  expect_out();
  bench.cycle();
  EXPECT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
}

TEST_P(MyactuatorDriver, ACommandSentBackIsNoStateAndEndsTorque) {
  bench.drive.set_shaft(1.0, 0.0);
  bench.run(3, enable(5.0));
  // The drive's watchdog is shorter than this side thinks: only the echo tells.
  std::array<Frame, SimulatedDrive::kMaxReplies> reply;
  bench.drive.receive(encode_value(3, Command::kWatchdog, 1), bench.now_ns, reply);
  bench.now_ns += 5'000'000;
  bench.cycle(enable(5.0));
  EXPECT_NEAR(bench.driver.state().position_rad, 1.0, 1e-3);
  EXPECT_NEAR(bench.driver.state().torque_nm, 5.0, 0.02);
  EXPECT_EQ(bench.driver.state().condition, DriveCondition::kDisabled);
  bench.drive.receive(encode_value(3, Command::kWatchdog, 50), bench.now_ns, reply);
  expect_out();
}

TEST_P(MyactuatorDriver, TheDrivesNoticeOfItsWatchdogEndsTorque) {
  bench.cycle(enable(5.0));
  Frame notice;
  notice.id = 0x243;
  notice.length = 8;
  notice.data[0] = 0xF1;
  EXPECT_FALSE(bench.driver.receive({notice, bench.now_ns}));
  EXPECT_EQ(bench.driver.state().condition, DriveCondition::kDisabled);
  expect_out();
}

TEST_P(MyactuatorDriver, AHostThatStoodStillKeepsTheDriveOut) {
  bench.cycle(enable(5.0));
  bench.now_ns += 80'000'000;
  expect_out();
}

TEST_P(MyactuatorDriver, EveryErrorIsToldWithinAStatusIntervalAndKeepsTheDriveOut) {
  for (const int code : {2, 3, 4, 5, 7, 8, 9, 12, 13, 14, 15, 1, 16}) {
    Bench fresh(options());
    ASSERT_GT(fresh.run_until(DriveCondition::kEnabled, enable()), 0);
    fresh.drive.inject_error(static_cast<std::uint8_t>(code));
    EXPECT_EQ(fresh.drive.torque_nm(fresh.now_ns), 0.0);
    const double torque = code % 2 == 0 ? 0.0 : 5.0;  // lost torque brings the question forward
    const int taken = fresh.run_until(DriveCondition::kError, enable(torque));
    EXPECT_GT(taken, 0);
    EXPECT_LE(taken, code % 2 == 0 ? 51 : 2);
    EXPECT_EQ(fresh.driver.state().error, code);
    fresh.cycle(enable(5.0));
    fresh.sent.clear();
    fresh.run(100, enable(5.0));
    EXPECT_EQ(fresh.sent_torques(), 0U);
    fresh.run(50);  // its error stands: it is not brought up
    EXPECT_EQ(fresh.driver.state().condition, DriveCondition::kError);
    EXPECT_EQ(fresh.sent_requests(Command::kReset), 0U);
    fresh.drive.power_cycle();
    EXPECT_GT(fresh.run_until(DriveCondition::kEnabled, enable()), 0);
  }
}

TEST_P(MyactuatorDriver, APowerCycleWhileSilentKeepsTheDriveOut) {
  bench.cut = true;
  bench.run(70, enable(5.0));
  bench.drive.power_cycle();
  bench.cut = false;
  expect_out();
}

TEST_P(MyactuatorDriver, ADriveThatWasSilentWhileIdleIsConfiguredAnew) {
  bench.run(5, disable());
  bench.drive.set_shaft(2.0, 0.0);
  bench.run(5, disable());
  bench.cut = true;
  bench.run(80);
  bench.cut = false;
  bench.run(10);  // the first request comes back unexecuted, and is no state
  EXPECT_NEAR(bench.driver.state().position_rad, 2.0, 1e-3);
  bench.cut = true;
  bench.run(150);
  bench.cut = false;
  bench.sent.clear();
  ASSERT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
  EXPECT_EQ(bench.sent_requests(Command::kWatchdog), 1U);
}

TEST_P(MyactuatorDriver, GivesUpOnADriveThatDoesNotAnswer) {
  bench.run(5, disable());
  bench.sent.clear();
  bench.cut = true;
  bench.run(1000, enable(5.0));
  EXPECT_LE(bench.sent_torques(), 600U);
  bench.cut = false;
  bench.run(100, enable(5.0));
  EXPECT_FALSE(bench.drive.enabled());
}

TEST_P(MyactuatorDriver, FramesOfOthersAreNotItsOwn) {
  const DriveState before = bench.driver.state();
  Frame frame = encode_request(3, Command::kAngle);
  for (const std::uint32_t id : {0x143U, 0x242U, 0x244U, 0x502U}) {
    frame.id = id;
    EXPECT_FALSE(bench.driver.receive({frame, bench.now_ns}));
  }
  frame.id = 0x243;
  frame.length = 7;
  EXPECT_FALSE(bench.driver.receive({frame, bench.now_ns}));
  frame.length = 8;
  frame.extended = true;
  EXPECT_FALSE(bench.driver.receive({frame, bench.now_ns}));
  EXPECT_EQ(bench.driver.state().stamp_ns, before.stamp_ns);
}

TEST_P(MyactuatorDriver, AnAngleOfZeroOutOfNowhereMustComeTwice) {
  bench.run(5, disable());
  bench.drive.set_shaft(1.0, 0.0);
  bench.run(5, disable());
  Frame frame = encode_request(3, Command::kAngle);
  frame.id = 0x243;
  EXPECT_FALSE(bench.driver.receive({frame, bench.now_ns}));
  EXPECT_NEAR(bench.driver.state().position_rad, 1.0, 1e-3);
  EXPECT_TRUE(bench.driver.receive({frame, bench.now_ns}));
  EXPECT_EQ(bench.driver.state().position_rad, 0.0);
}

TEST_P(MyactuatorDriver, NeverAllocates) {
  Bench fresh(options());
  rt::RealtimeGuard guard;
  fresh.run(50);
  fresh.run(50, enable(1.0));
  fresh.drive.inject_error(3);
  fresh.run(80, enable(1.0));
  fresh.run(50, disable());
  fresh.driver.restart();
  fresh.run(50);
  const rt::ThreadHealth seen = guard.seen();
  EXPECT_EQ(seen.allocations, 0U) << to_string(seen);
}

INSTANTIATE_TEST_SUITE_P(Modes, MyactuatorDriver, ::testing::Values(false, true),
                         [](const auto& mode) { return mode.param ? "motion" : "current"; });

TEST(MyactuatorBrake, IsReleasedWhenEnabledAndLockedBefore) {
  Bench bench(braked_options());
  ASSERT_GT(bench.run_until(DriveCondition::kDisabled), 0);
  EXPECT_FALSE(bench.drive.brake_released());
  EXPECT_EQ(bench.sent_requests(Command::kReleaseBrake), 0U);
  ASSERT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
  EXPECT_TRUE(bench.drive.brake_released());
  bench.cycle(enable(3.0));
  EXPECT_NEAR(bench.drive.torque_nm(bench.now_ns), 3.0, 0.02);
  bench.run(5, disable());
  EXPECT_FALSE(bench.drive.brake_released());
  EXPECT_EQ(bench.driver.state().condition, DriveCondition::kDisabled);
}

TEST(MyactuatorBrake, ThatLocksByItselfEndsTorque) {
  Bench bench(braked_options());
  ASSERT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
  std::array<Frame, SimulatedDrive::kMaxReplies> reply;
  bench.drive.receive(encode_request(3, Command::kLockBrake), bench.now_ns, reply);
  bench.run(60, enable(3.0));
  EXPECT_EQ(bench.driver.state().condition, DriveCondition::kDisabled);
  EXPECT_NE(bench.driver.complaint().quantity, nullptr);
}

TEST(MyactuatorMotion, WhereTheReportedPositionEndsSoDoesTorque) {
  Bench bench(motion_options());
  ASSERT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
  double shaft = 0.0;
  for (int i = 0; i < 1400 && bench.drive.enabled(); ++i) {
    shaft += 0.01;
    bench.drive.set_shaft(shaft, 10.0);
    bench.cycle(enable(1.0));
  }
  EXPECT_NEAR(shaft, 12.5, 0.03);
  EXPECT_EQ(bench.driver.state().condition, DriveCondition::kDisabled);
}

TEST(MyactuatorMotion, AWrongVelocityRangeShowsInMotion) {
  Bench bench(motion_options());
  bench.drive.set_motion_ranges(12.5, 18.0, 24.0);
  ASSERT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
  double shaft = 0.0;
  for (int i = 0; i < 8000 && bench.drive.enabled(); ++i) {
    shaft += 0.001;
    bench.drive.set_shaft(shaft, 1.0);
    bench.cycle(enable());
  }
  EXPECT_EQ(bench.driver.state().condition, DriveCondition::kRefused);
  EXPECT_NEAR(bench.driver.complaint().found, 45.0 / 18.0, 0.1);
}

TEST(MyactuatorMotion, ErrorDiffusionMakesTheMeanTorqueExact) {
  for (const bool diffused : {false, true}) {
    DriveOptions options = motion_options();
    options.error_diffusion = diffused;
    Bench bench(options);
    ASSERT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
    double sum = 0.0;
    for (int i = 0; i < 1000; ++i) {
      bench.cycle(enable(0.0));
      sum += bench.drive.torque_nm(bench.now_ns) / 1000.0;
    }
    EXPECT_NEAR(std::abs(sum), diffused ? 0.0 : 24.0 / 4095.0, 3e-5);
  }
}

TEST(MyactuatorIdentifiers, AreNamed) {
  EXPECT_EQ(Driver(bench_options()).reply_ids().size(), 1U);
  EXPECT_EQ(Driver(motion_options()).reply_ids().size(), 2U);
  std::vector<std::uint32_t> ids;
  for (const IdFilter& filter : Driver(bench_options()).command_ids()) {
    ids.push_back(filter.id);
  }
  EXPECT_EQ(ids, (std::vector<std::uint32_t>{0x143, 0x403, 0x280, 0x300}));
}

}  // namespace
}  // namespace geodesic::drivers::myactuator::test
