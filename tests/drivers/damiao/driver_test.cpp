// The driver in operation against the simulated drive: enabling, torque, faults, disabling.
#include "drivers/damiao/driver.hpp"

#include <gtest/gtest.h>

#include "rt/thread_health.hpp"
#include "tests/drivers/damiao/bench.hpp"

namespace geodesic::drivers::damiao::test {
namespace {

using control::DriveCondition;

/// Configured and enabled.
class DamiaoDriver : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_GT(bench.run_until(DriveCondition::kDisabled), 0);
    ASSERT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
    ASSERT_TRUE(bench.drive.enabled());
    bench.sent.clear();
  }

  /// Torque stays away for as long as the mode stays kEnable.
  void expect_out(DriveCondition condition) {
    bench.sent.clear();
    for (int i = 0; i < 500; ++i) {
      bench.cycle(enable(5.0));
      ASSERT_EQ(bench.driver.state().condition, condition);
      ASSERT_EQ(bench.drive.torque_nm(bench.now_ns), 0.0);
    }
    EXPECT_EQ(bench.sent_special(Special::kEnable), 0U);
    EXPECT_EQ(bench.sent_special(Special::kClearError), 0U);
    for (const Frame& frame : bench.sent) {
      EXPECT_EQ(frame.id, kRegisterId);
    }
  }

  Bench bench;
};

TEST_F(DamiaoDriver, MonitorsByAskingNotByCommanding) {
  Bench fresh;
  ASSERT_GT(fresh.run_until(DriveCondition::kDisabled), 0);
  fresh.sent.clear();
  fresh.run(50);
  EXPECT_EQ(fresh.sent, std::vector<Frame>(50, encode_state_request(5, false)));
  EXPECT_TRUE(fresh.reported);
}

TEST_F(DamiaoDriver, FollowsTorque) {
  for (const double torque : {0.0, 1.5, -9.9, 10.0, 42.0}) {
    bench.cycle(enable(torque));
    const double expected = std::min(torque, 10.0);
    EXPECT_NEAR(bench.drive.torque_nm(bench.now_ns), expected, 20.0 / 4095.0);
    EXPECT_NEAR(bench.driver.state().torque_nm, expected, 3.0 * 20.0 / 4095.0);
    EXPECT_EQ(bench.frames, 1U);
  }
}

TEST_F(DamiaoDriver, LetsTheDriveDampAndSpring) {
  bench.drive.set_shaft(0.5, 2.0);
  DriveCommand command = enable(1.0);
  command.position_rad = 0.6;
  command.velocity_rad_s = 1.0;
  command.stiffness_nm_rad = 20.0;
  command.damping_nm_s_rad = 1.5;
  bench.cycle(command);
  EXPECT_NEAR(bench.drive.torque_nm(bench.now_ns), 1.0 + 20.0 * 0.1 - 1.5 * 1.0, 0.03);
}

