// The rules that hold for every drive protocol, each as a test of the CiA 402 family.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/drivers/cia402/bench.hpp"

namespace geodesic::drivers::cia402::test {
namespace {

using control::DriveCondition;

constexpr double kStep = 0.028;

TEST(Cia402Rules, NumbersThatAreNotFiniteAreRefusedBeforeEncoding) {
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity(),
                           -std::numeric_limits<double>::infinity()}) {
    EXPECT_FALSE(to_permille(bad, 28.0, 1000));
    EXPECT_FALSE(to_permille(1.0, 0.0, 1000));
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
      EXPECT_NEAR(bench.drive.torque_nm(bench.now_ns), -2.0 * Driver::kFallbackDamping, kStep);
      ASSERT_NE(bench.driver.complaint().quantity, nullptr);
      EXPECT_TRUE(std::isnan(bench.driver.complaint().found));
    }
  }
}

TEST(Cia402Rules, CommandsAreClampedToTheJointsAndTheDrivesLimits) {
  Bench bench;
  ASSERT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
  for (const double sign : {1.0, -1.0}) {
    DriveCommand command = enable(sign * 1e9);
    bench.cycle(command);
    EXPECT_EQ(decode_torque(bench.sent_on(0x203).back())->torque_permille, sign * 1500);
    command.torque_nm = 0.0;
    command.velocity_rad_s = sign * 1e9;  // held within 6 rad/s
    command.damping_nm_s_rad = 1.0;
    bench.cycle(command);
    EXPECT_NEAR(bench.drive.torque_nm(bench.now_ns), sign * 6.0, kStep);
  }
  EXPECT_EQ(to_permille(1e300, 28.0, 1500), 1500);
  EXPECT_EQ(bench.drive.dictionary().value(object::kMaxTorque), 1500U);  // and the drive's own
}

TEST(Cia402Rules, NumbersAreRoundedToNearestSoThatTheMeanErrorVanishes) {
  double sum = 0.0;
  constexpr int kSamples = 20'000;
  for (int i = 0; i < kSamples; ++i) {
    const double torque = -27.0 + 54.0 * i / kSamples;
    sum += from_permille(*to_permille(torque, 28.0, 1500), 28.0) - torque;
  }
  EXPECT_LT(std::abs(sum / kSamples), 0.02 * kStep);  // truncation away from 0 or down: half a code
}

TEST(Cia402Rules, ScalingIsReadFromTheDriveNeverGuessed) {
  for (const Object object : {object::kRatedTorque, object::kEncoderIncrements, object::kGearMotor,
                              object::kGearShaft, object::kEncoderRevolutions}) {
    Bench bench;
    bench.drive.dictionary().set_factory(object, 77);
    ASSERT_GT(bench.run_until(DriveCondition::kRefused), 0);
    EXPECT_EQ(bench.driver.complaint().found, 77.0);
    EXPECT_EQ(bench.driver.state().stamp_ns, 0);  // nothing it said was taken for a position
    bench.run(100, enable(5.0));
    EXPECT_FALSE(bench.drive.enabled());
  }
}

TEST(Cia402Rules, RepliesHaveATimeOutOfTheirOwn) {
  Bench bench;
  bench.run(10);
  bench.cut = true;
  bench.sent.clear();
  bench.run(120);
  EXPECT_EQ(bench.sent_on(0x603).size(), 3U);  // asked again every 50 ms
  bench.run(1000);
  EXPECT_EQ(bench.driver.state().condition, DriveCondition::kRefused);
  Bench enabled;
  ASSERT_GT(enabled.run_until(DriveCondition::kEnabled, enable()), 0);
  enabled.deaf = true;
  enabled.run(60, enable(5.0));
  EXPECT_NE(enabled.driver.state().condition, DriveCondition::kEnabled);
  EXPECT_FALSE(enabled.drive.enabled());  // it was told so, and told no torque
}

