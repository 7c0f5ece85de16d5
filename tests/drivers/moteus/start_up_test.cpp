// The start-up dialogue of a moteus drive against the simulated one.
#include "drivers/moteus/start_up.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "tests/drivers/moteus/bench.hpp"

namespace geodesic::drivers::moteus::test {
namespace {

using control::DriveCondition;

TEST(MoteusStartUp, ReadsComparesAndReports) {
  Bench bench;
  EXPECT_EQ(bench.driver.state().condition, DriveCondition::kUnknown);
  bench.drive.set_shaft(1.0, 0.0);
  ASSERT_GT(bench.run_until(DriveCondition::kDisabled), 0);
  EXPECT_EQ(bench.driver.firmware(), 0x010100U);
  EXPECT_NEAR(bench.driver.state().position_rad, 1.0, 1e-4);
  EXPECT_EQ(bench.sent_mode(Mode::kStopped), 0U);  // nothing was to be stopped
  EXPECT_EQ(bench.sent_mode(Mode::kPosition), 0U);
}

TEST(MoteusStartUp, StopsWhoeverWasLeftRunning) {
  Bench bench;
  std::array<Frame, 1> reply;
  PositionCommand other;
  other.max_torque_nm = 1.0;
  other.watchdog_ns = 5'000'000'000;
  bench.drive.receive(encode_position({1, 5, 0}, {}, other, false).value(), 0, reply);
  bench.drive.torque_nm(100'000'000);
  ASSERT_EQ(bench.drive.mode(), 10);
  ASSERT_GT(bench.run_until(DriveCondition::kDisabled), 0);
  EXPECT_EQ(bench.drive.mode(), 0);
}

TEST(MoteusStartUp, RefusesAnotherRegisterMap) {
  Bench bench;
  bench.drive.set_register_map(4);
  ASSERT_GT(bench.run_until(DriveCondition::kRefused), 0);
  const DriveComplaint& complaint = bench.driver.complaint();
  EXPECT_NE(std::strstr(complaint.quantity, "0x102"), nullptr);
  EXPECT_EQ(complaint.found, 4.0);
  EXPECT_EQ(complaint.expected, 5.0);
  EXPECT_EQ(bench.driver.state().stamp_ns, 0);  // nothing it said was taken for a position
  bench.run(200, enable(5.0));
  EXPECT_EQ(bench.sent_mode(Mode::kPosition), 0U);
  bench.drive.set_register_map(5);
  bench.driver.restart();
  EXPECT_GT(bench.run_until(DriveCondition::kDisabled), 0);
}

TEST(MoteusStartUp, ThePositionMustBeReferencedAsConfigured) {
  const auto refused = [](double home, Home has) {
    Bench bench(with(kHome, home));
    bench.drive.set_home(has);
    const bool is = bench.run_until(DriveCondition::kDisabled, {}, 300) < 0;
    EXPECT_EQ(is, bench.driver.state().condition == DriveCondition::kRefused);
    if (is) {
      EXPECT_NE(std::strstr(bench.driver.complaint().quantity, "0x00C"), nullptr);
      EXPECT_EQ(bench.driver.complaint().found, static_cast<double>(has));
    }
    return is;
  };
  EXPECT_TRUE(refused(0.0, Home::kRelative));
  EXPECT_TRUE(refused(0.0, Home::kRotor));
  EXPECT_FALSE(refused(0.0, Home::kOutput));
  EXPECT_TRUE(refused(1.0, Home::kRelative));
  EXPECT_FALSE(refused(1.0, Home::kRotor));
  EXPECT_FALSE(refused(1.0, Home::kOutput));
}

TEST(MoteusStartUp, GearAndGainsAreReadFromTheDrivesConsole) {
  struct Case {
    Setting which;
    float Simulated::Config::*value;
    const char* named;
  };
  for (const Case& one :
       {Case{kKp, &Simulated::Config::kp, "kp"}, Case{kKd, &Simulated::Config::kd, "kd"},
        Case{kRatio, &Simulated::Config::ratio, "ratio"}}) {
    Bench right(with(one.which, 0.25));
    ASSERT_GT(right.run_until(DriveCondition::kDisabled), 0) << one.named;
    Bench wrong(with(one.which, 0.25));
    Simulated::Config config = wrong.drive.config();
    config.*one.value = 0.5F;
    wrong.drive.set_config(config);
    ASSERT_GT(wrong.run_until(DriveCondition::kRefused), 0) << one.named;
    EXPECT_NE(std::strstr(wrong.driver.complaint().quantity, one.named), nullptr);
    EXPECT_EQ(wrong.driver.complaint().found, 0.5);
    EXPECT_EQ(wrong.driver.complaint().expected, 0.25);
  }
}

TEST(MoteusStartUp, ReadsAwayWhatTheConsoleHadLeft) {
  Bench bench(with(kKp, 8.0));
  std::array<Frame, 1> reply;
  bench.drive.receive(encode_text({1, 5, 0}, "conf get servo.pid_position.kd\n"), 0, reply);
  ASSERT_GT(bench.run_until(DriveCondition::kDisabled), 0);
}

TEST(MoteusStartUp, FaultsAreClearedOnlyWhenTold) {
  for (const std::uint8_t code : {std::uint8_t{33}, std::uint8_t{11}}) {
    Bench bench;
    bench.drive.inject_error(code);
    ASSERT_GT(bench.run_until(DriveCondition::kError), 0);
    bench.run(200, enable(5.0));
    EXPECT_EQ(bench.driver.state().condition, DriveCondition::kError);
    EXPECT_EQ(bench.driver.state().error, code);
    EXPECT_EQ(bench.driver.complaint().found, code);
    EXPECT_EQ(bench.sent_mode(Mode::kStopped), 0U);
    DriveOptions options = bench_options();
    options.clear_errors = true;
    Bench told(options);
    told.drive.inject_error(code);
    EXPECT_GT(told.run_until(DriveCondition::kDisabled), 0);
    EXPECT_GE(told.sent_mode(Mode::kStopped), 1U);
    EXPECT_EQ(told.driver.state().error, 0);
  }
}

TEST(MoteusStartUp, GoesOnThroughLostFrames) {
  Bench bench(with(kKp, 8.0));
  for (int i = 0; i < 2000 && bench.driver.state().condition != DriveCondition::kDisabled; ++i) {
    bench.cut = i % 3 == 0;
    bench.deaf = i % 7 == 0;
    bench.cycle();
  }
  EXPECT_EQ(bench.driver.state().condition, DriveCondition::kDisabled);
}

TEST(MoteusStartUp, AQuestionThatIsNeverAnsweredIsARefusal) {
  DriveOptions options = bench_options();
  StartUp start_up(options, link_for(options), formats_for(options));
  Frame frame;
  std::int64_t now_ns = 0;
  StateReport stopped;
  stopped.mode = std::uint8_t{0};
  for (int i = 0; i < 2000 && !start_up.refused(); ++i, now_ns += 1'000'000) {
    if (start_up.transmit(now_ns, frame)) {
      start_up.receive(Frame{}, stopped);  // a state, whatever was asked
    }
  }
  ASSERT_TRUE(start_up.refused());
  EXPECT_NE(start_up.complaint().fix, nullptr);
}

TEST(MoteusStartUp, ARegisterItDoesNotKnowIsNamed) {
  DriveOptions options = bench_options();
  StartUp start_up(options, link_for(options), formats_for(options));
  Frame frame;
  StateReport stopped;
  stopped.mode = std::uint8_t{0};
  ASSERT_TRUE(start_up.transmit(0, frame));
  start_up.receive(Frame{}, stopped);
  ASSERT_TRUE(start_up.transmit(1, frame));
  Frame reply;
  reply.length = 4;
  reply.data = {0x31, 0x82, 0x02, 0x01};
  start_up.receive(reply, {});
  ASSERT_TRUE(start_up.refused());
  EXPECT_EQ(start_up.complaint().found, 0x102);
}

TEST(MoteusStartUp, ADriveThatDoesNotTakeTheWatchdogIsRefused) {
  Bench bench;
  ASSERT_GT(bench.run_until(DriveCondition::kDisabled), 0);
  bench.cut = true;
  bench.run(2, enable());
  Frame reply;
  reply.id = 0x0500;
  reply.fd = true;
  reply.length = 32;  // maximum torque 10, timeout 1 s instead of 0.05; stopped
  reply.data = {0x25, 0x25, 0xE8, 0x03, 0x21, 0x27, 100, 0x21, 0x00, 0x00, 0x29, 0x01, 0,
                0,    0,    0,    0x26, 0x02, 0,    0,   0,    0,    0x22, 0x0E, 30,   0};
  std::memset(reply.data.data() + 26, 0x50, 6);
  bench.driver.receive({reply, bench.now_ns});
  EXPECT_EQ(bench.driver.state().condition, DriveCondition::kRefused);
  EXPECT_NE(std::strstr(bench.driver.complaint().quantity, "0x027"), nullptr);
  EXPECT_EQ(bench.driver.complaint().found, 1.0);
  EXPECT_EQ(bench.driver.complaint().expected, 0.05);
}

}  // namespace
}  // namespace geodesic::drivers::moteus::test
