// The start-up dialogue against the simulated drive: what it reads, writes, refuses and survives.
#include "drivers/odrive/start_up.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "tests/drivers/odrive/bench.hpp"

namespace geodesic::drivers::odrive::test {
namespace {

using control::DriveCondition;

void expect_refused(Bench& bench, const std::string& quantity) {
  ASSERT_GT(bench.run_until(DriveCondition::kRefused), 0) << quantity;
  const DriveComplaint& complaint = bench.driver.complaint();
  ASSERT_NE(complaint.quantity, nullptr);
  EXPECT_EQ(std::string(complaint.quantity).rfind(quantity, 0), 0U) << complaint.quantity;
  EXPECT_NE(complaint.fix, nullptr);
  bench.run(100, enable(1.0));
  EXPECT_FALSE(bench.drive.enabled());
  EXPECT_EQ(bench.sent_states(kAxisClosedLoop), 0U);
}

TEST(OdriveStartUp, ConfiguresADriveOfEitherFirmwareAndEndsDisabled) {
  for (const DriveOptions& options : {bench_options(), endpoint_options(), old_options()}) {
    Bench bench(options);
    bench.drive.set_shaft(1.0, 0.0);
    EXPECT_EQ(bench.driver.state().condition, DriveCondition::kUnknown);
    const int cycles = bench.run_until(DriveCondition::kDisabled);
    EXPECT_GT(cycles, 50);
    EXPECT_LT(cycles, 800);
    bench.run(3);
    EXPECT_EQ(bench.driver.complaint().quantity, nullptr);
    EXPECT_EQ(bench.driver.state().error, 0);
    EXPECT_NEAR(bench.driver.state().position_rad, 1.0, kTurn / 16384.0);
    EXPECT_NEAR(bench.drive.velocity_limit_rev_s(), 60.0 / kTurn + 12.0, 1e-5);
    EXPECT_EQ(bench.drive.current_limit_a(), 25.0);
    EXPECT_EQ(bench.sent_states(kAxisClosedLoop), 0U);
    EXPECT_EQ(bench.sent_commands(Command::kReboot), 0U);
  }
}

TEST(OdriveStartUp, WritesWhatItsEndpointsMaySayAndReadsItBack) {
  for (const std::uint8_t revision : {std::uint8_t{9}, std::uint8_t{11}}) {  // 11 confirms writes
    DriveOptions options = endpoint_options();
    set(options, Key::kRevision, revision);
    set(options, Key::kTorqueFeedback, 1.0);
    Bench bench(options);
    bench.drive.set_firmware_revision(revision);
    ASSERT_EQ(bench.drive.parameter(Parameter::kEnableWatchdog), 0.0);
    ASSERT_GT(bench.run_until(DriveCondition::kDisabled), 0);
    EXPECT_NEAR(bench.drive.parameter(Parameter::kWatchdogTimeout), 0.05, 1e-6);
    EXPECT_EQ(bench.drive.parameter(Parameter::kEnableWatchdog), 1.0);
    EXPECT_EQ(bench.drive.parameter(Parameter::kEncoderRate), 1.0);
    EXPECT_EQ(bench.drive.parameter(Parameter::kTorqueRate), 1.0);
    EXPECT_EQ(bench.drive.parameter(Parameter::kHeartbeatRate), 20.0);
  }
}

TEST(OdriveStartUp, TheOtherFirmwareIsRefused) {
  DriveOptions is_new = bench_options();
  DriveOptions is_old = old_options();
  Bench bench(is_new);
  Simulated old_drive(is_old);
  bench.drive = old_drive;
  expect_refused(bench, "firmware (command 00 is not answered)");
  EXPECT_EQ(bench.driver.complaint().found, 0.5);
  Bench other(is_old);
  other.drive = Simulated(is_new);
  expect_refused(other, "firmware (command 00)");
  EXPECT_NEAR(other.driver.complaint().found, 0.6, 1e-9);
}

TEST(OdriveStartUp, EndpointsOfAnotherBuildAreNeverWritten) {
  Bench bench(endpoint_options());
  bench.drive.set_firmware_revision(10);
  expect_refused(bench, "firmware revision");
  EXPECT_EQ(bench.sent_commands(Command::kRxSdo), 0U);
  Bench swapped(endpoint_options());  // what stands there is no such value
  swapped.drive.set_parameter(Parameter::kEnableWatchdog, 3.0);
  expect_refused(swapped, "axis0.config.enable_watchdog");
}

TEST(OdriveStartUp, ATorqueConstantThatContradictsIsRefused) {
  Bench bench(endpoint_options());
  bench.drive.set_parameter(Parameter::kTorqueConstant, 0.08);
  expect_refused(bench, "axis0.config.motor.torque_constant");
  EXPECT_NEAR(bench.driver.complaint().found, 0.08, 1e-6);
  EXPECT_EQ(bench.driver.complaint().expected, 0.1);
}

TEST(OdriveStartUp, AWatchdogThatIsOffOrTooSlowIsFoundOutBySilence) {
  for (const DriveOptions& options : {bench_options(), old_options()}) {
    Bench off(options);
    off.drive.set_parameter(Parameter::kEnableWatchdog, 0.0);
    expect_refused(off, "axis0.config.watchdog_timeout");
    EXPECT_EQ(off.driver.complaint().expected, 0.05);
    Bench slow(options);
    slow.drive.set_parameter(Parameter::kWatchdogTimeout, 0.5);
    expect_refused(slow, "axis0.config.watchdog_timeout");
    DriveOptions trusting = options;
    set(trusting, Key::kWatchdogProof, 1.0);
    Bench trusted(trusting);
    trusted.drive.set_parameter(Parameter::kEnableWatchdog, 0.0);
    EXPECT_GT(trusted.run_until(DriveCondition::kDisabled), 0);
    int silent = 0;
    Bench proved(options);
    for (int i = 0; i < 800; ++i) {
      proved.cycle();
      silent += proved.frames == 0 ? 1 : 0;
    }
    EXPECT_GE(silent, 49);
    EXPECT_LT(silent, 200);
  }
}

TEST(OdriveStartUp, ReportsThatComeTooSeldomAreRefusedWithTheirPeriod) {
  Bench bench;
  bench.drive.set_parameter(Parameter::kEncoderRate, 10.0);
  expect_refused(bench, "axis0.config.can.encoder_msg_rate_ms, as measured");
  EXPECT_NEAR(bench.driver.complaint().found, 10.0, 0.5);
  EXPECT_NEAR(bench.driver.complaint().expected, 1.0, 1e-9);
  DriveOptions options = bench_options();
  set(options, Key::kTorqueFeedback, 1.0);
  Bench torque(options);
  torque.drive.set_parameter(Parameter::kTorqueRate, 0.0);
  expect_refused(torque, "axis0.config.can.torques_msg_rate_ms");
  EXPECT_TRUE(std::isnan(torque.driver.complaint().found));
}

TEST(OdriveStartUp, ADriveWithoutHeartbeatIsRefused) {
  for (const DriveOptions& options : {bench_options(), old_options()}) {
    Bench bench(options);
    bench.drive.set_parameter(Parameter::kHeartbeatRate, 0.0);
    expect_refused(bench, "axis0.config.can.heartbeat_msg_rate_ms");
    Bench slow(options);
    slow.drive.set_parameter(Parameter::kHeartbeatRate, 400.0);
    expect_refused(slow, "axis0.config.can.heartbeat_msg_rate_ms");
  }
}

TEST(OdriveStartUp, OldErrorsAreClearedOnlyWhenToldTo) {
  for (const bool old : {false, true}) {
    for (const bool clear : {false, true}) {
      DriveOptions options = old ? old_options() : bench_options();
      options.clear_errors = clear;
      Bench bench(options);
      bench.drive.inject_error(old ? kEncoderBase + 2 : kActiveBase + 26);
      bench.run(900);
      EXPECT_EQ(bench.driver.state().condition,
                clear ? DriveCondition::kDisabled : DriveCondition::kError);
      if (!clear) {
        EXPECT_EQ(bench.sent_commands(Command::kClearErrors), 0U);
        EXPECT_EQ(bench.driver.state().error, old ? kEncoderBase + 2 : kActiveBase + 26);
        bench.tell(*encode(kNode, old ? kClearErrors05 : kClearErrors06, {}));
        EXPECT_GT(bench.run_until(DriveCondition::kDisabled), 0);  // by somebody's hand
      }
    }
  }
}

TEST(OdriveStartUp, AWatchdogThatExpiredBeforeWeCameIsNoObstacle) {
  for (const DriveOptions& options : {bench_options(), old_options()}) {
    Bench bench(options);
    for (int i = 0; i < 200; ++i) {  // nobody feeds it
      bench.now_ns += Bench::kPeriodNs;
      bench.drive.speak(bench.now_ns, bench.said);
    }
    EXPECT_GT(bench.run_until(DriveCondition::kDisabled), 0);
    EXPECT_GE(bench.sent_commands(Command::kClearErrors), 1U);
  }
}

TEST(OdriveStartUp, AWatchdogErrorDoesNotHideAnother) {
  for (const bool old : {false, true}) {
    Bench bench(old ? old_options() : bench_options());
    bench.drive.inject_error(old ? kMotorBase + 3 : kActiveBase + 5);
    for (int i = 0; i < 200; ++i) {
      bench.now_ns += Bench::kPeriodNs;
      bench.drive.speak(bench.now_ns, bench.said);
    }
    bench.run(600);
    EXPECT_EQ(bench.driver.state().condition, DriveCondition::kError);
    EXPECT_NE(std::string(error_name(bench.driver.state().error)).find("gate driver"),
              std::string::npos);
    EXPECT_EQ(bench.sent_commands(Command::kClearErrors), 0U);
  }
}

TEST(OdriveStartUp, ADriveLeftInClosedLoopIsMadeIdleFirst) {
  Bench bench;
  bench.drive.set_parameter(Parameter::kEnableWatchdog, 0.0);
  bench.tell(*encode(kNode, kSetAxisState, {kAxisClosedLoop}));
  ASSERT_TRUE(bench.drive.enabled());
  bench.run(150);
  EXPECT_FALSE(bench.drive.enabled());
  EXPECT_GE(bench.sent_states(kAxisIdle), 1U);
}

TEST(OdriveStartUp, ASecondAxisWithTheSameNodeIsRefused) {
  for (const DriveOptions& options : {bench_options(), old_options()}) {
    Bench bench(options);
    Simulated twin(options);
    bool refused = false;
    for (int i = 0; i < 1500 && !refused; ++i) {
      bench.cycle();
      for (std::size_t k = 0; k < bench.frames; ++k) {
        bench.hear(twin.receive(bench.out[k], bench.now_ns + 700'000, bench.said),
                   bench.now_ns + 800'000);
      }
      refused = bench.driver.state().condition == DriveCondition::kRefused;
    }
    EXPECT_TRUE(refused);
    EXPECT_EQ(std::string(bench.driver.complaint().quantity).rfind("answers to one request", 0),
              0U);
  }
}

TEST(OdriveStartUp, LostFramesAreAskedForAgain) {
  for (const DriveOptions& options : {bench_options(), endpoint_options(), old_options()}) {
    DriveOptions trusting = options;
    set(trusting, Key::kWatchdogProof, 1.0);
    Bench bench(trusting);
    bench.drive.set_parameter(Parameter::kWatchdogTimeout, 0.05);
    bool done = false;
    for (int i = 0; i < 5000 && !done; ++i) {
      bench.cut = i * 7 % 11 < 3;
      bench.cycle();
      done = bench.driver.state().condition == DriveCondition::kDisabled;
    }
    EXPECT_TRUE(done);
  }
}

TEST(OdriveStartUp, EveryCycleThatSendsBringsAnAnswer) {
  for (const DriveOptions& options : {bench_options(), endpoint_options(), old_options()}) {
    Bench bench(options);
    for (int i = 0; i < 1000; ++i) {
      bench.cycle(i < 500 ? DriveCommand{} : enable());
      ASSERT_TRUE(bench.frames == 0 || bench.driver.answers_due(bench.frames) > 0) << i;
    }
  }
}

}  // namespace
}  // namespace geodesic::drivers::odrive::test
