// The rules that hold for every drive protocol, each as a test of the ODrive family.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/drivers/odrive/bench.hpp"

namespace geodesic::drivers::odrive::test {
namespace {

using control::DriveCondition;

TEST(OdriveRules, NumbersThatAreNotFiniteAreRefusedBeforeEncoding) {
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity(),
                           -std::numeric_limits<double>::infinity()}) {
    for (double DriveCommand::*member :
         {&DriveCommand::torque_nm, &DriveCommand::position_rad, &DriveCommand::velocity_rad_s,
          &DriveCommand::stiffness_nm_rad, &DriveCommand::damping_nm_s_rad}) {
      Bench bench;
      ASSERT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
      bench.drive.set_shaft(0.0, 2.0);
      bench.cycle(enable(1.0));
      DriveCommand command = enable(1.0);
      command.*member = bad;
      bench.cycle(command);
      EXPECT_EQ(decode(bench.sent.back(), kSetInputTorque.fields[0]), 0.0);
      EXPECT_EQ(bench.torque(), 0.0);
      ASSERT_NE(bench.driver.complaint().quantity, nullptr);
      EXPECT_TRUE(std::isnan(bench.driver.complaint().found));
    }
  }
  Bench bench;  // finite numbers whose product is not
  ASSERT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
  DriveCommand command = enable(0.0);
  command.stiffness_nm_rad = 1e300;
  command.position_rad = 1e300;
  bench.cycle(command);
  EXPECT_EQ(bench.torque(), 0.0);
}

TEST(OdriveRules, CommandsAreClampedToTheJointsLimits) {
  Bench bench;
  ASSERT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
  for (const double torque : {1e30, -1e30, 2.5, -2.5}) {
    bench.cycle(enable(torque));
    EXPECT_EQ(decode(bench.sent.back(), kSetInputTorque.fields[0]), std::copysign(2.0, torque));
  }
}

TEST(OdriveRules, TorqueIsExactlyWhatWasAskedForZeroAmongThem) {
  for (int i = -2000; i <= 2000; ++i) {
    const double torque = i * 1e-3;
    const auto frame = encode(1, kSetInputTorque, {torque});
    EXPECT_EQ(*decode(*frame, kSetInputTorque.fields[0]),
              static_cast<double>(static_cast<float>(torque)));
  }
}

TEST(OdriveRules, ScalingIsConfiguredAndComparedNeverGuessed) {
  Bench bench(endpoint_options());
  bench.drive.set_parameter(Parameter::kTorqueConstant, 0.2);
  ASSERT_GT(bench.run_until(DriveCondition::kRefused), 0);
  bench.run(50);
  EXPECT_FALSE(bench.reported);
}

TEST(OdriveRules, RepliesHaveATimeOut) {
  Bench bench;
  bench.deaf = true;
  bench.run(101);
  EXPECT_EQ(bench.sent.size(), 6U);  // one request in 20 ms
}

TEST(OdriveRules, TheDrivesWatchdogIsSetAndSeenToWork) {
  for (const DriveOptions& options : {bench_options(), endpoint_options(), old_options()}) {
    Bench bench(options);
    ASSERT_GT(bench.run_until(DriveCondition::kEnabled, enable(1.0)), 0);
    bench.cycle(enable(1.0));
    EXPECT_GT(bench.torque(), 0.0);
    bench.cut = true;
    bench.run(52, enable(1.0));
    EXPECT_EQ(bench.torque(), 0.0);
  }
}

TEST(OdriveRules, AfterAFaultOrWatchdogTorqueDoesNotComeBackByItself) {
  for (DriveOptions options : {bench_options(), endpoint_options(), old_options()}) {
    options.clear_errors = true;  // which is for start-up only
    Bench bench(options);
    ASSERT_GT(bench.run_until(DriveCondition::kEnabled, enable(1.0)), 0);
    bench.cut = true;
    bench.run(200, enable(1.0));
    bench.cut = false;
    bench.run(500, enable(1.0));
    EXPECT_NE(bench.driver.state().condition, DriveCondition::kEnabled);
    EXPECT_EQ(bench.torque(), 0.0);
    // Even if somebody clears and enables it behind our back.
    const bool old = Settings(options).firmware == Firmware::k05;
    bench.tell(*encode(kNode, old ? kClearErrors05 : kClearErrors06, {}));
    bench.tell(*encode(kNode, kSetAxisState, {kAxisClosedLoop}));
    for (int i = 0; i < 150; ++i) {
      bench.cycle(enable(1.0));
      EXPECT_EQ(bench.torque(), 0.0);
    }
    EXPECT_FALSE(bench.drive.enabled());
    bench.cycle();
    EXPECT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
  }
}

TEST(OdriveRules, NoTorqueFrameIsAnyOtherCommand) {
  // An identifier of its own: whatever the number, the frame is a torque.
  for (const double torque : {0.0, -0.0, 1e-38, 3.4e38, -3.4e38}) {
    const auto frame = encode(kNode, kSetInputTorque, {torque});
    EXPECT_EQ(command_of(*frame), Command::kInputTorque);
    EXPECT_EQ(find_message(Firmware::k06, frame->id & kCommandMask), &kSetInputTorque);
  }
}

}  // namespace
}  // namespace geodesic::drivers::odrive::test
