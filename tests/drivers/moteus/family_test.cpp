// The moteus family for people: words for frames, checks of options, scanning and zeroing.
#include "drivers/moteus/family.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <stdexcept>

#include "drivers/arm.hpp"
#include "drivers/moteus/scanner.hpp"
#include "drivers/moteus/zeroing.hpp"
#include "tests/drivers/moteus/bench.hpp"

namespace geodesic::drivers::moteus::test {
namespace {

std::string words(const Frame& frame) {
  const auto decoded = decode(frame, bench_options());
  if (!decoded) {
    return "nothing";
  }
  std::string text = decoded->kind;
  for (const DecodedField& field : decoded->fields) {
    text.append(", ").append(field.name).append(" ").append(field.value);
    text.append(field.unit.empty() ? "" : " ").append(field.unit);
  }
  return text;
}

TEST(MoteusFamily, TellsFramesInWords) {
  const Link link{0, 5, 0};
  const Formats formats = formats_for(bench_options());
  const std::string asks = ", asks for mode, position, velocity, torque, temperature, fault";
  EXPECT_EQ(words(encode_query(link, formats)), "query" + asks);
  EXPECT_EQ(words(encode_stop(link, formats)), "stopped command, mode stopped" + asks);
  PositionCommand command;
  command.torque_nm = -1.5;
  command.max_torque_nm = 10.0;
  command.watchdog_ns = 50'000'000;
  EXPECT_EQ(words(encode_position(link, formats, command, false).value()),
            "position command, mode position, position command nan rev, feed-forward torque -1.5 "
            "N·m, kp scale 0, kd scale 0, maximum torque 10 N·m, watchdog timeout 0.05 s, ilimit "
            "scale 0" +
                asks);
  EXPECT_EQ(words(encode_text(link, "conf write\n")), "console, text 'conf write '");
  EXPECT_EQ(words(encode_query({0, 6, 0}, formats)), "nothing");
  Frame reply;
  reply.id = 0x0500;
  reply.fd = true;
  reply.length = 16;
  reply.data = {0x21, 0x00, 0x01, 0x27, 0x01, 0x72, 0x1C, 0, 0, 0, 0, 0x23, 0x0D, 0x1D, 0x18, 0x22};
  EXPECT_EQ(words(reply),
            "state, mode fault, position 0.7282 rev, velocity 0 rev/s, torque 0 N·m, voltage 14.5 "
            "V, temperature 24 °C, fault over-voltage");
  reply.length = 8;
  reply.data = {0x31, 0x82, 0x02, 0x01, 0x30, 0x01, 0x02, 0x50};
  EXPECT_EQ(words(reply),
            "register reply, read error register map version: unknown, write error position: not "
            "writeable");
  reply.data = {0x60, 0, 0, 0, 0, 0, 0, 0};
  EXPECT_EQ(words(reply), "register reply, malformed the rest makes no sense");
}

TEST(MoteusFamily, ChecksOptions) {
  const auto wrong = [](auto change) {
    DriveOptions options = bench_options();
    change(options);
    return check(options).size();
  };
  EXPECT_EQ(wrong([](DriveOptions&) {}), 0U);
  EXPECT_EQ(wrong([](DriveOptions& o) {
              o.id = 0;
              o.settings.values[kHostId] = 1;
            }),
            1U);
  EXPECT_EQ(wrong([](DriveOptions& o) { o.id = 127; }), 1U);
  EXPECT_EQ(wrong([](DriveOptions& o) { o.settings.values[kHostId] = 5; }), 1U);
  EXPECT_EQ(wrong([](DriveOptions& o) { o.reply_id = 0x500; }), 0U);
  EXPECT_EQ(wrong([](DriveOptions& o) { o.reply_id = 0x501; }), 1U);
  EXPECT_EQ(wrong([](DriveOptions& o) { o.fd = false; }), 1U);
  EXPECT_EQ(wrong([](DriveOptions& o) { o.torque_range_nm = 0.0; }), 1U);
  EXPECT_EQ(wrong([](DriveOptions& o) { o.velocity_range_rad_s = 0.0 / 0.0; }), 1U);
  EXPECT_EQ(wrong([](DriveOptions& o) { o.position_range_rad = -1.0; }), 1U);
  EXPECT_EQ(wrong([](DriveOptions& o) { o.watchdog_ns = 0; }), 1U);
  EXPECT_EQ(wrong([](DriveOptions& o) { o.watchdog_ns = 11'000'000'000; }), 1U);
}

TEST(MoteusFamily, NamesEveryFaultAndLimit) {
  std::set<std::string> names = {error_name(11)};
  for (std::uint8_t code = 32; code <= 50; ++code) {
    names.insert(error_name(code));
  }
  for (std::uint8_t code = 96; code <= 105; ++code) {
    names.insert(error_name(code));
  }
  EXPECT_EQ(names.size(), 1U + 19U + 10U);
  EXPECT_EQ(names.count("unknown error"), 0U);
  EXPECT_STREQ(error_name(200), "unknown error");
}

TEST(MoteusFamily, TellsItsCycleAndItsPeriod) {
  const Family line = family();
  DriveOptions options = bench_options();
  const auto frames = line.cyclic_frames(options, 1000.0);
  ASSERT_EQ(frames.size(), 2U);
  EXPECT_EQ(frames[0].bytes, 32);
  EXPECT_TRUE(frames[0].extended);
  EXPECT_EQ(frames[1].bytes, 20);
  EXPECT_FALSE(frames[1].extended);
  Bench bench;  // and these are what goes over the wire
  ASSERT_GT(bench.run_until(control::DriveCondition::kEnabled, enable()), 0);
  bench.cycle(enable(1.0));
  EXPECT_EQ(bench.sent.back().id, frames[0].id);
  EXPECT_EQ(bench.sent.back().length, frames[0].bytes);
  std::array<Frame, 1> reply;
  ASSERT_EQ(bench.drive.receive(bench.sent.back(), bench.now_ns, reply), 1U);
  EXPECT_EQ(reply[0].id, frames[1].id);
  EXPECT_EQ(reply[0].length, frames[1].bytes);
  EXPECT_DOUBLE_EQ(line.position_period_rad(options), kTurn);
  EXPECT_DOUBLE_EQ(line.position_period_rad(with(kHome, 1.0, with(kRatio, 0.125))), kTurn / 8);
  EXPECT_EQ(line.make_scanner(false), nullptr);
}

TEST(MoteusFamily, SharesABusWithOthersUnlessTheirIdentifiersEndLikeIts) {
  ArmOptions arm;
  arm.buses.resize(1);
  arm.buses[0].name = "arm";
  arm.buses[0].fd = true;
  JointOptions joint;
  joint.name = "a";
  joint.drive = bench_options();
  arm.joints.push_back(joint);
  joint.name = "b";
  joint.drive.id = 8;
  arm.joints.push_back(joint);
  joint.name = "c";
  joint.drive = bench_options();
  joint.drive.family = "damiao";
  joint.drive.id = 0x21;
  joint.drive.reply_id = 0x31;
  joint.drive.position_range_rad = 12.5;
  joint.drive.velocity_range_rad_s = 30.0;
  joint.drive.torque_range_nm = 10.0;
  arm.joints.push_back(joint);
  EXPECT_NO_THROW(filtered_buses(arm));
  // The short answer 0x108 would be a command to drive 8.
  arm.joints.back().drive.reply_id = 0x108;
  EXPECT_THROW(filtered_buses(arm), std::invalid_argument);
  arm.joints.pop_back();
  arm.joints.back().drive.settings.values[kHostId] = 5;  // it answers to drive 5, not to a host
  EXPECT_THROW(filtered_buses(arm), std::invalid_argument);
}

/// Steps a dialogue against simulated drives until it is over. @return milliseconds, or -1.
template <class Dialogue>
int converse(Dialogue& dialogue, std::vector<Simulated*> drives, int at_most_ms = 10'000) {
  std::int64_t now_ns = 1'000'000'000;
  for (int ms = 0; ms < at_most_ms; ++ms, now_ns += 1'000'000) {
    if (dialogue.over()) {
      return ms;
    }
    const auto frame = dialogue.transmit(now_ns);
    for (Simulated* drive : drives) {
      std::array<Frame, 1> reply;
      if (frame && drive->receive(*frame, now_ns, reply) == 1) {
        dialogue.receive({reply[0], now_ns + 200'000});
      }
    }
  }
  return -1;
}

TEST(MoteusScanner, FindsWhoAnswersAndWhatIsAmiss) {
  DriveOptions options = bench_options();
  Simulated well(options);
  options.id = 126;
  Simulated rotor(with(kHome, 1.0, options));
  rotor.inject_error(34);
  options.id = 9;
  Simulated one(options);
  Simulated two(options);
  Scanner scanner;
  ASSERT_GT(converse(scanner, {&well, &rotor, &one, &two}), 0);
  const std::vector<FoundDrive> found = scanner.found();
  ASSERT_EQ(found.size(), 3U);
  EXPECT_EQ(found[0].id, 5U);
  EXPECT_EQ(found[0].firmware, "1.1.0");
  EXPECT_EQ(found[0].remarks.size(), 1U);
  EXPECT_EQ(found[1].id, 9U);
  EXPECT_NE(found[1].remarks.back().find("two drives"), std::string::npos);
  EXPECT_EQ(found[2].id, 126U);
  EXPECT_NE(found[2].remarks.back().find("over-voltage"), std::string::npos);
  EXPECT_NE(std::find(found[2].options.begin(), found[2].options.end(),
                      std::pair<std::string, std::string>("home", "\"rotor\"")),
            found[2].options.end());
  EXPECT_FALSE(well.enabled());
  EXPECT_EQ(rotor.fault(), 34);  // a scan clears nothing
}

TEST(MoteusZeroing, SetsKeepsAndReadsBack) {
  for (const double home : {0.0, 1.0}) {
    Simulated drive(with(kHome, home, with(kRatio, 0.5)));
    drive.set_shaft(0.7, 0.0);
    Zeroing zeroing(with(kHome, home));
    ASSERT_GT(converse(zeroing, {&drive}), 0);
    EXPECT_TRUE(zeroing.done()) << zeroing.report();
    EXPECT_NEAR(zeroing.before_rad(), 0.7, 1e-5);
    EXPECT_NEAR(zeroing.after_rad(), 0.0, 1e-5);
    drive.power_cycle();
    drive.set_shaft(1.0, 0.0);
    std::array<Frame, 1> reply;
    drive.receive(encode_query({0, 5, 0}, {}), 0, reply);
    EXPECT_NEAR(*decode_report(reply[0]).position_rev * kTurn, 0.3, 1e-5);
  }
}

TEST(MoteusZeroing, RefusesWhatIsNotAtRest) {
  const auto report = [](Simulated& drive, bool mute = false) {
    Zeroing zeroing(bench_options());
    EXPECT_GT(converse(zeroing, mute ? std::vector<Simulated*>{} : std::vector{&drive}), 0);
    EXPECT_FALSE(zeroing.done());
    return zeroing.report();
  };
  Simulated drive(bench_options());
  EXPECT_NE(report(drive, true).find("does not answer"), std::string::npos);
  drive.inject_error(36);
  EXPECT_NE(report(drive).find("moteus_tool --calibrate"), std::string::npos);
  drive.power_cycle();
  drive.set_home(Home::kRelative);
  EXPECT_NE(report(drive).find("referenced to nothing"), std::string::npos);
  drive.power_cycle();
  PositionCommand other;
  other.watchdog_ns = 5'000'000'000;
  std::array<Frame, 1> reply;
  drive.receive(encode_position({1, 5, 0}, {}, other, false).value(), 999'000'000, reply);
  EXPECT_NE(report(drive).find("enabled"), std::string::npos);
  drive.power_cycle();
  drive.lose_encoder();
  EXPECT_NE(report(drive).find("no valid position"), std::string::npos);
  EXPECT_EQ(drive.config().output_offset, 0.0F);
}

}  // namespace
}  // namespace geodesic::drivers::moteus::test