TEST(Cia402Rules, TheDrivesWatchdogIsSetAndEndsTorque) {
  for (const ConnectionLost lost :
       {ConnectionLost::kFault, ConnectionLost::kDisableVoltage, ConnectionLost::kQuickStop}) {
    for (const ReceiveTimer timer : {ReceiveTimer::kIfThere, ReceiveTimer::kOff}) {
      DriveOptions options = bench_options();
      put(options, Setting::kConnectionLost, static_cast<double>(lost));
      put(options, Setting::kReceiveTimer, static_cast<double>(timer));
      Bench bench(options);
      ASSERT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
      EXPECT_EQ(bench.drive.dictionary().value(object::kConsumerHeartbeat), 0x7F0032U);
      EXPECT_EQ(bench.drive.dictionary().value(object::kReceiveTimer),
                timer == ReceiveTimer::kOff ? 0U : 50U);
      bench.run(5, enable(5.0));
      EXPECT_NE(bench.drive.torque_nm(bench.now_ns + 30'000'000), 0.0);
      EXPECT_EQ(bench.drive.torque_nm(bench.now_ns + 52'000'000), 0.0);
      EXPECT_FALSE(bench.drive.enabled());
    }
  }
  // Without either, the last torque would persist: what the drive comes with.
  Bench bench;
  ASSERT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
  bench.drive.dictionary().set(object::kConsumerHeartbeat, 0);
  bench.drive.dictionary().set(object::kReceiveTimer, 0);
  bench.cycle(enable(5.0));
  EXPECT_NE(bench.drive.torque_nm(bench.now_ns + 10'000'000'000), 0.0);
}

TEST(Cia402Rules, TheHostsHeartbeatAloneFeedsTheWatchdogOfAnIdleDrive) {
  Bench bench;
  ASSERT_GT(bench.run_until(DriveCondition::kDisabled), 0);
  bench.run(500);
  EXPECT_EQ(bench.drive.nmt_state(), NmtState::kOperational);
  EXPECT_EQ(bench.driver.state().condition, DriveCondition::kDisabled);
}

TEST(Cia402Rules, AfterAFaultOrWatchdogTorqueDoesNotComeBackByItself) {
  DriveOptions options = bench_options();
  options.clear_errors = true;  // which is for start-up only
  Bench bench(options);
  ASSERT_GT(bench.run_until(DriveCondition::kEnabled, enable(5.0)), 0);
  bench.drive.inject_error(2);
  bench.run(500, enable(5.0));
  EXPECT_EQ(bench.driver.state().condition, DriveCondition::kError);
  EXPECT_EQ(bench.sent_controlwords(control_word::kFaultReset), 0U);
  std::array<Frame, 4> reply;  // even if somebody resets and enables it behind our back
  for (const std::uint16_t word : {control_word::kFaultReset, control_word::kShutdown,
                                   control_word::kSwitchOn, control_word::kEnableOperation}) {
    bench.drive.receive(encode_torque(3, {word, 100}), bench.now_ns, reply);
    bench.drive.receive(encode_sync(), bench.now_ns, reply);
  }
  ASSERT_TRUE(bench.drive.enabled());
  bench.run(2, enable(5.0));
  EXPECT_FALSE(bench.drive.enabled());
  EXPECT_NE(bench.driver.state().condition, DriveCondition::kEnabled);
  bench.cycle();
  EXPECT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
}

TEST(Cia402Rules, NoControlFrameEverEqualsASpecialFrame) {
  // Commands that are no torque have identifiers of their own; among torque frames the one special
  // bit is fault reset, which no torque can set.
  Bench bench;
  ASSERT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
  bench.sent.clear();
  for (int permille = -1500; permille <= 1500; ++permille) {
    bench.cycle(enable(permille * kStep));
  }
  for (const Frame& frame : bench.sent_on(0x203)) {
    EXPECT_EQ(decode_torque(frame)->controlword, control_word::kEnableOperation);
  }
  EXPECT_EQ(bench.sent_on(0x203).size(), 3001U);
  EXPECT_TRUE(bench.sent_on(cob::kNmt).empty());
  EXPECT_EQ(bench.driver.state().condition, DriveCondition::kEnabled);
}

}  // namespace
}  // namespace geodesic::drivers::cia402::test
