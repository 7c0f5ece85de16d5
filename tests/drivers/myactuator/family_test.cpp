// The MyActuator family for people: words for frames, checks of options, the dialogues at the
// bench, and the simulated drive where nothing else looks at it.
#include "drivers/myactuator/family.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <set>

#include "drivers/myactuator/bench.hpp"
#include "tests/drivers/myactuator/bench.hpp"

namespace geodesic::drivers::myactuator::test {
namespace {

std::string words(const Frame& frame, const DriveOptions& options = bench_options()) {
  const auto decoded = decode(frame, options);
  if (!decoded) {
    return "nothing";
  }
  std::string text = decoded->kind;
  for (const DecodedField& field : decoded->fields) {
    text += ", " + field.name + " " + field.value + (field.unit.empty() ? "" : " " + field.unit);
  }
  return text;
}

TEST(MyactuatorFamily, TellsFramesInWords) {
  EXPECT_EQ(words(*encode_torque(3, 1.5)), "torque request, current 1.5 A, torque 3 N·m");
  EXPECT_EQ(words(*encode_torque(4, 1.5)), "nothing");
  EXPECT_EQ(words(encode_value(3, Command::kWatchdog, 50)), "watchdog time request, time 50 ms");
  EXPECT_EQ(words(encode_request(3, Command::kShutdown)), "shut down request");
  EXPECT_EQ(words(encode_value(3, Command::kFunction, 1, 4)), "function request, index 4, value 1");
  Frame frame;
  frame.id = 0x243;
  frame.length = 8;
  frame.data = {0x9A, 50, 40, 1, 0xE5, 0x01, 0x06, 0x10};
  EXPECT_EQ(words(frame),
            "status 1 reply, motor temperature 50 °C, MOSFET temperature 40 °C, brake released, "
            "supply 48.5 V, errors stall, under-voltage, motor over-temperature");
  frame.data = {0xA1, 0x32, 0x64, 0, 0xF4, 1, 0x2D, 0};
  EXPECT_EQ(words(frame),
            "torque reply, temperature 50 °C, current 1 A, speed 500 deg/s, angle 45 deg, torque 2 "
            "N·m");
  frame.data = {0x92, 0, 0, 0, 0x28, 0x23, 0, 0};
  EXPECT_EQ(words(frame), "multi-turn angle reply, angle 90 deg, position 1.5708 rad");
  frame.data = {0xF1};
  EXPECT_EQ(words(frame), "watchdog expired reply");
  frame.data = {0x42};
  EXPECT_EQ(words(frame), "command 0x42 reply");
  frame.length = 7;
  EXPECT_EQ(words(frame), "nothing");
  EXPECT_EQ(
      words(*encode_motion(3, {.torque_nm = 24.0}, kRanges), motion_options()),
      "motion command, position 0.000190738 rad, velocity 0.010989 rad/s, stiffness 0 N·m/rad, "
      "damping 0 N·m·s/rad, torque 24 N·m");
}

TEST(MyactuatorFamily, ChecksOptions) {
  const auto wrong = [](auto change, DriveOptions options = bench_options()) {
    change(options);
    return check(options).size();
  };
  EXPECT_EQ(wrong([](DriveOptions&) {}), 0U);
  EXPECT_EQ(wrong([](DriveOptions&) {}, motion_options()), 0U);
  EXPECT_EQ(wrong([](DriveOptions& o) { o.id = 0; }), 1U);
  EXPECT_EQ(wrong([](DriveOptions& o) { o.id = 33; }), 1U);
  EXPECT_EQ(wrong([](DriveOptions& o) { o.reply_id = 0x243; }), 0U);
  EXPECT_EQ(wrong([](DriveOptions& o) { o.reply_id = 0x143; }), 1U);
  EXPECT_EQ(wrong([](DriveOptions& o) { o.fd = true; }), 1U);
  EXPECT_EQ(wrong([](DriveOptions& o) { o.velocity_range_rad_s = -1.0; }), 1U);
  EXPECT_EQ(
      wrong([](DriveOptions& o) { o.torque_range_nm = std::numeric_limits<double>::quiet_NaN(); }),
      1U);
  EXPECT_EQ(wrong([](DriveOptions& o) { o.watchdog_ns = 0; }), 1U);
  EXPECT_EQ(wrong([](DriveOptions& o) { o.settings.values[kTorqueConstant] = kNotSet; }), 1U);
  EXPECT_EQ(wrong([](DriveOptions& o) { o.position_range_rad = 0.0; }, motion_options()), 1U);
}

TEST(MyactuatorFamily, NamesItsErrorsAndFrames) {
  std::set<std::string> names;
  for (const std::uint8_t code :
       std::initializer_list<std::uint8_t>{2, 3, 4, 5, 7, 8, 9, 12, 13, 14, 15}) {
    names.insert(error_name(code));
  }
  EXPECT_EQ(names.size(), 11U);
  EXPECT_EQ(names.count("unknown error"), 0U);
  EXPECT_STREQ(error_name(0), "unknown error");
  EXPECT_STREQ(error_name(1), "unknown error");
  EXPECT_STREQ(error_name(200), "unknown error");
  EXPECT_EQ(cyclic_frames(bench_options(), 500.0).size(), 6U);
  const auto motion = cyclic_frames(motion_options(), 1000.0);
  ASSERT_EQ(motion.size(), 4U);
  EXPECT_DOUBLE_EQ(motion[1].share, 0.02);
  EXPECT_NEAR(family().position_period_rad(bench_options()), 2.0 * std::numbers::pi, 1e-12);
}

/// Steps a dialogue against a drive until it is over.
void converse(BenchDialogue& dialogue, SimulatedDrive* drive, std::vector<Frame>* sent = nullptr) {
  std::array<Frame, SimulatedDrive::kMaxReplies> reply;
  std::int64_t now_ns = 1'000'000'000;
  for (int i = 0; i < 10'000 && !dialogue.over(); ++i, now_ns += 1'000'000) {
    const auto request = dialogue.transmit(now_ns);
    if (request && sent != nullptr) {
      sent->push_back(*request);
    }
    if (request && drive != nullptr && drive->receive(*request, now_ns, reply) == 1) {
      dialogue.receive({reply[0], now_ns + 300'000});
    }
  }
  EXPECT_TRUE(dialogue.over());
}

TEST(MyactuatorBench, TheScannerAsksAndCommandsNothing) {
  Simulated drive(bench_options());
  std::array<Frame, SimulatedDrive::kMaxReplies> reply;
  drive.receive(encode_value(3, Command::kWatchdog, 10), 0, reply);  // swallows the first request
  BusScanner scanner;
  std::vector<Frame> sent;
  converse(scanner, &drive, &sent);
  const auto found = scanner.found();
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].id, 3U);
  EXPECT_EQ(found[0].reply_id, 0x243U);
  EXPECT_EQ(found[0].model, "X8S2V40");
  EXPECT_EQ(found[0].firmware, "20240315");
  EXPECT_NE(found[0].remarks.back().find("48.0 V"), std::string::npos);
  for (const Frame& frame : sent) {
    EXPECT_TRUE(frame.data[0] == 0x9A || frame.data[0] == 0xB2 || frame.data[0] == 0xB5);
  }
}

TEST(MyactuatorBench, ZeroingReadsBackAfterARestart) {
  Simulated drive(bench_options());
  drive.set_shaft(1.25, 0.0);
  ZeroSetter setter(bench_options());
  std::vector<Frame> sent;
  converse(setter, &drive, &sent);
  EXPECT_TRUE(setter.done()) << setter.report();
  EXPECT_NEAR(setter.before_rad(), 1.25, 1e-3);
  EXPECT_NEAR(setter.after_rad(), 0.0, 1e-3);
  std::size_t writes = 0;
  for (const Frame& frame : sent) {
    writes += frame.data[0] == 0x64 ? 1U : 0U;
  }
  EXPECT_EQ(writes, 1U);
}

TEST(MyactuatorBench, ZeroingRefusesWhatMovesRunsOrFails) {
  Simulated moving(bench_options());
  moving.set_shaft(1.0, 3.0);
  ZeroSetter first(bench_options());
  converse(first, &moving);
  EXPECT_FALSE(first.done());
  EXPECT_NE(first.report().find("moves"), std::string::npos);
  Simulated failed(bench_options());
  failed.inject_error(2);
  ZeroSetter second(bench_options());
  converse(second, &failed);
  EXPECT_NE(second.report().find("stall"), std::string::npos);
  ZeroSetter third(bench_options());
  converse(third, nullptr);
  EXPECT_NE(third.report().find("does not answer"), std::string::npos);
  Simulated running(bench_options());
  std::array<Frame, SimulatedDrive::kMaxReplies> reply;
  running.receive(*encode_torque(3, 2.0), 0, reply);
  ZeroSetter fourth(bench_options());
  converse(fourth, &running);
  EXPECT_NE(fourth.report().find("makes torque"), std::string::npos);
}

class MyactuatorSimulated : public ::testing::Test {
 protected:
  Frame ask(const Frame& frame) {
    now_ns += 1'000'000;
    EXPECT_EQ(drive.receive(frame, now_ns, reply), 1U);
    return reply[0];
  }

