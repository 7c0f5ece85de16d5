// The driver in operation against the simulated drive, both firmwares: enabling, torque, faults,
// disabling.
#include "drivers/odrive/driver.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>
#include <string>

#include "rt/thread_health.hpp"
#include "tests/drivers/odrive/bench.hpp"

namespace geodesic::drivers::odrive::test {
namespace {

using control::DriveCondition;

/// Configured and enabled.
class OdriveDriver : public ::testing::TestWithParam<DriveOptions> {
 protected:
  void SetUp() override {
    ASSERT_GT(bench.run_until(DriveCondition::kDisabled), 0);
    ASSERT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
    ASSERT_TRUE(bench.drive.enabled());
    bench.sent.clear();
  }

  /// Torque stays away for as long as the mode stays kEnable.
  void expect_out() {
    bench.sent.clear();
    for (int i = 0; i < 600; ++i) {
      bench.cycle(enable(1.0));
      ASSERT_NE(bench.driver.state().condition, DriveCondition::kEnabled);
      ASSERT_EQ(bench.torque(), 0.0);
    }
    EXPECT_EQ(bench.sent_states(kAxisClosedLoop), 0U);
    EXPECT_EQ(bench.sent_commands(Command::kClearErrors), 0U);
  }

  Bench bench{GetParam()};
};

std::string name_of(const ::testing::TestParamInfo<DriveOptions>& info) {
  const Settings settings(info.param);
  return settings.firmware == Firmware::k05           ? "Old"
         : settings.knows(Parameter::kEnableWatchdog) ? "Endpoints"
                                                      : "Cyclic";
}
INSTANTIATE_TEST_SUITE_P(Firmwares, OdriveDriver,
                         ::testing::Values(bench_options(), endpoint_options(), old_options()),
                         name_of);

TEST_P(OdriveDriver, FollowsTorqueWithinItsRange) {
  for (const double torque : {0.0, 0.5, -1.9, 2.0, 42.0}) {
    bench.cycle(enable(torque));
    const double expected = std::min(torque, 2.0);
    EXPECT_FLOAT_EQ(static_cast<float>(bench.torque()), static_cast<float>(expected));
    EXPECT_DOUBLE_EQ(bench.driver.state().torque_nm, expected);
    EXPECT_TRUE(bench.reported);
  }
}

TEST_P(OdriveDriver, ReportsRadians) {
  bench.drive.set_shaft(-3.25, 7.5);
  bench.run(2, enable());
  EXPECT_NEAR(bench.driver.state().position_rad, -3.25, kTurn / 16384.0);
  EXPECT_NEAR(bench.driver.state().velocity_rad_s, 7.5, 1e-5);
  EXPECT_EQ(bench.driver.state().error, 0);
}

TEST_P(OdriveDriver, SpringsAndDampsByItself) {
  bench.drive.set_shaft(0.5, 2.0);
  bench.run(2, enable());
  DriveCommand command = enable(0.1);
  command.position_rad = 0.6;
  command.velocity_rad_s = 1.0;
  command.stiffness_nm_rad = 3.0;
  command.damping_nm_s_rad = 0.2;
  bench.cycle(command);
  EXPECT_NEAR(bench.torque(), 0.1 + 3.0 * 0.1 - 0.2 * 1.0, 0.002);
  bench.muted = 0x09;  // a report that has grown old is nothing to damp by
  bench.run(30, command);
  EXPECT_NEAR(bench.torque(), 0.1, 1e-6);
}

TEST_P(OdriveDriver, DisablesByZeroTorqueThenIdle) {
  bench.cycle(enable(1.0));
  bench.sent.clear();
  bench.cycle(disable());
  EXPECT_EQ(bench.torque(), 0.0);
  EXPECT_EQ(bench.sent_states(kAxisIdle), 0U);
  ASSERT_GT(bench.run_until(DriveCondition::kDisabled, disable()), 0);
  EXPECT_FALSE(bench.drive.enabled());
  EXPECT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
}

TEST_P(OdriveDriver, TheDrivesWatchdogEndsTorqueAndItStaysAway) {
  bench.cycle(enable(1.0));
  bench.cut = true;
  bench.run(48, enable(1.0));
  EXPECT_GT(bench.torque(), 0.9);
  bench.run(3, enable(1.0));
  EXPECT_EQ(bench.torque(), 0.0);
  bench.run(120, enable(1.0));
  EXPECT_EQ(bench.driver.state().condition, DriveCondition::kError);
  EXPECT_STREQ(error_name(bench.driver.state().error), "watchdog expired");
  bench.cut = false;
  expect_out();
}

TEST_P(OdriveDriver, AWatchdogThatExpiredInOperationIsNotClearedUntold) {
  bench.cut = true;
  bench.run(200, enable(1.0));
  bench.cut = false;
  bench.run(400);
  EXPECT_EQ(bench.driver.state().condition, DriveCondition::kError);
  EXPECT_EQ(bench.sent_commands(Command::kClearErrors), 0U);
  EXPECT_NE(bench.driver.complaint().quantity, nullptr);
}

TEST_P(OdriveDriver, AStateOtherThanClosedLoopIsLostTorqueThoughNoErrorIsTold) {
  bench.tell(*encode(kNode, kSetAxisState, {kAxisIdle}));
  bench.run(120, enable(1.0));
  EXPECT_EQ(bench.driver.state().condition, DriveCondition::kDisabled);
  expect_out();
  bench.driver.restart();  // nor by a restart, while it is still told to be enabled
  bench.run(1000, enable(1.0));
  EXPECT_FALSE(bench.drive.enabled());
  bench.cycle(disable());
  EXPECT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
}

TEST_P(OdriveDriver, AnInjectedErrorIsToldByNameAndKeepsTheDriveOut) {
  const bool old = Settings(GetParam()).firmware == Firmware::k05;
  const std::uint8_t code = old ? kMotorBase + 12 : kActiveBase + 12;
  bench.drive.inject_error(code);
  bench.run(250, enable(1.0));
  EXPECT_EQ(bench.driver.state().condition, DriveCondition::kError);
  EXPECT_EQ(bench.driver.state().error, code);
  EXPECT_NE(std::string(error_name(code)).find("current limit"), std::string::npos);
  expect_out();
}

TEST_P(OdriveDriver, ALostHeartbeatIsLostTorque) {
  bench.muted = 0x01;
  bench.run(499, enable(1.0));
  EXPECT_EQ(bench.driver.state().condition, DriveCondition::kEnabled);
  bench.run(110, enable(1.0));
  EXPECT_EQ(bench.driver.state().condition, DriveCondition::kError);
  EXPECT_EQ(bench.driver.state().error, kHeartbeatLost);
  EXPECT_EQ(bench.torque(), 0.0);
  expect_out();
}

TEST_P(OdriveDriver, APowerCycleInOperationLeavesTheDriveOutUntilItIsStartedAnew) {
  bench.cycle(enable(1.0));
  bench.drive.power_cycle();
  bench.run(700, enable(1.0));
  EXPECT_NE(bench.driver.state().condition, DriveCondition::kEnabled);
  expect_out();
  bench.run(10, disable());
  EXPECT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
}

TEST_P(OdriveDriver, APowerCycleWhileIdleBringsTheStartUpAgain) {
  ASSERT_GT(bench.run_until(DriveCondition::kDisabled, disable()), 0);
  bench.drive.power_cycle();
  ASSERT_GT(bench.run_until(DriveCondition::kUnknown), 0);
  ASSERT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
  EXPECT_NEAR(bench.drive.parameter(Parameter::kWatchdogTimeout), 0.05, 1e-6);
}

TEST_P(OdriveDriver, ADriveEnabledByAnotherIsDisabled) {
  ASSERT_GT(bench.run_until(DriveCondition::kDisabled, disable()), 0);
  bench.tell(*encode(kNode, kSetAxisState, {kAxisClosedLoop}));
  ASSERT_TRUE(bench.drive.enabled());
  bench.run(120);
  EXPECT_FALSE(bench.drive.enabled());
}

TEST_P(OdriveDriver, AnInvalidEstimateIsNoPosition) {
  bench.drive.set_shaft(1.0, 0.0);
  bench.run(2, enable());
  const DriveState before = bench.driver.state();
  bench.drive.set_estimate_valid(false);
  if (Settings(GetParam()).firmware == Firmware::k05) {
    bench.drive.inject_error(kEncoderBase + 2);  // 0.5 sends 0 and says so in the heartbeat alone
    bench.muted = 0x09;
    bench.run(110, enable());
    bench.muted = 0xFFF;
  }
  bench.run(20, enable());
  EXPECT_EQ(bench.driver.state().position_rad, before.position_rad);
  EXPECT_FALSE(bench.reported);
}

TEST_P(OdriveDriver, HeatEndsTorque) {
  bench.drive.set_temperature(101.0);
  bench.run(120, enable(1.0));
  EXPECT_EQ(bench.driver.state().condition, DriveCondition::kError);
  EXPECT_NE(std::string(error_name(bench.driver.state().error)).find("temperature"),
            std::string::npos);
  bench.drive.set_temperature(40.0);
  expect_out();
}

TEST_P(OdriveDriver, FramesOfOthersAreNotItsOwn) {
  Frame frame;
  frame.id = frame_id(kNode, Command::kEstimates);
  frame.length = 8;
  const auto taken = [this](Frame other) { return bench.driver.receive({other, bench.now_ns}); };
  EXPECT_TRUE(taken(frame));
  frame.remote = true;
  EXPECT_FALSE(taken(frame));
  frame.remote = false;
  frame.extended = true;
  EXPECT_FALSE(taken(frame));
  frame.extended = false;
  frame.length = 7;
  EXPECT_FALSE(taken(frame));
  frame.length = 8;
  frame.id += 32;
  EXPECT_FALSE(taken(frame));
}

TEST_P(OdriveDriver, NeverAllocates) {
  Bench fresh(GetParam());
  rt::RealtimeGuard guard;
  fresh.run(700);
  fresh.run(300, enable(1.0));
  fresh.drive.inject_error(2);
  fresh.run(300, enable(1.0));
  fresh.run(50, disable());
  fresh.driver.restart();
  fresh.run(300);
  const rt::ThreadHealth seen = guard.seen();
  EXPECT_EQ(seen.allocations, 0U) << to_string(seen);
}

TEST_P(OdriveDriver, NamesItsIdentifiers) {
  const auto replies = [this](std::uint32_t id) {
    const std::vector<IdFilter> all = bench.driver.reply_ids();
    return std::any_of(all.begin(), all.end(),
                       [id](const IdFilter& one) { return one.matches(id, false); });
  };
  for (const std::uint32_t id : {0x0A0U, 0x0A1U, 0x0A3U, 0x0A5U, 0x0A9U, 0x0B4U}) {
    EXPECT_TRUE(replies(id)) << id;
  }
  EXPECT_FALSE(replies(0x0C9));
  for (const IdFilter& command : bench.driver.command_ids()) {
    EXPECT_FALSE(replies(command.id)) << command.id;
  }
  bool torque = false;
  for (const IdFilter& filter : bench.driver.command_ids()) {
    torque = torque || filter.id == 0x0AE;
    EXPECT_NE(filter.id, 0x0A9U);
    EXPECT_NE(filter.id, 0x0A1U);
  }
  EXPECT_TRUE(torque);
}

TEST(OdriveDriverOptions, TorqueIsReportedAsConfigured) {
  for (const bool old : {false, true}) {
    for (const bool request : {false, true}) {
      for (const double feedback : {1.0, 2.0}) {
        if (old && feedback == 1.0) {
          continue;
        }
        DriveOptions options = old ? old_options() : bench_options();
        set(options, Key::kFeedback, request ? 1.0 : 0.0);
        set(options, Key::kTorqueFeedback, feedback);
        Bench bench(options);
        ASSERT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
        bench.drive.set_shaft(0.0, 110.0);  // its limiter takes torque away
        bench.run(3, enable(1.0));
        EXPECT_LT(bench.torque(), 0.7);
        EXPECT_NEAR(bench.driver.state().torque_nm, bench.torque(), 1e-6);
      }
    }
  }
}

TEST(OdriveDriverOptions, AWatchdogThatExpiresWhileIdleIsClearedRightBeforeEnabling) {
  Bench bench(endpoint_options());
  bench.drive.set_idle_feeding(false);
  ASSERT_GT(bench.run_until(DriveCondition::kDisabled), 0);
  bench.run(100);
  EXPECT_EQ(bench.driver.state().condition, DriveCondition::kDisabled);
  bench.sent.clear();
  ASSERT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
  ASSERT_GE(bench.sent_states(kAxisClosedLoop), 1U);
  for (std::size_t i = 1; i < bench.sent.size(); ++i) {
    if (command_of(bench.sent[i]) == Command::kAxisState) {
      EXPECT_EQ(command_of(bench.sent[i - 1]), Command::kClearErrors);
    }
  }
  bench.run(300, enable(1.0));
  EXPECT_GT(bench.torque(), 0.9);
  Bench unknown;  // no endpoints: its time cannot be seen
  unknown.drive.set_idle_feeding(false);
  EXPECT_GT(unknown.run_until(DriveCondition::kRefused), 0);
}

TEST(OdriveDriverOptions, GivesUpOnADriveThatDoesNotEnterClosedLoop) {
  Bench bench(old_options());
  ASSERT_GT(bench.run_until(DriveCondition::kDisabled), 0);
  bench.sent.clear();
  for (int i = 0; i < 2000; ++i) {
    bench.cycle(enable(1.0));
    bench.tell(*encode(kNode, kSetAxisState, {kAxisIdle}));
  }
  EXPECT_EQ(bench.sent_states(kAxisClosedLoop), static_cast<std::size_t>(Driver::kMaxEnables));
  ASSERT_NE(bench.driver.complaint().quantity, nullptr);
  EXPECT_EQ(bench.driver.complaint().expected, 8.0);
}

}  // namespace
}  // namespace geodesic::drivers::odrive::test
