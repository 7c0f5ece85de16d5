// The CubeMars driver in MIT mode against the simulated drive: start-up, torque, faults, disabling.
#include "drivers/cubemars/driver.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "rt/thread_health.hpp"
#include "tests/drivers/cubemars/bench.hpp"

namespace geodesic::drivers::cubemars::test {
namespace {

using control::DriveCondition;

/// Configured and enabled.
class CubemarsDriver : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_GT(bench.run_until(DriveCondition::kDisabled), 0);
    ASSERT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
    ASSERT_TRUE(bench.drive.enabled());
    bench.sent.clear();
  }

  /// Torque stays away for as long as the mode stays kEnable; asking on its own does not help.
  void expect_out() {
    bench.cycle(enable(5.0));
    bench.sent.clear();
    for (int i = 0; i < 500; ++i) {
      bench.cycle(enable(5.0));
      ASSERT_NE(bench.driver.state().condition, DriveCondition::kEnabled);
      ASSERT_EQ(bench.drive.torque_nm(bench.now_ns), 0.0);
    }
    EXPECT_EQ(bench.sent_special(Special::kExit), bench.sent.size());
  }

  Bench bench;
};

TEST_F(CubemarsDriver, StartsWithTheFrameThatMakesNoTorque) {
  Bench fresh;
  std::array<Frame, SimulatedDrive::kMaxReplies> reply;
  fresh.drive.receive(encode_special(5, Special::kEnter), fresh.now_ns, reply);  // left so
  ASSERT_GT(fresh.run_until(DriveCondition::kDisabled), 4);
  fresh.run(20);
  EXPECT_FALSE(fresh.drive.enabled());
  EXPECT_EQ(fresh.sent_special(Special::kExit), fresh.sent.size());
  EXPECT_TRUE(fresh.reported);
}

TEST_F(CubemarsDriver, EnablesBetweenTwoZeroCommands) {
  Bench fresh;
  std::array<Frame, SimulatedDrive::kMaxReplies> reply;
  ASSERT_GT(fresh.run_until(DriveCondition::kDisabled), 0);
  // A command that somebody left in the drive never acts.
  fresh.drive.receive(*encode_mit(5, {.torque_nm = 15.0}, kRanges), fresh.now_ns, reply);
  fresh.sent.clear();
  fresh.cycle(enable(5.0));
  ASSERT_EQ(fresh.sent.size(), 3U);
  EXPECT_NEAR(decode_mit(fresh.sent[0], kRanges)->torque_nm, 0.0, 0.005);
  EXPECT_EQ(decode_special(fresh.sent[1]), Special::kEnter);
  EXPECT_EQ(fresh.sent[2], fresh.sent[0]);
  EXPECT_LT(std::abs(fresh.drive.torque_nm(fresh.now_ns)), 0.005);
  fresh.run(2, enable(5.0));
  EXPECT_EQ(fresh.driver.state().condition, DriveCondition::kEnabled);
  EXPECT_NEAR(fresh.drive.torque_nm(fresh.now_ns), 5.0, 0.005);
}

TEST_F(CubemarsDriver, FollowsTorqueSpringAndDamping) {
  for (const double torque : {0.0, 1.5, -17.0, 18.0, 42.0}) {
    bench.cycle(enable(torque));
    EXPECT_NEAR(bench.drive.torque_nm(bench.now_ns), std::min(torque, 18.0), 0.005);
    EXPECT_EQ(bench.frames, 1U);
  }
  bench.drive.set_shaft(0.5, 2.0);
  DriveCommand command = enable(1.0);
  command.position_rad = 0.6;
  command.velocity_rad_s = 1.0;
  command.stiffness_nm_rad = 20.0;
  command.damping_nm_s_rad = 1.5;
  bench.cycle(command);
  EXPECT_NEAR(bench.drive.torque_nm(bench.now_ns), 1.0 + 20.0 * 0.1 - 1.5 * 1.0, 0.05);
}

