// The RobStride family for people: checks of options, names, frames in words, scanner, zeroing.
#include "drivers/robstride/family.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <numbers>
#include <string>

#include "drivers/robstride/scanner.hpp"
#include "drivers/robstride/zeroing.hpp"
#include "tests/drivers/robstride/bench.hpp"

namespace geodesic::drivers::robstride::test {
namespace {

TEST(RobstrideFamily, ChecksEveryOption) {
  EXPECT_TRUE(check(bench_options()).empty());
  EXPECT_TRUE(check(bench_options(true)).empty());
  struct Case {
    const char* says;
    std::function<void(DriveOptions&)> spoil;
  };
  for (const Case& one : {
           Case{"the drive's id", [](DriveOptions& o) { o.id = 0; }},
           Case{"the drive's id", [](DriveOptions& o) { o.id = 128; }},
           Case{"reply id", [](DriveOptions& o) { o.reply_id = 0x15; }},
           Case{"host_id", [](DriveOptions& o) { o.settings.values[kHostId] = 5; }},
           Case{"host_id", [](DriveOptions& o) { o.settings.values[kHostId] = 253.5; }},
           Case{"classic CAN", [](DriveOptions& o) { o.fd = true; }},
           Case{"position range", [](DriveOptions& o) { o.position_range_rad = 0; }},
           Case{"velocity range", [](DriveOptions& o) { o.velocity_range_rad_s = -1; }},
           Case{"torque range", [](DriveOptions& o) { o.torque_range_nm = 1.0 / 0.0; }},
           Case{"stiffness_range",
                [](DriveOptions& o) { o.settings.values[kStiffnessRange] = kNotSet; }},
           Case{"damping_range", [](DriveOptions& o) { o.settings.values[kDampingRange] = 0; }},
           Case{"torque_limit_nm", [](DriveOptions& o) { o.settings.values[kTorqueLimit] = 18; }},
           Case{"least_firmware", [](DriveOptions& o) { o.settings.values[kLeastFirmware] = -1; }},
           Case{"watchdog", [](DriveOptions& o) { o.watchdog_ns = 0; }},
       }) {
    DriveOptions options = bench_options();
    one.spoil(options);
    const std::vector<std::string> wrong = check(options);
    ASSERT_FALSE(wrong.empty()) << one.says;
    EXPECT_NE(wrong[0].find(one.says), std::string::npos) << wrong[0];
  }
}

TEST(RobstrideFamily, EveryErrorHasItsName) {
  EXPECT_STREQ(error_name(1), "under-voltage");
  EXPECT_NE(std::string(error_name(33)).find("driver chip"), std::string::npos);
  EXPECT_NE(std::string(error_name(kRebooted)).find("off and on"), std::string::npos);
  EXPECT_NE(std::string(error_name(kLeftRunMode)).find("watchdog"), std::string::npos);
  EXPECT_STREQ(error_name(200), "unknown error");
  for (int code = 0; code < 256; ++code) {
    EXPECT_NE(error_name(static_cast<std::uint8_t>(code)), nullptr);
  }
}

TEST(RobstrideFamily, TellsFramesInWords) {
  const DriveOptions options = bench_options();
  const auto kind = [&options](const Frame& frame) {
    const auto words = decode(frame, options);
    return words ? words->kind : std::string();
  };
  EXPECT_EQ(kind(*encode_control(5, {.torque_nm = 1.0}, kRanges)), "operation control");
  EXPECT_EQ(kind(encode_enable(kLink)), "enable");
  EXPECT_EQ(kind(encode_stop(kLink, false)), "stop");
  EXPECT_EQ(kind(encode_stop(kLink, true)), "stop and clear faults");
  EXPECT_EQ(kind(encode_version_query(kLink)), "stop and version query");
  EXPECT_EQ(kind(encode_write(kLink, 0x7028, 1000)), "parameter write");
  EXPECT_EQ(kind(encode_zero({.motor = 6, .host = 0xFD})), "");
  Simulated drive(options);
  std::array<Frame, 4> reply;
  drive.inject_error(2);
  ASSERT_EQ(drive.receive(encode_stop(kLink, false), 0, reply), 1U);
  const auto words = decode(reply[0], options);
  ASSERT_TRUE(words);
  EXPECT_EQ(words->kind, "feedback");
  EXPECT_EQ(words->fields[1].value, "over-current");
  ASSERT_EQ(drive.receive(encode_read(kLink, 0x700B), 0, reply), 1U);
  EXPECT_EQ(decode(reply[0], options)->fields[2].value, "17");
}

/// Runs a dialogue of the bench against simulated drives to its end.
void hold(BenchDialogue& dialogue, const std::vector<Simulated*>& drives) {
  std::int64_t now_ns = 0;
  for (int i = 0; i < 5000 && !dialogue.over(); ++i) {
    now_ns += 1'000'000;
    const std::optional<Frame> frame = dialogue.transmit(now_ns);
    for (Simulated* drive : drives) {
      std::array<Frame, SimulatedDrive::kMaxReplies> reply;
      const std::size_t count = frame ? drive->receive(*frame, now_ns, reply) : 0;
      for (std::size_t k = 0; k < count; ++k) {
        dialogue.receive({reply[k], now_ns + 200'000});
      }
    }
  }
  EXPECT_TRUE(dialogue.over());
}

TEST(RobstrideScanner, FindsDrivesAndProposesOptionsThatPass) {
  DriveOptions second = bench_options();
  second.id = 0x7F;
  second.torque_range_nm = 12.0;
  second.position_range_rad = 12.5;
  second.settings.values[kVariant] = 1.0;
  Simulated one(bench_options());
  Simulated two(second);
  std::array<Frame, 4> reply;
  one.receive(encode_enable(kLink), 0, reply);
  ASSERT_TRUE(one.enabled());
  one.set_parameter(0x7029, 0);
  Scanner scanner;
  hold(scanner, {&one, &two});
  EXPECT_TRUE(one.enabled());  // whoever it works for, it goes on
  const std::vector<FoundDrive> found = scanner.found();
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].id, 5U);
  EXPECT_NE(found[0].model.find("RS02"), std::string::npos);
  EXPECT_EQ(found[1].id, 0x7FU);
  EXPECT_NE(found[1].model.find("CyberGear"), std::string::npos);
  EXPECT_EQ(found[0].options[0].second, "\"robstride\"");
  EXPECT_EQ(found[1].options[0].second, "\"cybergear\"");
  EXPECT_EQ(found[0].options.size(), 6U);
  std::string remarks;
  for (const std::string& remark : found[0].remarks) {
    remarks.append(remark).append("\n");
  }
  EXPECT_NE(remarks.find("watchdog is off"), std::string::npos) << remarks;
  EXPECT_NE(remarks.find("zero_sta"), std::string::npos);
}

TEST(RobstrideScanner, NobodyIsNobody) {
  Scanner scanner;
  hold(scanner, {});
  EXPECT_TRUE(scanner.found().empty());
  EXPECT_EQ(family().make_scanner(true), nullptr);
}

TEST(RobstrideZeroing, SetsSavesAndReadsBack) {
  Simulated drive(bench_options());
  drive.set_shaft(1.5, 0.0);
  drive.set_parameter(0x7029, 0);
  Zeroing zeroing(bench_options());
  hold(zeroing, {&drive});
  EXPECT_TRUE(zeroing.done()) << zeroing.report();
  EXPECT_NEAR(zeroing.before_rad(), 1.5, 1e-3);
  EXPECT_NEAR(zeroing.after_rad(), 0.0, 1e-3);
  drive.power_cycle();
  EXPECT_EQ(drive.parameter_raw(0x7029), 1U);
  Bench bench;
  bench.drive = drive;
  ASSERT_GT(bench.run_until(control::DriveCondition::kDisabled), 0);
  EXPECT_NEAR(bench.driver.state().position_rad, 0.0, 1e-3);
}

TEST(RobstrideZeroing, RefusesADriveThatRunsOrHasAFaultOrIsAnother) {
  Simulated runs(bench_options());
  std::array<Frame, 4> reply;
  runs.receive(encode_enable(kLink), 0, reply);
  Simulated faulty(bench_options());
  faulty.inject_error(2);
  DriveOptions strong = bench_options();
  strong.torque_range_nm = 60.0;
  Simulated other(strong);
  for (const auto& [drive, says] : std::vector<std::pair<Simulated*, std::string>>{
           {&runs, "not stopped"}, {&faulty, "over-current"}, {&other, "limit_torque"}}) {
    drive->set_shaft(1.0, 0.0);
    Zeroing zeroing(bench_options());
    hold(zeroing, {drive});
    EXPECT_FALSE(zeroing.done());
    EXPECT_NE(zeroing.report().find(says), std::string::npos) << zeroing.report();
  }
  EXPECT_TRUE(runs.enabled());
  Zeroing nobody(bench_options());
  hold(nobody, {});
  EXPECT_NE(nobody.report().find("does not answer"), std::string::npos);
}

TEST(RobstrideZeroing, RefusesADriveThatMoves) {
  Simulated drive(bench_options());
  Zeroing zeroing(bench_options());
  std::int64_t now_ns = 0;
  for (int i = 0; i < 2000 && !zeroing.over(); ++i) {
    now_ns += 1'000'000;
    drive.set_shaft(0.001 * i, 1.0);
    std::array<Frame, 4> reply;
    const auto frame = zeroing.transmit(now_ns);
    if (frame && drive.receive(*frame, now_ns, reply) == 1) {
      zeroing.receive({reply[0], now_ns});
    }
  }
  EXPECT_FALSE(zeroing.done());
  EXPECT_NE(zeroing.report().find("moves"), std::string::npos) << zeroing.report();
}

}  // namespace
}  // namespace geodesic::drivers::robstride::test
