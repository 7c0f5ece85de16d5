// The rules that hold for every drive protocol, each as a test of the MyActuator family.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>

#include "drivers/myactuator/family.hpp"
#include "tests/drivers/myactuator/bench.hpp"

namespace geodesic::drivers::myactuator::test {
namespace {

using control::DriveCondition;

TEST(MyactuatorRules, NumbersThatAreNotFiniteAreRefusedBeforeEncoding) {
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity(),
                           -std::numeric_limits<double>::infinity()}) {
    EXPECT_FALSE(encode_motion(1, {.position_rad = bad}, kRanges));
    EXPECT_FALSE(encode_motion(1, {.velocity_rad_s = bad}, kRanges));
    EXPECT_FALSE(encode_motion(1, {.stiffness_nm_rad = bad}, kRanges));
    EXPECT_FALSE(encode_motion(1, {.damping_nm_s_rad = bad}, kRanges));
    EXPECT_FALSE(encode_motion(1, {.torque_nm = bad}, kRanges));
    EXPECT_FALSE(encode_torque(1, bad));
    for (const DriveOptions& options : {bench_options(), motion_options()}) {
      for (double DriveCommand::*member :
           {&DriveCommand::torque_nm, &DriveCommand::position_rad, &DriveCommand::velocity_rad_s,
            &DriveCommand::stiffness_nm_rad, &DriveCommand::damping_nm_s_rad}) {
        Bench bench(options);
        ASSERT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
        bench.drive.set_shaft(0.0, 2.0);
        bench.run(2, enable());
        DriveCommand command = enable(5.0);
        command.*member = bad;
        bench.cycle(command);
        EXPECT_NEAR(bench.drive.torque_nm(bench.now_ns), -2.0 * Driver::kFallbackDamping, 0.04);
        EXPECT_TRUE(std::isnan(bench.driver.complaint().found));
      }
    }
  }
}

TEST(MyactuatorRules, CommandsAreClampedToTheDrivesLimits) {
  const auto high = decode_motion(*encode_motion(1, {1e3, 1e3, 1e4, 1e3, 1e3}, kRanges), kRanges);
  EXPECT_DOUBLE_EQ(high->position_rad, 12.5);
  EXPECT_DOUBLE_EQ(high->velocity_rad_s, 45.0);
  EXPECT_DOUBLE_EQ(high->stiffness_nm_rad, 500.0);
  EXPECT_DOUBLE_EQ(high->damping_nm_s_rad, 5.0);
  EXPECT_DOUBLE_EQ(high->torque_nm, 24.0);
  Bench bench;
  ASSERT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
  bench.cycle(enable(-1e6));
  EXPECT_NEAR(*decode_torque(bench.sent[bench.sent.size() - bench.frames]) * 2.0, -24.0, 1e-9);
}

TEST(MyactuatorRules, NumbersAreRoundedToNearestSoThatTheMeanErrorVanishes) {
  double motion = 0.0;
  double current = 0.0;
  constexpr int kSamples = 20'000;
  for (int i = 0; i < kSamples; ++i) {
    const double wanted = -23.0 + 46.0 * i / kSamples;
    motion += decode_motion(*encode_motion(1, {.torque_nm = wanted}, kRanges), kRanges)->torque_nm -
              wanted;
    current += *decode_torque(*encode_torque(1, wanted)) - wanted;
  }
  EXPECT_LT(std::abs(motion / kSamples), 0.02 * 48.0 / 4095.0);  // truncation: half a code
  EXPECT_LT(std::abs(current / kSamples), 0.02 * 0.01);
}

TEST(MyactuatorRules, ScalingIsConfigurationHeldAgainstTheDrive) {
  DriveOptions options = bench_options();
  options.settings.values[kTorqueConstant] = kNotSet;
  EXPECT_FALSE(check(options).empty());
  Bench bench(motion_options());
  bench.drive.set_motion_ranges(95.5, 45.0, 24.0);
  bench.drive.set_shaft(0.5, 0.0);
  ASSERT_GT(bench.run_until(DriveCondition::kRefused), 0);
  EXPECT_EQ(bench.driver.state().stamp_ns, 0);  // nothing it said was taken for a position
}

TEST(MyactuatorRules, RepliesHaveATimeOutAndTheDrivesWatchdogIsSet) {
  Bench bench;
  bench.cut = true;
  bench.run(21);
  EXPECT_EQ(bench.sent_requests(Command::kStatus1), 2U);
  bench.cut = false;
  EXPECT_EQ(bench.drive.watchdog_ms(), 0U);  // off, as it comes
  ASSERT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
  EXPECT_EQ(bench.drive.watchdog_ms(), 50U);
  bench.deaf = true;
  bench.run(60, enable(5.0));  // our own ends it
  EXPECT_FALSE(bench.drive.enabled());
}

TEST(MyactuatorRules, AfterAFaultOrWatchdogTorqueDoesNotComeBackByItself) {
  DriveOptions options = bench_options();
  options.clear_errors = true;  // which is for start-up only
  Bench bench(options);
  ASSERT_GT(bench.run_until(DriveCondition::kEnabled, enable(5.0)), 0);
  bench.drive.inject_error(4);
  bench.run(500, enable(5.0));
  EXPECT_EQ(bench.driver.state().condition, DriveCondition::kError);
  EXPECT_EQ(bench.sent_requests(Command::kReset), 0U);
  bench.drive.power_cycle();  // even if the error goes away
  bench.run(500, enable(5.0));
  EXPECT_EQ(bench.drive.torque_nm(bench.now_ns), 0.0);
  bench.driver.restart();  // nor by a restart, while it is still told to be enabled
  bench.run(100, enable(5.0));
  EXPECT_FALSE(bench.drive.enabled());
  bench.cycle();
  EXPECT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
}

TEST(MyactuatorRules, NoControlFrameEverEqualsASpecialFrame) {
  // Current: byte 0 is A1 whatever the torque. Motion: an identifier that carries nothing else.
  for (int code = -32768; code <= 32767; code += 7) {
    EXPECT_EQ(encode_torque(3, code * 0.01)->data[0], 0xA1);
  }
  for (const double high : {0.0, 1.0}) {
    for (std::uint32_t code = 0xFF0; code <= 0xFFF; ++code) {
      const double torque = from_code(code, -24.0, 24.0, 12);
      const auto frame =
          encode_motion(3, {high * 12.5, high * 45.0, high * 500.0, high * 5.0, torque}, kRanges);
      EXPECT_EQ(frame->id, 0x403U);
      EXPECT_NEAR(decode_motion(*frame, kRanges)->torque_nm, torque, 1e-12);
    }
  }
  Bench bench;
  ASSERT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
  bench.sent.clear();
  bench.run(200, enable(-3.7));
  std::set<int> commands;
  for (const Frame& frame : bench.sent) {
    commands.insert(frame.data[0]);
  }
  EXPECT_EQ(commands, (std::set<int>{0x92, 0x9A, 0xA1}));
}

}  // namespace
}  // namespace geodesic::drivers::myactuator::test