TEST_F(CubemarsDriver, ReportsWhatItMeasuresWithRepliesOfEveryLength) {
  for (std::uint8_t bytes = 6; bytes <= 8; ++bytes) {
    Bench fresh;
    fresh.drive.set_reply_bytes(bytes);
    fresh.drive.set_shaft(-3.25, 0.0);
    ASSERT_GT(fresh.run_until(DriveCondition::kEnabled, enable()), 0) << int{bytes};
    fresh.drive.set_shaft(-3.25, 7.5);
    fresh.drive.set_temperature(61.0);
    fresh.cycle(enable());
    const DriveState& state = fresh.driver.state();
    EXPECT_NEAR(state.position_rad, -3.25, 25.0 / 65535.0);
    EXPECT_NEAR(state.velocity_rad_s, 7.5, 100.0 / 4095.0);
    EXPECT_EQ(state.temperature_c, bytes == 8 ? 61.0 : 0.0);
    EXPECT_EQ(state.stamp_ns, fresh.now_ns + 300'000);
  }
}

TEST_F(CubemarsDriver, TheTemperatureOffsetIsASetting) {
  DriveOptions options = bench_options();
  options.settings.values[kTemperatureOffset] = 0.0;
  Driver raw(options);
  Bench other;  // a drive with 40 °C more in its byte than `raw` takes off
  ASSERT_GT(other.run_until(DriveCondition::kDisabled), 0);
  other.drive.set_temperature(30.0);
  std::array<Frame, SimulatedDrive::kMaxReplies> reply;
  for (int i = 0; i < 6; ++i) {
    other.drive.receive(encode_special(5, Special::kExit), other.now_ns, reply);
    raw.receive({reply[0], other.now_ns + i});
  }
  EXPECT_EQ(raw.state().temperature_c, 70.0);
}

TEST_F(CubemarsDriver, DrivesOnOneHostIdentifierAreToldApartByByteZero) {
  Frame frame;
  frame.id = 0;
  frame.length = 8;
  frame.data[0] = 6;
  EXPECT_FALSE(bench.driver.claims(frame));
  EXPECT_FALSE(bench.driver.receive({frame, bench.now_ns}));
  frame.data[0] = 5;
  EXPECT_TRUE(bench.driver.claims(frame));
  ASSERT_EQ(bench.driver.reply_ids().size(), 3U);
  EXPECT_TRUE(bench.driver.reply_ids()[0].shared);
  EXPECT_EQ(bench.driver.command_ids().front().id, 5U);
  DriveOptions own = bench_options();
  own.reply_id = own.id;  // as the manual of 2026 has it
  EXPECT_TRUE(Driver(own).command_ids().empty());
  EXPECT_FALSE(Driver(own).reply_ids()[0].shared);
  Bench fresh(own);
  EXPECT_GT(fresh.run_until(DriveCondition::kEnabled, enable()), 0);
}

TEST_F(CubemarsDriver, DisablesByZeroTorqueThenTheFrameThatLeaves) {
  bench.cycle(enable(5.0));
  bench.sent.clear();
  bench.run(4, disable());
  EXPECT_NEAR(decode_mit(bench.sent[0], kRanges).value().torque_nm, 0.0, 0.005);
  for (std::size_t i = 1; i < 4; ++i) {
    EXPECT_EQ(decode_special(bench.sent[i]), Special::kExit);
  }
  EXPECT_EQ(bench.driver.state().condition, DriveCondition::kDisabled);
  EXPECT_FALSE(bench.drive.enabled());
  EXPECT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
}

TEST_F(CubemarsDriver, ADriveThatRecoversByItselfIsKeptOut) {
  bench.cycle(enable(5.0));
  bench.cut = true;
  bench.run(24, enable(5.0));
  EXPECT_GT(bench.drive.torque_nm(bench.now_ns), 4.9);
  bench.run(6, enable(5.0));
  EXPECT_EQ(bench.drive.torque_nm(bench.now_ns), 0.0);
  bench.cut = false;
  expect_out();
  EXPECT_NE(bench.driver.complaint().quantity, nullptr);
  bench.cycle();
  EXPECT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
}

TEST_F(CubemarsDriver, AHostThatStoodStillKeepsTheDriveOut) {
  bench.cycle(enable(5.0));
  bench.now_ns += 40'000'000;
  expect_out();
}

TEST_F(CubemarsDriver, EveryErrorIsToldAndKeepsTheDriveOut) {
  for (const int code : {1, 2, 3, 4, 5, 6, 7, 200}) {
    Bench fresh;
    ASSERT_GT(fresh.run_until(DriveCondition::kEnabled, enable()), 0);
    fresh.drive.inject_error(static_cast<std::uint8_t>(code));
    fresh.cycle(enable(5.0));
    EXPECT_EQ(fresh.driver.state().condition, DriveCondition::kError);
    EXPECT_EQ(fresh.driver.state().error, code);
    fresh.sent.clear();
    fresh.run(100, enable(5.0));
    EXPECT_EQ(fresh.sent_special(Special::kEnter), 0U);
    EXPECT_EQ(fresh.drive.torque_nm(fresh.now_ns), 0.0);
    fresh.run(50);  // its error stands: it is not brought up
    EXPECT_EQ(fresh.driver.state().condition, DriveCondition::kError);
    EXPECT_NE(fresh.driver.complaint().quantity, nullptr);
    fresh.drive.power_cycle();
    EXPECT_GT(fresh.run_until(DriveCondition::kEnabled, enable()), 0);
  }
}

TEST_F(CubemarsDriver, ADriveThatDoesNotFollowIsOut) {
  std::array<Frame, SimulatedDrive::kMaxReplies> reply;
  bench.run(10, enable(5.0));
  bench.drive.receive(encode_special(5, Special::kExit), bench.now_ns, reply);  // somebody else's
  bench.run(190, enable(5.0));
  EXPECT_EQ(bench.driver.state().condition, DriveCondition::kEnabled);
  bench.run(20, enable(5.0));
  EXPECT_EQ(bench.driver.state().condition, DriveCondition::kDisabled);
  EXPECT_EQ(bench.driver.complaint().expected, 5.0);
  expect_out();
}

TEST_F(CubemarsDriver, APowerCycleWhileSilentKeepsTheDriveOut) {
  bench.cut = true;
  bench.run(40, enable(5.0));
  bench.drive.power_cycle();
  bench.cut = false;
  expect_out();
}

TEST_F(CubemarsDriver, GivesUpOnADriveThatDoesNotAnswer) {
  Bench fresh;
  ASSERT_GT(fresh.run_until(DriveCondition::kDisabled), 0);
  fresh.cut = true;
  fresh.run(1000, enable(5.0));
  EXPECT_EQ(fresh.sent_special(Special::kEnter), static_cast<std::size_t>(Driver::kMaxEnables));
  fresh.cut = false;
  fresh.run(100, enable(5.0));
  EXPECT_FALSE(fresh.drive.enabled());
}

TEST_F(CubemarsDriver, ADriveInServoModeIsRefused) {
  Bench fresh;
  fresh.drive.set_servo_mode(true);
  fresh.run(210, enable());
  EXPECT_EQ(fresh.driver.state().condition, DriveCondition::kRefused);
  EXPECT_EQ(fresh.driver.complaint().found, 1.0);
  fresh.run(100, enable(5.0));
  EXPECT_FALSE(fresh.drive.enabled());
}

TEST_F(CubemarsDriver, AWrongVelocityRangeShowsWhenTheJointIsMoved) {
  Bench fresh;
  fresh.drive.set_ranges(65.0, 18.0);  // another firmware's, where we have 50
  ASSERT_GT(fresh.run_until(DriveCondition::kDisabled), 0);
  fresh.move(2.0, 3000);
  EXPECT_EQ(fresh.driver.state().condition, DriveCondition::kDisabled);  // one window is none
  fresh.move(-2.0, 4000);
  EXPECT_EQ(fresh.driver.state().condition, DriveCondition::kRefused);
  EXPECT_NEAR(fresh.driver.complaint().found, 50.0 / 65.0, 0.02);
  Bench right;
  ASSERT_GT(right.run_until(DriveCondition::kDisabled), 0);
  right.move(2.0, 5000);
  right.move(-4.0, 3000);
  right.move(0.2, 9000);
  EXPECT_EQ(right.driver.state().condition, DriveCondition::kDisabled);
  DriveOptions off = bench_options();
  off.settings.values[kVelocityCheck] = 0.0;
  Bench unchecked(off);
  unchecked.drive.set_ranges(65.0, 18.0);
  ASSERT_GT(unchecked.run_until(DriveCondition::kDisabled), 0);
  unchecked.move(2.0, 5000);
  EXPECT_EQ(unchecked.driver.state().condition, DriveCondition::kDisabled);
}

TEST_F(CubemarsDriver, WhereTheReportedPositionEndsSoDoesTorque) {
  bench.shaft = 0.0;
  for (int i = 0; i < 1300 && bench.driver.state().condition == DriveCondition::kEnabled; ++i) {
    bench.move(10.0, 1, enable(1.0));
  }
  EXPECT_EQ(bench.driver.state().condition, DriveCondition::kDisabled);
  EXPECT_NEAR(bench.shaft, 12.5, 0.03);
  expect_out();
}

TEST_F(CubemarsDriver, PowerOnLosesTurnsOfItsEncoder) {
  EXPECT_NEAR(position_period_rad(bench_options()), 2.0 * std::numbers::pi / 9.0, 1e-12);
  EXPECT_NEAR(position_period_rad(servo_options()), 2.0 * std::numbers::pi, 1e-12);
  bench.drive.set_shaft(1.0, 0.0);
  bench.run(10, disable());
  EXPECT_NEAR(bench.driver.state().position_rad, 1.0, 1e-3);
  bench.drive.power_cycle();
  bench.run(300, disable());
  EXPECT_NEAR(bench.driver.state().position_rad, 1.0 - 2.0 * std::numbers::pi / 9.0, 1e-3);
}

TEST_F(CubemarsDriver, ErrorDiffusionMakesTheMeanTorqueExact) {
  for (const bool diffused : {false, true}) {
    DriveOptions options = bench_options();
    options.error_diffusion = diffused;
    Bench fresh(options);
    ASSERT_GT(fresh.run_until(DriveCondition::kEnabled, enable()), 0);
    double sum = 0.0;
    for (int i = 0; i < 1000; ++i) {
      fresh.cycle(enable(0.0));
      sum += fresh.drive.torque_nm(fresh.now_ns) / 1000.0;
    }
    EXPECT_NEAR(std::abs(sum), diffused ? 0.0 : 18.0 / 4095.0, 2e-5);
  }
}

TEST_F(CubemarsDriver, FramesOfOtherFormsAreNotItsOwn) {
  const DriveState before = bench.driver.state();
  Frame frame;
  frame.id = 0;
  frame.length = 5;
  frame.data[0] = 5;
  EXPECT_FALSE(bench.driver.receive({frame, bench.now_ns}));
  frame.length = 8;
  frame.remote = true;
  EXPECT_FALSE(bench.driver.receive({frame, bench.now_ns}));
  frame.remote = false;
  frame.id = 1;
  EXPECT_FALSE(bench.driver.receive({frame, bench.now_ns}));
  EXPECT_EQ(bench.driver.state().stamp_ns, before.stamp_ns);
}

TEST_F(CubemarsDriver, NeverAllocates) {
  Bench fresh;
  Bench servo(servo_options());
  rt::RealtimeGuard guard;
  for (Bench* one : {&fresh, &servo}) {
    one->run(50);
    one->run(50, enable(1.0));
    one->drive.inject_error(3);
    one->run(50, enable(1.0));
    one->run(50, disable());
    one->driver.restart();
    one->run(50);
  }
  const rt::ThreadHealth seen = guard.seen();
  EXPECT_EQ(seen.allocations, 0U) << to_string(seen);
}

}  // namespace
}  // namespace geodesic::drivers::cubemars::test
