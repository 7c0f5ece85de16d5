// The simulated moteus drive by itself: what it answers, when it stops, what it forgets.
#include "drivers/moteus/simulated.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/drivers/moteus/bench.hpp"

namespace geodesic::drivers::moteus::test {
namespace {

constexpr Link kLink{0, 5, 0};

class MoteusSimulated : public ::testing::Test {
 protected:
  /// Sends `frame` at now_ns. @return the reply; empty: none.
  Frame ask(const Frame& frame) {
    std::array<Frame, 1> reply;
    return drive.receive(frame, now_ns, reply) == 1 ? reply[0] : Frame{};
  }
  Frame write(Register number, Resolution resolution, double value) {
    Frame frame = make_frame(kLink.command());
    const std::array<Item, 1> items = {Item{number, resolution, value}};
    append_writes(frame, items);
    return ask(frame);
  }
  void start(double torque_nm, std::int64_t watchdog_ns = 100'000'000) {
    PositionCommand command;
    command.torque_nm = torque_nm;
    command.max_torque_nm = 10.0;
    command.watchdog_ns = watchdog_ns;
    ask(encode_position(kLink, {}, command, false).value());
    now_ns += 20'000'000;
    ask(encode_position(kLink, {}, command, false).value());
  }
  double position_rev() { return decode_report(ask(encode_query(kLink, {}))).position_rev.value(); }

