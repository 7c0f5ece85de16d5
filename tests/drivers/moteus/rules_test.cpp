// The rules that hold for every drive protocol, each as a test of the moteus family.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/drivers/moteus/bench.hpp"

namespace geodesic::drivers::moteus::test {
namespace {

using control::DriveCondition;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST(MoteusRules, NumbersThatAreNotFiniteAreRefusedBeforeEncoding) {
  for (const double bad : {std::nan(""), kInfinity, -kInfinity}) {
    for (double PositionCommand::*member :
         {&PositionCommand::velocity_rev_s, &PositionCommand::torque_nm, &PositionCommand::kp_scale,
          &PositionCommand::kd_scale, &PositionCommand::max_torque_nm}) {
      PositionCommand command;
      command.*member = bad;
      EXPECT_FALSE(encode_position({}, {}, command, false));
    }
    PositionCommand placed;
    placed.position_rev = bad;
    EXPECT_FALSE(encode_position({}, {}, placed, false));
    for (double DriveCommand::*member :
         {&DriveCommand::torque_nm, &DriveCommand::position_rad, &DriveCommand::velocity_rad_s,
          &DriveCommand::stiffness_nm_rad, &DriveCommand::damping_nm_s_rad}) {
      Bench bench;
      ASSERT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
      bench.drive.set_shaft(0.0, 2.0);
      bench.cycle(enable());
      DriveCommand command = enable(5.0);
      command.*member = bad;
      bench.cycle(command);
      EXPECT_EQ(written(bench.sent.back(), Register::kCommandKpScale), 0.0);
      EXPECT_NEAR(bench.torque(), -2.0 * Driver::kFallbackDamping, 0.02);
      ASSERT_NE(bench.driver.complaint().quantity, nullptr);
      EXPECT_TRUE(std::isnan(bench.driver.complaint().found));
    }
  }
}

TEST(MoteusRules, CommandsAreClampedToTheJointsLimits) {
  Bench bench(with(kKp, 60.0, with(kKd, 6.0)));
  ASSERT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
  DriveCommand beyond = enable(1e9);
  beyond.velocity_rad_s = -1e9;
  beyond.position_rad = 1e9;
  beyond.stiffness_nm_rad = 1.0;
  beyond.damping_nm_s_rad = 0.1;
  bench.cycle(beyond);
  const Frame& frame = bench.sent.back();
  EXPECT_EQ(written(frame, Register::kCommandTorque), 10.0);
  EXPECT_EQ(written(frame, Register::kCommandMaxTorque), 10.0);
  EXPECT_NEAR(written(frame, Register::kCommandVelocity).value(), -40.0 / kTurn, 2e-4);
  EXPECT_LE(written(frame, Register::kCommandPosition).value(), 32768.0);
  EXPECT_LE(std::abs(bench.torque()), 10.0 + 1e-6);
  beyond.stiffness_nm_rad = -5.0;
  beyond.damping_nm_s_rad = -5.0;
  bench.cycle(beyond);
  EXPECT_EQ(written(bench.sent.back(), Register::kCommandKpScale), 0.0);
  EXPECT_EQ(written(bench.sent.back(), Register::kCommandKdScale), 0.0);
}

TEST(MoteusRules, NumbersAreRoundedToNearestSoThatTheMeanErrorVanishes) {
  double sum = 0.0;
  constexpr int kSamples = 20'000;
  for (int i = 0; i < kSamples; ++i) {
    const double torque = -9.0 + 8.0 * i / kSamples;  // one sign: truncation would show half a code
    sum += from_code(to_code(torque, Quantity::kTorque, Resolution::kInt16), Quantity::kTorque,
                     Resolution::kInt16) -
           torque;
  }
  EXPECT_LT(std::abs(sum / kSamples), 0.02 * 0.01);
}

TEST(MoteusRules, ScalingIsReadFromTheDriveNeverGuessed) {
  // The registers' scaling belongs to their map's version; gains and gear to the drive's console.
  Bench bench;
  bench.drive.set_register_map(6);
  ASSERT_GT(bench.run_until(DriveCondition::kRefused), 0);
  EXPECT_EQ(bench.driver.state().stamp_ns, 0);
  Bench gains(with(kKd, 6.0));
  gains.drive.set_config({});
  ASSERT_GT(gains.run_until(DriveCondition::kRefused), 0);
  EXPECT_EQ(gains.driver.state().stamp_ns, 0);
}

TEST(MoteusRules, RepliesHaveATimeOutOfTheirOwn) {
  Bench bench;
  bench.cut = true;
  bench.run(21);
  EXPECT_EQ(bench.sent.size(), 2U);
}

TEST(MoteusRules, TheDrivesWatchdogIsSetByEveryCommandAndExpires) {
  for (const auto& [resolution, watchdog_ms] :
       {std::pair{0.0, 50}, {0.0, 47}, {1.0, 50}, {0.0, 2000}}) {
    DriveOptions options = with(kResolution, resolution);
    options.watchdog_ns = watchdog_ms * 1'000'000LL;
    Bench bench(options);
    ASSERT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
    bench.cycle(enable(5.0));
    EXPECT_NEAR(static_cast<double>(bench.drive.timeout_s()), watchdog_ms * 1e-3, 1e-6);
    bench.cut = true;
    bench.run(watchdog_ms - 1, enable(5.0));
    EXPECT_GT(bench.torque(), 4.9);
    bench.run(2, enable(5.0));
    EXPECT_EQ(bench.torque(), 0.0);
    EXPECT_EQ(bench.drive.mode(), 11);
  }
}

TEST(MoteusRules, AQueryDoesNotFeedTheWatchdog) {
  Bench bench;
  ASSERT_GT(bench.run_until(DriveCondition::kEnabled, enable(5.0)), 0);
  bench.cut = true;
  std::array<Frame, 1> reply;
  for (int i = 0; i < 60; ++i) {
    bench.cycle(enable(5.0));
    bench.drive.receive(encode_query({1, 5, 0}, {}), bench.now_ns, reply);
  }
  EXPECT_EQ(bench.drive.mode(), 11);
}

TEST(MoteusRules, AfterAFaultOrWatchdogTorqueDoesNotComeBackByItself) {
  DriveOptions options = bench_options();
  options.clear_errors = true;  // which is for start-up only
  Bench bench(options);
  ASSERT_GT(bench.run_until(DriveCondition::kEnabled, enable(5.0)), 0);
  bench.cut = true;
  bench.run(60, enable(5.0));
  bench.cut = false;
  bench.run(500, enable(5.0));
  EXPECT_EQ(bench.driver.state().condition, DriveCondition::kError);
  EXPECT_EQ(bench.torque(), 0.0);
  // Even if somebody clears it and starts it behind our back.
  std::array<Frame, 1> reply;
  bench.drive.receive(encode_stop({1, 5, 0}, {}), bench.now_ns, reply);
  PositionCommand other;
  other.torque_nm = 3.0;
  other.max_torque_nm = 3.0;
  other.watchdog_ns = 5'000'000'000;
  bench.drive.receive(encode_position({1, 5, 0}, {}, other, false).value(), bench.now_ns, reply);
  bench.run(3, enable(5.0));
  EXPECT_FALSE(bench.drive.enabled());
  EXPECT_EQ(bench.driver.state().condition, DriveCondition::kDisabled);
  bench.cycle();
  EXPECT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
}

TEST(MoteusRules, NoTorqueFrameStopsTheDriveOrSetsItsZero) {
  // There are no special frames: a frame commands by the registers it names, whatever their values.
  Bench bench(with(kKp, 60.0, with(kKd, 6.0)));
  ASSERT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
  for (int i = -1000; i <= 1000; ++i) {
    DriveCommand command = enable(0.01 * i);
    command.stiffness_nm_rad = 0.009 * std::abs(i);
    command.damping_nm_s_rad = 0.0009 * std::abs(i);
    bench.cycle(command);
    Reader reader(bench.sent.back());
    for (Entry entry; reader.next(entry);) {
      ASSERT_TRUE(entry.kind == opcode::kRead || (entry.number == 0 && entry.value == 10.0) ||
                  (entry.number >= 0x020 && entry.number <= 0x02B));
    }
    ASSERT_FALSE(reader.malformed());
    ASSERT_EQ(bench.drive.mode(), 10);
  }
}

}  // namespace
}  // namespace geodesic::drivers::moteus::test
