// The start-up dialogue of a MyActuator drive: what it asks, sets and refuses.
#include "drivers/myactuator/start_up.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/drivers/myactuator/bench.hpp"

namespace geodesic::drivers::myactuator::test {
namespace {

using control::DriveCondition;

TEST(MyactuatorStartUp, AsksInThisOrderAndMakesNoTorque) {
  Bench bench;
  std::array<Frame, SimulatedDrive::kMaxReplies> reply;
  bench.drive.receive(*encode_torque(3, 5.0), bench.now_ns, reply);  // left running
  ASSERT_GT(bench.run_until(DriveCondition::kDisabled), 0);
  EXPECT_FALSE(bench.drive.enabled());
  std::vector<int> asked;
  for (const Frame& frame : bench.sent) {
    asked.push_back(frame.data[0]);
  }
  const std::vector<int> start(asked.begin(), asked.begin() + 6);
  EXPECT_EQ(start, (std::vector<int>{0x80, 0x80, 0x9A, 0x80, 0xB2, 0xB3}));
  EXPECT_EQ(bench.sent_torques(), 0U);
  EXPECT_EQ(bench.drive.watchdog_ms(), 50U);
  EXPECT_EQ(bench.driver.firmware(), Simulated::kFirmware);
}

TEST(MyactuatorStartUp, WhatTheDriveDidBeforeItsWatchdogEndsInTheFirstCycle) {
  Bench bench;
  std::array<Frame, SimulatedDrive::kMaxReplies> reply;
  bench.drive.receive(encode_value(3, Command::kWatchdog, 10), bench.now_ns, reply);
  bench.now_ns += 1'000'000'000;
  bench.drive.speak(bench.now_ns, reply);  // and gives its notice
  bench.drive.receive(*encode_torque(3, 5.0), bench.now_ns, reply);
  bench.drive.receive(*encode_torque(3, 5.0), bench.now_ns, reply);
  bench.now_ns += 1'000'000'000;
  bench.cycle();
  EXPECT_FALSE(bench.drive.enabled());
  ASSERT_GT(bench.run_until(DriveCondition::kDisabled), 0);
  EXPECT_EQ(bench.drive.watchdog_ms(), 50U);
}

TEST(MyactuatorStartUp, FirmwareThatIsTooOldIsRefused) {
  DriveOptions options = bench_options();
  options.settings.values[kOldestFirmware] = 20250101.0;
  Bench bench(options);
  bench.drive.set_firmware(Simulated::kFirmware);
  ASSERT_GT(bench.run_until(DriveCondition::kRefused), 0);
  EXPECT_EQ(bench.driver.complaint().found, 20240315.0);
  EXPECT_EQ(bench.driver.complaint().expected, 20250101.0);
  bench.run(100, enable(5.0));
  EXPECT_EQ(bench.sent_torques(), 0U);
  EXPECT_EQ(bench.driver.state().stamp_ns, 0);
  bench.drive.set_firmware(20250101);
  bench.driver.restart();
  EXPECT_GT(bench.run_until(DriveCondition::kDisabled), 0);
}

TEST(MyactuatorStartUp, AnErrorHoldsItUnlessToldToReset) {
  Bench bench;
  bench.drive.inject_error(2);
  ASSERT_GT(bench.run_until(DriveCondition::kError), 0);
  bench.run(500, enable(5.0));
  EXPECT_EQ(bench.driver.state().condition, DriveCondition::kError);
  EXPECT_EQ(bench.driver.state().error, 2);
  EXPECT_EQ(bench.sent_requests(Command::kReset), 0U);
  DriveOptions options = bench_options();
  options.clear_errors = true;
  Bench told(options);
  told.drive.inject_error(2);
  EXPECT_GT(told.run_until(DriveCondition::kDisabled, {}, 3000), 0);
  EXPECT_EQ(told.sent_requests(Command::kReset), 1U);
  Bench hot(options);  // its cause lasts
  hot.drive.set_temperature(110.0);
  hot.run(8000, enable(5.0));
  EXPECT_EQ(hot.driver.state().condition, DriveCondition::kError);
  EXPECT_EQ(hot.sent_requests(Command::kReset), static_cast<std::size_t>(StartUp::kMaxClears));
}

TEST(MyactuatorStartUp, MotionModeIsHeldAgainstTheAngle) {
  for (const bool right : {true, false}) {
    Bench bench(motion_options());
    bench.drive.set_motion_ranges(right ? 12.5 : 12.566, 45.0, 24.0);
    bench.drive.set_shaft(2.0, 0.0);
    ASSERT_GT(bench.run_until(right ? DriveCondition::kDisabled : DriveCondition::kRefused), 0);
    EXPECT_FALSE(bench.drive.enabled() && right);
    if (!right) {
      EXPECT_NEAR(bench.driver.complaint().found, 2.0 * 12.5 / 12.566, 1e-3);
      EXPECT_NEAR(bench.driver.complaint().expected, 2.0, 1e-3);
      bench.run(10);
      EXPECT_FALSE(bench.drive.enabled());  // it is shut down
    }
  }
  Bench far(motion_options());
  far.drive.set_shaft(20.0, 0.0);
  ASSERT_GT(far.run_until(DriveCondition::kRefused), 0);
  EXPECT_NEAR(far.driver.complaint().found, 20.0, 1e-3);
}

TEST(MyactuatorStartUp, ADriveThatIgnoresARequestIsRefusedByItsName) {
  StartUp start_up(bench_options());
  Frame out;
  std::int64_t now_ns = 0;
  Frame status = encode_request(3, Command::kStatus1);
  status.id = 0x243;
  status.data[4] = 0xE0;
  ASSERT_TRUE(start_up.transmit(now_ns, out));
  start_up.receive(status);
  for (int i = 0; i < 40 && !start_up.refused(); ++i) {
    now_ns += StartUp::kReplyTimeoutNs;
    start_up.transmit(now_ns, out);
  }
  ASSERT_TRUE(start_up.refused());
  EXPECT_STREQ(start_up.complaint().quantity, "shut down (0x80)");
}

TEST(MyactuatorStartUp, AStatusThatIsSentBackIsAskedForAgain) {
  StartUp start_up(bench_options());
  Frame out;
  Frame back = encode_request(3, Command::kStatus1);
  back.id = 0x243;
  ASSERT_TRUE(start_up.transmit(0, out));
  start_up.receive(back);
  ASSERT_TRUE(start_up.transmit(1'000'000, out));
  EXPECT_EQ(out.data[0], 0x9A);
}

TEST(MyactuatorStartUp, AWatchdogThatIsNotTakenIsRefused) {
  StartUp start_up(bench_options());
  Frame out;
  std::array<Frame, SimulatedDrive::kMaxReplies> reply;
  Simulated drive(bench_options());
  for (std::int64_t now_ns = 0; now_ns < 100'000'000 && !start_up.refused(); now_ns += 1'000'000) {
    if (start_up.transmit(now_ns, out) && drive.receive(out, now_ns, reply) == 1) {
      reply[0].data[4] = out.data[0] == 0xB3 ? 0 : reply[0].data[4];
      start_up.receive(reply[0]);
    }
  }
  ASSERT_TRUE(start_up.refused());
  EXPECT_STREQ(start_up.complaint().quantity, "watchdog time (0xB3) [ms]");
  EXPECT_EQ(start_up.complaint().found, 0.0);
  EXPECT_EQ(start_up.complaint().expected, 50.0);
}

}  // namespace
}  // namespace geodesic::drivers::myactuator::test