TEST_F(DamiaoDriver, ReportsWhatItMeasures) {
  bench.drive.set_shaft(-3.25, 7.5);
  bench.drive.set_temperature(61.0);
  bench.cycle(enable());
  const DriveState& state = bench.driver.state();
  EXPECT_NEAR(state.position_rad, -3.25, 25.0 / 65535.0);
  EXPECT_NEAR(state.velocity_rad_s, 7.5, 60.0 / 4095.0);
  EXPECT_EQ(state.temperature_c, 61.0);
  EXPECT_EQ(state.stamp_ns, bench.now_ns + 300'000);
  EXPECT_EQ(state.error, 0);
}

TEST_F(DamiaoDriver, EnablesWithNothingButEnableFramesAndZeroTorque) {
  Bench fresh;
  ASSERT_GT(fresh.run_until(DriveCondition::kDisabled), 0);
  fresh.sent.clear();
  fresh.deaf = true;
  fresh.run(50, enable(5.0));
  EXPECT_EQ(fresh.sent.size(), 50U);
  EXPECT_EQ(fresh.sent_special(Special::kEnable), 5U);  // one in 10 ms
  for (const Frame& frame : fresh.sent) {
    const auto command = decode_mit(frame, {12.5, 30.0, 10.0});
    EXPECT_TRUE(decode_special(frame) == Special::kEnable ||
                (command && std::abs(command->torque_nm) < 0.003));
  }
  EXPECT_LT(std::abs(fresh.drive.torque_nm(fresh.now_ns)), 0.003);
  fresh.deaf = false;
  fresh.cycle(enable(5.0));
  EXPECT_EQ(fresh.driver.state().condition, DriveCondition::kEnabled);
}

TEST_F(DamiaoDriver, GivesUpOnADriveThatDoesNotBecomeEnabled) {
  Bench fresh;
  ASSERT_GT(fresh.run_until(DriveCondition::kDisabled), 0);
  fresh.cut = true;
  fresh.run(1000, enable(5.0));
  EXPECT_EQ(fresh.sent_special(Special::kEnable), static_cast<std::size_t>(Driver::kMaxEnables));
  EXPECT_NE(fresh.driver.complaint().quantity, nullptr);
  fresh.cut = false;
  fresh.run(100, enable(5.0));
  EXPECT_FALSE(fresh.drive.enabled());
}

TEST_F(DamiaoDriver, EnableWaitsForTheConfiguration) {
  Bench fresh;
  ASSERT_GT(fresh.run_until(DriveCondition::kEnabled, enable(1.0)), 8);
  EXPECT_EQ(fresh.drive.register_raw(9), 1000U);
}

TEST_F(DamiaoDriver, DisablesByZeroTorqueThenTheDisableFrame) {
  bench.cycle(enable(5.0));
  bench.sent.clear();
  bench.deaf = true;
  bench.run(4, disable());
  EXPECT_NEAR(decode_mit(bench.sent[0], {12.5, 30.0, 10.0}).value().torque_nm, 0.0, 0.003);
  for (std::size_t i = 1; i < 4; ++i) {
    EXPECT_EQ(decode_special(bench.sent[i]), Special::kDisable);
  }
  bench.deaf = false;
  bench.run(2, disable());
  EXPECT_EQ(bench.driver.state().condition, DriveCondition::kDisabled);
  EXPECT_EQ(bench.sent.back(), encode_state_request(5, false));
  EXPECT_FALSE(bench.drive.enabled());
  EXPECT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
}

TEST_F(DamiaoDriver, TheDrivesWatchdogEndsTorqueAndItStaysAway) {
  bench.cycle(enable(5.0));
  bench.cut = true;
  bench.run(49, enable(5.0));
  EXPECT_GT(bench.drive.torque_nm(bench.now_ns), 4.9);
  bench.run(3, enable(5.0));
  EXPECT_EQ(bench.drive.torque_nm(bench.now_ns), 0.0);
  bench.cut = false;
  bench.cycle(enable(5.0));
  EXPECT_EQ(bench.driver.state().error, 13);
  expect_out(DriveCondition::kError);
}

TEST_F(DamiaoDriver, EveryErrorIsToldAndKeepsTheDriveOut) {
  for (std::uint8_t code = 2; code <= 15; ++code) {
    Bench fresh;
    ASSERT_GT(fresh.run_until(DriveCondition::kEnabled, enable()), 0);
    fresh.drive.inject_error(code);
    fresh.cycle(enable(5.0));
    EXPECT_EQ(fresh.driver.state().condition, DriveCondition::kError);
    EXPECT_EQ(fresh.driver.state().error, code);
    fresh.sent.clear();
    fresh.run(200, enable(5.0));
    EXPECT_EQ(fresh.sent_special(Special::kEnable), 0U);
    EXPECT_EQ(fresh.sent_special(Special::kClearError), 0U);
    EXPECT_EQ(fresh.drive.torque_nm(fresh.now_ns), 0.0);
  }
}

TEST_F(DamiaoDriver, HeatEndsTorque) {
  bench.drive.set_temperature(101.0);
  bench.cycle(enable(5.0));
  EXPECT_EQ(bench.driver.state().error, 12);
  bench.drive.set_temperature(40.0);
  expect_out(DriveCondition::kError);  // the drive keeps its error until it is cleared
}

TEST_F(DamiaoDriver, APowerCycleInOperationLeavesTheDriveOutUntilItIsStartedAnew) {
  bench.cycle(enable(5.0));
  bench.drive.power_cycle();
  EXPECT_EQ(bench.drive.register_raw(9), 8000U);  // what we wrote is forgotten
  bench.cycle(enable(5.0));                       // finds it out
  expect_out(DriveCondition::kDisabled);
  bench.run(10, disable());
  EXPECT_EQ(bench.drive.register_raw(9), 8000U);
  ASSERT_GT(bench.run_until(DriveCondition::kConfiguring), 0);
  ASSERT_GT(bench.run_until(DriveCondition::kDisabled), 0);
  EXPECT_EQ(bench.drive.register_raw(9), 1000U);
  EXPECT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
}

TEST_F(DamiaoDriver, ADriveThatDropsOutUntoldIsNotEnabledAgain) {
  std::array<Frame, 1> reply;
  bench.drive.receive(encode_special(5, false, Special::kDisable), bench.now_ns, reply);
  bench.cycle(enable(5.0));  // finds it out
  expect_out(DriveCondition::kDisabled);
  bench.driver.restart();  // nor by a restart, while it is still told to be enabled
  bench.run(100, enable(5.0));
  EXPECT_FALSE(bench.drive.enabled());
  bench.cycle(disable());
  EXPECT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
}

TEST_F(DamiaoDriver, ADriveEnabledByAnotherIsDisabled) {
  bench.run(5, disable());
  std::array<Frame, 1> reply;
  bench.drive.receive(encode_special(5, false, Special::kEnable), bench.now_ns, reply);
  bench.run(2);
  EXPECT_FALSE(bench.drive.enabled());
}

TEST_F(DamiaoDriver, ADriveThatWasSilentWhileIdleIsConfiguredAnew) {
  bench.run(5, disable());
  bench.cut = true;
  bench.run(150);
  bench.drive.power_cycle();
  bench.cut = false;
  ASSERT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
  EXPECT_EQ(bench.drive.register_raw(9), 1000U);
}

TEST_F(DamiaoDriver, FramesOfOthersAreNotItsOwn) {
  const DriveState before = bench.driver.state();
  Frame frame;
  frame.id = 0x15;
  frame.length = 8;
  frame.data[0] = 0x16;  // motor 6
  EXPECT_FALSE(bench.driver.receive({frame, bench.now_ns}));
  frame.data[0] = 0x15;
  frame.id = 0x16;
  EXPECT_FALSE(bench.driver.receive({frame, bench.now_ns}));
  frame.id = 0x15;
  frame.extended = true;
  EXPECT_FALSE(bench.driver.receive({frame, bench.now_ns}));
  frame.extended = false;
  frame.length = 7;
  EXPECT_FALSE(bench.driver.receive({frame, bench.now_ns}));
  EXPECT_EQ(bench.driver.state().stamp_ns, before.stamp_ns);
}

TEST_F(DamiaoDriver, AStateThatLooksLikeARegisterAnswerIsAState) {
  bench.run(250, enable());  // no register was asked for in a while
  Frame frame;
  frame.id = 0x15;
  frame.length = 8;
  frame.data = {0x05, 0x00, 0x33, 0x15, 0, 0, 30, 30};
  EXPECT_TRUE(bench.driver.receive({frame, bench.now_ns}));
  EXPECT_NEAR(bench.driver.state().position_rad, -12.5, 0.03);
}

TEST_F(DamiaoDriver, PositionGoesOnWhereTheDriveWraps) {
  for (const double speed : {30.0, -30.0}) {
    const double from = bench.driver.state().position_rad;
    double shaft = from;
    for (int i = 0; i < 2500; ++i) {  // 75 rad: three spans
      shaft += speed * 1e-3;
      bench.drive.set_shaft(shaft, speed);
      bench.cycle(enable());
      ASSERT_NEAR(bench.driver.state().position_rad, shaft, 1e-3) << i;
    }
  }
  // Back in the first span; a commanded position is one the drive can follow.
  bench.drive.set_shaft(12.4, 30.0);
  bench.run(200, enable());
  bench.drive.set_shaft(12.6, 30.0);
  bench.run(2, enable());
  DriveCommand command = enable();
  command.position_rad = bench.driver.state().position_rad;
  command.stiffness_nm_rad = 50.0;
  bench.run(2, command);
  EXPECT_NEAR(bench.drive.torque_nm(bench.now_ns), 0.0, 0.1);
}

TEST_F(DamiaoDriver, NeverAllocates) {
  bench.sent.reserve(10'000);
  Bench fresh;
  fresh.sent.reserve(10'000);
  rt::RealtimeGuard guard;
  fresh.run(50);
  fresh.run(50, enable(1.0));
  fresh.drive.inject_error(9);
  fresh.run(50, enable(1.0));
  fresh.run(50, disable());
  fresh.driver.restart();
  fresh.run(50);
  const rt::ThreadHealth seen = guard.seen();
  EXPECT_EQ(seen.allocations, 0U) << to_string(seen);
}

TEST_F(DamiaoDriver, NamesItsIdentifiers) {
  ASSERT_EQ(bench.driver.reply_ids().size(), 1U);
  EXPECT_EQ(bench.driver.reply_ids()[0].id, 0x15U);
  std::vector<std::uint32_t> ids;
  for (const IdFilter& filter : bench.driver.command_ids()) {
    ids.push_back(filter.id);
  }
  EXPECT_EQ(ids, (std::vector<std::uint32_t>{0x005, 0x105, 0x205, 0x305, 0x7FF}));
}

}  // namespace
}  // namespace geodesic::drivers::damiao::test