  Simulated drive{bench_options()};
  std::array<Frame, SimulatedDrive::kMaxReplies> reply;
  std::int64_t now_ns = 0;
};

TEST_F(MyactuatorSimulated, SwallowsTheFirstCommandAfterItsWatchdog) {
  ask(encode_value(3, Command::kWatchdog, 20));
  const Frame command = *encode_torque(3, 2.0);
  ask(command);
  EXPECT_NEAR(drive.torque_nm(now_ns), 4.0, 1e-9);
  now_ns += 30'000'000;
  EXPECT_EQ(drive.torque_nm(now_ns), 0.0);
  ASSERT_EQ(drive.speak(now_ns, reply), 1U);
  EXPECT_EQ(reply[0].data[0], 0xF1);
  EXPECT_EQ(drive.speak(now_ns + 900'000'000, reply), 0U);
  EXPECT_EQ(drive.speak(now_ns + 1'000'000'000, reply), 1U);
  const Frame sent_back = ask(*encode_torque(3, 3.0));
  EXPECT_EQ(sent_back.data, encode_torque(3, 3.0)->data);
  ask(*encode_torque(3, 3.0));
  EXPECT_NEAR(drive.torque_nm(now_ns), 6.0, 1e-9);
}

TEST_F(MyactuatorSimulated, HearsItsOwnIdentifiersTheBroadcastAndWholeFrames) {
  Frame frame = encode_request(3, Command::kStatus1);
  frame.id = kBroadcastId;
  EXPECT_EQ(ask(frame).id, 0x243U);
  frame.id = 0x144;
  EXPECT_EQ(drive.receive(frame, now_ns, reply), 0U);
  frame.id = 0x143;
  frame.length = 4;
  EXPECT_EQ(drive.receive(frame, now_ns, reply), 0U);
  EXPECT_EQ(drive.receive(encode_request(3, static_cast<Command>(0x42)), now_ns, reply), 0U);
}

TEST_F(MyactuatorSimulated, LosesTurnsAtPowerOffUnlessItSavesThem) {
  drive.set_shaft(9.0, 0.0);
  drive.power_cycle();
  EXPECT_EQ(drive.receive(encode_request(3, Command::kAngle), now_ns, reply), 0U);
  now_ns += Simulated::kBootNs;
  EXPECT_NEAR(*decode_angle(ask(encode_request(3, Command::kAngle))) * kDegree,
              9.0 - 2.0 * std::numbers::pi, 1e-3);
  Simulated other(bench_options());
  other.receive(encode_value(3, Command::kFunction, 1, 4), 0, reply);
  other.set_shaft(9.0, 0.0);
  other.power_cycle();
  other.receive(encode_request(3, Command::kAngle), 0, reply);
  other.receive(encode_request(3, Command::kAngle), now_ns, reply);
  EXPECT_NEAR(*decode_angle(reply[0]) * kDegree, 9.0, 1e-3);
  other.receive(encode_value(3, Command::kFunction, 1, 1), now_ns, reply);
  other.receive(encode_request(3, Command::kAngle), now_ns, reply);
  EXPECT_NEAR(*decode_angle(reply[0]) * kDegree, 9.0 - 2.0 * std::numbers::pi, 1e-3);
}

TEST_F(MyactuatorSimulated, StopsAndFailsWithoutTorque) {
  ask(*encode_torque(3, 2.0));
  ask(encode_request(3, Command::kStop));
  EXPECT_EQ(drive.torque_nm(now_ns), 0.0);
  EXPECT_TRUE(drive.enabled());
  ask(*encode_speed(3, 100.0));
  EXPECT_FALSE(drive.enabled());
  drive.set_temperature(101.0);
  ask(*encode_torque(3, 2.0));
  EXPECT_EQ(drive.torque_nm(now_ns), 0.0);
  EXPECT_EQ(decode_status1(ask(encode_request(3, Command::kStatus1)))->errors, 0x1000);
  EXPECT_EQ(decode_status3(ask(encode_request(3, Command::kStatus3)))->temperature_c, 101.0);
}

}  // namespace
}  // namespace geodesic::drivers::myactuator::test
