// The rules that hold for every drive protocol, each as a test of the Damiao family.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/drivers/damiao/bench.hpp"

namespace geodesic::drivers::damiao::test {
namespace {

using control::DriveCondition;

constexpr Ranges kRanges{12.5, 30.0, 10.0};

TEST(DamiaoRules, NumbersThatAreNotFiniteAreRefusedBeforeEncoding) {
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity(),
                           -std::numeric_limits<double>::infinity()}) {
    EXPECT_FALSE(encode_mit(1, false, {.position_rad = bad}, kRanges));
    EXPECT_FALSE(encode_mit(1, false, {.velocity_rad_s = bad}, kRanges));
    EXPECT_FALSE(encode_mit(1, false, {.stiffness_nm_rad = bad}, kRanges));
    EXPECT_FALSE(encode_mit(1, false, {.damping_nm_s_rad = bad}, kRanges));
    EXPECT_FALSE(encode_mit(1, false, {.torque_nm = bad}, kRanges));
    for (double DriveCommand::*member :
         {&DriveCommand::torque_nm, &DriveCommand::position_rad, &DriveCommand::velocity_rad_s,
          &DriveCommand::stiffness_nm_rad, &DriveCommand::damping_nm_s_rad}) {
      Bench bench;
      ASSERT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
      bench.drive.set_shaft(0.0, 2.0);
      DriveCommand command = enable(5.0);
      command.*member = bad;
      bench.cycle(command);
      const auto sent = decode_mit(bench.sent.back(), kRanges);
      ASSERT_TRUE(sent);
      EXPECT_NEAR(sent->torque_nm, 0.0, 0.003);
      EXPECT_EQ(sent->stiffness_nm_rad, 0.0);
      EXPECT_NEAR(sent->damping_nm_s_rad, Driver::kFallbackDamping, 0.002);
      EXPECT_NEAR(bench.drive.torque_nm(bench.now_ns), -2.0 * Driver::kFallbackDamping, 0.02);
      ASSERT_NE(bench.driver.complaint().quantity, nullptr);
      EXPECT_TRUE(std::isnan(bench.driver.complaint().found));
    }
  }
}

TEST(DamiaoRules, CommandsAreClampedToTheDrivesLimits) {
  const MitCommand beyond{100.0, 100.0, 1000.0, 100.0, 100.0};
  const MitCommand below{-100.0, -100.0, -1.0, -1.0, -100.0};
  const auto high = decode_mit(encode_mit(1, false, beyond, kRanges).value(), kRanges);
  const auto low = decode_mit(encode_mit(1, false, below, kRanges).value(), kRanges);
  EXPECT_DOUBLE_EQ(high->position_rad, 12.5);
  EXPECT_DOUBLE_EQ(high->velocity_rad_s, 30.0);
  EXPECT_DOUBLE_EQ(high->stiffness_nm_rad, 500.0);
  EXPECT_DOUBLE_EQ(high->damping_nm_s_rad, 5.0);
  EXPECT_DOUBLE_EQ(high->torque_nm, 10.0);
  EXPECT_DOUBLE_EQ(low->position_rad, -12.5);
  EXPECT_DOUBLE_EQ(low->velocity_rad_s, -30.0);
  EXPECT_DOUBLE_EQ(low->stiffness_nm_rad, 0.0);
  EXPECT_DOUBLE_EQ(low->damping_nm_s_rad, 0.0);
  EXPECT_DOUBLE_EQ(low->torque_nm, -10.0);
}

TEST(DamiaoRules, NumbersAreRoundedToNearestSoThatTheMeanErrorVanishes) {
  double sum = 0.0;
  constexpr int kSamples = 20'000;
  for (int i = 0; i < kSamples; ++i) {
    const double torque = -9.0 + 18.0 * i / kSamples;
    const auto frame = encode_mit(1, false, {.torque_nm = torque}, kRanges);
    sum += decode_mit(*frame, kRanges)->torque_nm - torque;
  }
  EXPECT_LT(std::abs(sum / kSamples), 0.02 * 20.0 / 4095.0);  // truncation: half a code
}

TEST(DamiaoRules, ScalingIsReadFromTheDriveNeverGuessed) {
  Bench bench;
  bench.drive.set_register(22, Bench::raw(8.0));  // as older tables have it for this drive
  ASSERT_GT(bench.run_until(DriveCondition::kRefused), 0);
  EXPECT_EQ(bench.driver.state().stamp_ns, 0);  // nothing it said was taken for a position
}

TEST(DamiaoRules, RepliesHaveATimeOutAndTheDrivesWatchdogIsSet) {
  Bench bench;
  bench.cut = true;
  bench.run(21);
  EXPECT_EQ(bench.sent.size(), 2U);
  bench.cut = false;
  bench.drive.set_register(9, 0);  // off, as it may come
  ASSERT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
  EXPECT_EQ(bench.drive.register_raw(9), 1000U);
}

TEST(DamiaoRules, AfterAFaultOrWatchdogTorqueDoesNotComeBackByItself) {
  DriveOptions options = bench_options();
  options.clear_errors = true;  // which is for start-up only
  Bench bench(options);
  ASSERT_GT(bench.run_until(DriveCondition::kEnabled, enable(5.0)), 0);
  bench.cut = true;
  bench.run(60, enable(5.0));
  bench.cut = false;
  bench.run(500, enable(5.0));
  EXPECT_EQ(bench.driver.state().condition, DriveCondition::kError);
  EXPECT_EQ(bench.drive.torque_nm(bench.now_ns), 0.0);
  std::array<Frame, 1> reply;  // even if somebody clears and enables it behind our back
  bench.drive.receive(encode_special(5, false, Special::kClearError), bench.now_ns, reply);
  bench.drive.receive(encode_special(5, false, Special::kEnable), bench.now_ns, reply);
  bench.run(2, enable(5.0));
  EXPECT_FALSE(bench.drive.enabled());
  EXPECT_EQ(bench.driver.state().condition, DriveCondition::kDisabled);
  bench.cycle();
  EXPECT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
}

TEST(DamiaoRules, NoControlFrameEverEqualsASpecialFrame) {
  for (std::uint32_t code = 0xFF0; code <= 0xFFF; ++code) {
    const double torque = from_code(code, -10.0, 10.0, 12);
    const auto frame = encode_mit(1, false, {12.5, 30.0, 500.0, 5.0, torque}, kRanges);
    ASSERT_TRUE(frame);
    EXPECT_FALSE(decode_special(*frame)) << code;
    EXPECT_NEAR(decode_mit(*frame, kRanges)->torque_nm, torque, 1e-12);
    EXPECT_NEAR(decode_mit(*frame, kRanges)->damping_nm_s_rad, 5.0, 5.0 / 4095.0 * 1.001);
  }
}

}  // namespace
}  // namespace geodesic::drivers::damiao::test