  Simulated drive{bench_options()};
  std::int64_t now_ns = 1'000'000'000;
};

TEST_F(MoteusSimulated, AnswersOnlyWhoWantsToKnowAndOnlyForItself) {
  Frame frame = encode_query(kLink, {});
  EXPECT_EQ(ask(frame).id, 0x0500U);
  frame.id = 0x0005;
  EXPECT_EQ(ask(frame).length, 0);  // no reply wanted
  frame.id = 0x8006;
  EXPECT_EQ(ask(frame).length, 0);
  frame.id = 0x01008005;
  EXPECT_EQ(ask(frame).length, 0);  // another prefix
  frame.id = 0x8A05;
  EXPECT_EQ(ask(frame).id, 0x050AU);
  frame.id = 0x807F;
  EXPECT_EQ(ask(frame).id, 0x0500U);  // to everybody
}

TEST_F(MoteusSimulated, MirrorsTheBitRateSwitchAndAnswersSmallClassicFramesClassic) {
  Frame frame = encode_query(kLink, {});
  EXPECT_TRUE(ask(frame).bit_rate_switch);
  frame.bit_rate_switch = false;
  EXPECT_TRUE(ask(frame).fd);
  EXPECT_FALSE(ask(frame).bit_rate_switch);
  Frame tiny = make_frame(kLink.command());
  const std::array<Item, 1> items = {Item{Register::kMode, Resolution::kInt8}};
  append_reads(tiny, items);
  tiny.fd = false;
  tiny.bit_rate_switch = false;
  EXPECT_FALSE(ask(tiny).fd);
  EXPECT_EQ(ask(tiny).length, 3);
}

TEST_F(MoteusSimulated, ReadAndWriteErrorsAreNamed) {
  Frame unknown = make_frame(kLink.command());
  const std::array<Item, 2> items = {Item{static_cast<Register>(0x110), Resolution::kInt32},
                                     Item{Register::kMode, Resolution::kInt8}};
  append_reads(unknown, items);
  const Frame reply = ask(unknown);
  EXPECT_EQ(reply.length, 4);  // what comes after an error is lost
  EXPECT_EQ(reply.data[0], 0x31);
  EXPECT_EQ(reply.data[3], 1);
  EXPECT_EQ(write(Register::kPosition, Resolution::kFloat, 1.0).data[2], 2);
  EXPECT_EQ(write(Register::kMode, Resolution::kInt8, 99.0).data[0], 0x30);
  Frame narrow = make_frame(kLink.command());
  const std::array<Item, 1> map = {Item{Register::kRegisterMap, Resolution::kInt8}};
  append_reads(narrow, map);
  EXPECT_EQ(ask(narrow).data[0], 0x31);  // in 32 bits only
}

TEST_F(MoteusSimulated, UnwrittenRegistersFallBack) {
  drive.set_shaft(0.1 * kTurn, 0.0);
  write(Register::kMode, Resolution::kInt8, 10.0);  // position 0, kp scale 1: it goes there at once
  now_ns += 11'000'000;
  EXPECT_NEAR(drive.torque_nm(now_ns), -0.1 * 4.0, 1e-5);
  now_ns += 90'000'000;  // default_timeout_s
  drive.torque_nm(now_ns);
  EXPECT_EQ(drive.mode(), 11);
  EXPECT_TRUE(drive.enabled());  // its damper works, for the last command's kd scale was 1
  drive.set_shaft(0.1 * kTurn, 2.0 * kTurn);
  EXPECT_NEAR(drive.torque_nm(now_ns), -2.0 * 0.05, 1e-6);
}

TEST_F(MoteusSimulated, WithoutDampingInTheLastCommandATimeOutLeavesItLimp) {
  start(5.0);
  drive.set_shaft(0.0, 10.0);
  EXPECT_NEAR(drive.torque_nm(now_ns), 5.0, 1e-5);
  now_ns += 200'000'000;
  EXPECT_EQ(drive.torque_nm(now_ns), 0.0);
  EXPECT_EQ(drive.mode(), 11);
  EXPECT_FALSE(drive.enabled());
}

TEST_F(MoteusSimulated, TheTimeOutAndFaultsAreLatchedUntilAStop) {
  for (const std::uint8_t code : {std::uint8_t{11}, std::uint8_t{35}}) {
    start(5.0);
    drive.inject_error(code);
    start(5.0);
    EXPECT_EQ(drive.mode(), code == 11 ? 11 : 1);
    EXPECT_EQ(drive.torque_nm(now_ns), 0.0);
    ask(encode_stop(kLink, {}));
    EXPECT_EQ(drive.mode(), 0);
    EXPECT_EQ(drive.fault(), 0);
    start(5.0);
    EXPECT_EQ(drive.mode(), 10);
    ask(encode_stop(kLink, {}));
  }
}

TEST_F(MoteusSimulated, TorqueIsBoundedByTheCommandAndTheDrive) {
  PositionCommand command;
  command.torque_nm = 8.0;
  command.max_torque_nm = 2.0;
  command.watchdog_ns = 1'000'000'000;
  start(0.0);
  ask(encode_position(kLink, {}, command, false).value());
  EXPECT_NEAR(drive.torque_nm(now_ns), 2.0, 1e-6);
  command.torque_nm = 80.0;
  command.max_torque_nm = 100.0;
  ask(encode_position(kLink, {}, command, false).value());
  EXPECT_NEAR(drive.torque_nm(now_ns), 10.0, 1e-6);
}

TEST_F(MoteusSimulated, ShortIntegersSaturateAndAreTruncated) {
  drive.set_shaft(4.0 * kTurn, -9.0 * kTurn);
  Formats narrow;
  narrow.position = narrow.velocity = narrow.torque = Resolution::kInt16;
  const StateReport report = decode_report(ask(encode_query(kLink, narrow)));
  EXPECT_NEAR(*report.position_rev, 3.2767, 1e-9);
  EXPECT_NEAR(*report.velocity_rev_s, -8.19175, 1e-9);
  EXPECT_TRUE(report.saturated);
  drive.set_shaft(0.00019 * kTurn, 0.0);
  EXPECT_NEAR(*decode_report(ask(encode_query(kLink, narrow))).position_rev, 0.0001, 1e-9);
}

TEST_F(MoteusSimulated, PowerOffLosesWholeTurns) {
  drive.set_shaft(2.3 * kTurn, 0.0);
  EXPECT_NEAR(position_rev(), 2.3, 1e-5);
  drive.power_cycle();
  EXPECT_NEAR(position_rev(), 0.3, 1e-5);
  drive = Simulated(with(kHome, 1.0, with(kRatio, 0.1)));  // 10:1, an encoder at the rotor
  drive.set_shaft(2.33 * kTurn, 0.0);
  drive.power_cycle();
  EXPECT_NEAR(position_rev(), 0.03, 1e-5);
  write(Register::kSetOutputNearest, Resolution::kFloat, 2.35);
  EXPECT_NEAR(position_rev(), 2.33, 1e-5);  // by whole turns of the rotor
  write(Register::kSetOutputExact, Resolution::kFloat, 0.25);
  EXPECT_NEAR(position_rev(), 0.25, 1e-5);
  drive.power_cycle();
  EXPECT_NEAR(position_rev(), 0.03, 1e-5);  // neither is kept
}

TEST_F(MoteusSimulated, NeverAnswersBeyondAFrameWhateverItIsSent) {
  std::uint32_t state = 12345;
  for (int i = 0; i < 20'000; ++i) {
    Frame frame = make_frame(kLink.command());
    frame.length = 64;
    for (std::uint8_t& byte : frame.data) {
      state = state * 1664525U + 1013904223U;
      byte = static_cast<std::uint8_t>(state >> (i % 2 == 0 ? 24U : 26U));
    }
    now_ns += 1'000'000;
    const Frame reply = ask(frame);
    ASSERT_TRUE(reply.length <= 8 || reply.length == 12 || reply.length % 4 == 0);
    const double torque = drive.torque_nm(now_ns);
    ASSERT_TRUE(std::isfinite(torque) && std::abs(torque) <= 10.0 + 1e-6);
    ASSERT_TRUE(drive.enabled() || torque == 0.0);
  }
}

}  // namespace
}  // namespace geodesic::drivers::moteus::test
