// The CubeMars family for people: words for frames, checks of options, the dialogues at the bench,
// and the simulated drive where nothing else looks at it.
#include "drivers/cubemars/family.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>

#include "drivers/cubemars/bench.hpp"
#include "tests/drivers/cubemars/bench.hpp"

namespace geodesic::drivers::cubemars::test {
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

TEST(CubemarsFamily, TellsFramesInWords) {
  EXPECT_EQ(words(encode_special(5, Special::kEnter)), "enter MIT control");
  EXPECT_EQ(words(encode_special(6, Special::kEnter)), "nothing");
  EXPECT_EQ(words(*encode_mit(5, {.torque_nm = 18.0}, kRanges)),
            "MIT command, position 0.000190738 rad, velocity 0.01221 rad/s, stiffness 0 N·m/rad, "
            "damping 0 N·m·s/rad, torque 18 N·m");
  Frame reply;
  reply.length = 8;
  reply.data = {5, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 68, 4};
  EXPECT_EQ(words(reply),
            "MIT reply, motor 5, position 12.5 rad, velocity 50 rad/s, torque 18 N·m, temperature "
            "28 °C, error under-voltage");
  reply.length = 7;
  reply.data[6] = 0x99;
  EXPECT_NE(words(reply).find("bus voltage 24 V"), std::string::npos);
  reply.data[0] = 6;
  EXPECT_EQ(words(reply), "nothing");
  EXPECT_EQ(words(*encode_servo(5, {Function::kCurrent, -1.5})),
            "servo current command, current -1.5 A");
  EXPECT_EQ(words(*encode_servo(5, {Function::kOrigin, 1.0})), "servo set origin, kept for good");
  Frame status;
  status.id = 0x2905;
  status.extended = true;
  status.length = 8;
  status.data = {0x0B, 0xB8, 0xFF, 0x38, 0x01, 0x2C, 0x2A, 0x00};
  EXPECT_EQ(words(status, bench_options()),
            "servo status, position 300 deg, speed -2000 erpm, current 3 A, temperature 42 °C, "
            "error none");
  EXPECT_NE(words(status, servo_options()).find("torque 3.105 N·m"), std::string::npos);
}

TEST(CubemarsFamily, ChecksOptions) {
  const auto wrong = [](auto change, DriveOptions options = bench_options()) {
    change(options);
    return check(options).size();
  };
  EXPECT_EQ(wrong([](DriveOptions&) {}), 0U);
  EXPECT_EQ(wrong([](DriveOptions&) {}, servo_options()), 0U);
  EXPECT_EQ(wrong([](DriveOptions& o) { o.id = 0; }), 1U);
  EXPECT_EQ(wrong([](DriveOptions& o) { o.id = 0x100; }), 1U);
  EXPECT_EQ(wrong([](DriveOptions& o) { o.reply_id = 0x7FF; }), 1U);
  EXPECT_EQ(wrong([](DriveOptions& o) { o.fd = true; }), 1U);
  EXPECT_EQ(wrong([](DriveOptions& o) { o.position_range_rad = 0.0; }), 1U);
  EXPECT_EQ(wrong([](DriveOptions& o) { o.velocity_range_rad_s = -1.0; }), 1U);
  EXPECT_EQ(
      wrong([](DriveOptions& o) { o.torque_range_nm = std::numeric_limits<double>::quiet_NaN(); }),
      1U);
  EXPECT_EQ(wrong([](DriveOptions& o) { o.watchdog_ns = 0; }), 1U);
  EXPECT_EQ(wrong([](DriveOptions& o) { o.settings.values[kGearRatio] = kNotSet; }), 1U);
  EXPECT_EQ(
      wrong([](DriveOptions& o) { o.settings.values[kTorqueConstant] = kNotSet; }, servo_options()),
      1U);
}

TEST(CubemarsFamily, NamesItsErrorsAndFrames) {
  std::set<std::string> names;
  for (std::uint8_t code = 1; code <= 7; ++code) {
    names.insert(error_name(code));
  }
  EXPECT_EQ(names.size(), 7U);
  EXPECT_STREQ(error_name(8), "unknown error");
  const auto mit = cyclic_frames(bench_options(), 500.0);
  ASSERT_EQ(mit.size(), 2U);
  EXPECT_TRUE(mit[1].reply);
  const auto servo = cyclic_frames(servo_options(), 1000.0);
  EXPECT_TRUE(servo[0].extended);
  EXPECT_TRUE(servo[1].unasked);
  EXPECT_EQ(servo[1].share, 0.5);
}

/// Steps a dialogue against drives until it is over.
void converse(BenchDialogue& dialogue, const std::vector<SimulatedDrive*>& drives,
              std::vector<Frame>* sent = nullptr) {
  std::array<Frame, SimulatedDrive::kMaxReplies> reply;
  std::int64_t now_ns = 1'000'000'000;
  for (int i = 0; i < 10'000 && !dialogue.over(); ++i, now_ns += 1'000'000) {
    const auto request = dialogue.transmit(now_ns);
    if (request && sent != nullptr) {
      sent->push_back(*request);
    }
    for (SimulatedDrive* drive : drives) {
      std::size_t count = request ? drive->receive(*request, now_ns, reply) : 0;
      for (std::size_t k = 0; k < count; ++k) {
        dialogue.receive({reply[k], now_ns + 300'000});
      }
      count = drive->speak(now_ns, reply);
      for (std::size_t k = 0; k < count; ++k) {
        dialogue.receive({reply[k], now_ns + 300'000});
      }
    }
  }
  EXPECT_TRUE(dialogue.over());
}

TEST(CubemarsBench, TheScannerFindsDrivesOfBothModesAndCommandsNone) {
  DriveOptions other = servo_options();
  other.id = 0x68;
  Simulated mit(bench_options());
  Simulated servo(other);
  BusScanner scanner;
  std::vector<Frame> sent;
  converse(scanner, {&mit, &servo}, &sent);
  const auto found = scanner.found();
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].id, 5U);
  EXPECT_EQ(found[0].reply_id, 0U);
  EXPECT_EQ(found[1].id, 0x68U);
  EXPECT_EQ(found[1].options[0].second, "\"servo\"");
  for (const Frame& frame : sent) {
    EXPECT_TRUE(decode_special(frame) == Special::kExit || frame.id == 0x7FF);
  }
  EXPECT_FALSE(mit.enabled());
}

TEST(CubemarsBench, AnswersOfADamiaoDriveAreNotTaken) {
  BusScanner scanner;
  std::int64_t now_ns = 0;
  for (int i = 0; i < 2000 && !scanner.over(); ++i, now_ns += 1'000'000) {
    const auto request = scanner.transmit(now_ns);
    if (!request || (request->id != 5 && request->id != 0x7FF)) {
      continue;
    }
    Frame reply = *request;  // byte 0 of its state: disabled, low bits of its identifier
    reply.id = 0x15;
    if (request->id == 5) {
      reply.data = {0x05, 0x80, 0x00, 0x80, 0x08, 0x00, 25, 25};
    }
    scanner.receive({reply, now_ns});
  }
  EXPECT_TRUE(scanner.over());
  EXPECT_TRUE(scanner.found().empty());
}

TEST(CubemarsBench, ZeroingReadsBack) {
  Simulated mit(bench_options());
  mit.set_shaft(1.25, 0.0);
  ZeroSetter setter(bench_options());
  converse(setter, {&mit});
  EXPECT_TRUE(setter.done()) << setter.report();
  EXPECT_NEAR(setter.before_rad(), 1.25, 1e-3);
  EXPECT_NEAR(setter.after_rad(), 0.0, 1e-3);
  Simulated servo(servo_options());
  servo.set_shaft(1.25, 0.0);
  ZeroSetter servo_setter(servo_options());
  converse(servo_setter, {&servo});
  EXPECT_TRUE(servo_setter.done()) << servo_setter.report();
}

TEST(CubemarsBench, ZeroingRefusesWhatMovesFailsOrForgets) {
  Simulated moving(bench_options());
  moving.set_shaft(1.0, 3.0);
  ZeroSetter first(bench_options());
  converse(first, {&moving});
  EXPECT_FALSE(first.done());
  EXPECT_NE(first.report().find("moves"), std::string::npos);
  Simulated failed(bench_options());
  failed.inject_error(5);
  ZeroSetter second(bench_options());
  converse(second, {&failed});
  EXPECT_NE(second.report().find("encoder"), std::string::npos);
  ZeroSetter third(bench_options());
  converse(third, {});
  EXPECT_NE(third.report().find("does not report"), std::string::npos);
  DriveOptions forgets = servo_options();
  forgets.settings.values[kEncoder] = 0.0;
  ZeroSetter fourth(forgets);
  EXPECT_TRUE(fourth.over());
  EXPECT_FALSE(fourth.done());
}

TEST(CubemarsSimulated, ReportsTheStateBeforeTheCommand) {
  Simulated drive(bench_options());
  std::array<Frame, SimulatedDrive::kMaxReplies> reply;
  drive.receive(encode_special(5, Special::kEnter), 0, reply);
  const Frame command = *encode_mit(5, {.torque_nm = 9.0}, kRanges);
  drive.receive(command, 1'000'000, reply);
  EXPECT_NEAR(decode_reply(reply[0], kRanges)->torque_nm, 0.0, 0.01);
  drive.receive(command, 2'000'000, reply);
  EXPECT_NEAR(decode_reply(reply[0], kRanges)->torque_nm, 9.0, 0.01);
  // Its watchdog ends the torque, and the next command brings it back: this drive does not latch.
  EXPECT_EQ(drive.torque_nm(40'000'000), 0.0);
  drive.receive(command, 41'000'000, reply);
  EXPECT_NEAR(drive.torque_nm(41'000'000), 9.0, 0.01);
}

TEST(CubemarsSimulated, IsDeafAfterZeroingAndWrapsWhereItsCodesEnd) {
  Simulated drive(bench_options());
  std::array<Frame, SimulatedDrive::kMaxReplies> reply;
  drive.set_shaft(3.0, 0.0);
  EXPECT_EQ(drive.receive(encode_special(5, Special::kSetZero), 0, reply), 1U);
  EXPECT_EQ(drive.receive(encode_special(5, Special::kExit), 999'000'000, reply), 0U);
  ASSERT_EQ(drive.receive(encode_special(5, Special::kExit), 1'000'000'000, reply), 1U);
  EXPECT_NEAR(decode_reply(reply[0], kRanges)->position_rad, 0.0, 1e-3);
  drive.set_shaft(3.0 + 13.0, 0.0);
  drive.receive(encode_special(5, Special::kExit), 1'001'000'000, reply);
  EXPECT_NEAR(decode_reply(reply[0], kRanges)->position_rad, -12.0, 2e-3);
}

TEST(CubemarsSimulated, HeatIsAnError) {
  Simulated drive(bench_options());
  std::array<Frame, SimulatedDrive::kMaxReplies> reply;
  drive.receive(encode_special(5, Special::kEnter), 0, reply);
  drive.set_temperature(101.0);
  EXPECT_FALSE(drive.enabled());
  drive.receive(encode_special(5, Special::kEnter), 0, reply);
  EXPECT_FALSE(drive.enabled());
  EXPECT_EQ(decode_reply(reply[0], kRanges)->error, 1);
}

}  // namespace
}  // namespace geodesic::drivers::cubemars::test
