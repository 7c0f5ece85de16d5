// The ODrive family for people: words for frames, checks of options, the frames of a cycle, the
// dialogues at the bench.
#include "drivers/odrive/family.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "drivers/odrive/scanner.hpp"
#include "drivers/odrive/words.hpp"
#include "drivers/odrive/zeroing.hpp"
#include "tests/drivers/odrive/bench.hpp"

namespace geodesic::drivers::odrive::test {
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

TEST(OdriveFamily, TellsFramesInWords) {
  EXPECT_EQ(words(*encode(kNode, kSetInputTorque, {0.75})),
            "Set_Input_Torque, Input_Torque 0.75 N·m");
  EXPECT_EQ(words(*encode(kNode, kSetAxisState, {kAxisClosedLoop})),
            "Set_Axis_State, Axis_Requested_State closed loop");
  EXPECT_EQ(words(encode_request(kNode, Command::kEstimates)), "Get_Encoder_Estimates request");
  EXPECT_EQ(words(*encode(kNode, kHeartbeat06, {16777216.0 + 4.0, 1.0, 3.0, 1.0})),
            "Heartbeat, Axis_Error timing error, watchdog expired, Axis_State idle, "
            "Procedure_Result disarmed, Trajectory_Done_Flag 1");
  EXPECT_EQ(words(*encode(kNode, kHeartbeat05, {2048.0, 1.0, 0.0, 1.0}), old_options()),
            "Heartbeat, Axis_Error watchdog expired, Axis_State idle, Motor_Error_Flag 0, "
            "Encoder_Error_Flag 1, Controller_Error_Flag 0, Trajectory_Done_Flag 0");
  EXPECT_EQ(words(*encode(kNode, kPowers06, {1.0, 2.0})),
            "Get_Powers, Electrical_Power 1 W, Mechanical_Power 2 W");
  EXPECT_EQ(words(*encode(kNode, kControllerError05, {1.0}), old_options()),
            "Get_Controller_Error, Controller_Error controller: overspeed");
  EXPECT_EQ(words(encode_sdo_read(kNode, 419)), "RxSdo, opcode 0, endpoint 419");
  EXPECT_EQ(words(*encode(kNode + 1, kSetInputTorque, {0.75})), "nothing");
  EXPECT_EQ(words(encode_request(kNode, Command::kVersion), old_options()), "Get_Version request");
  EXPECT_EQ(words(encode_request(kNode, static_cast<Command>(0x08))), "nothing");
}

TEST(OdriveFamily, ChecksOptions) {
  const auto wrong = [](auto change, DriveOptions options = bench_options()) {
    change(options);
    return check(options).size();
  };
  EXPECT_EQ(wrong([](DriveOptions&) {}), 0U);
  EXPECT_EQ(wrong([](DriveOptions&) {}, endpoint_options()), 0U);
  EXPECT_EQ(wrong([](DriveOptions&) {}, old_options()), 0U);
  EXPECT_EQ(wrong([](DriveOptions& o) { o.id = 0; }), 0U);
  EXPECT_EQ(wrong([](DriveOptions& o) { o.id = 63; }), 1U);
  EXPECT_EQ(wrong([](DriveOptions& o) { o.reply_id = 5; }), 1U);
  EXPECT_EQ(wrong([](DriveOptions& o) { o.fd = true; }), 0U);
  EXPECT_EQ(wrong([](DriveOptions& o) { o.fd = true; }, old_options()), 1U);
  EXPECT_EQ(wrong([](DriveOptions& o) { o.torque_range_nm = 2.6; }), 1U);
  EXPECT_EQ(wrong([](DriveOptions& o) { o.torque_range_nm = 0.0; }), 1U);
  EXPECT_EQ(wrong([](DriveOptions& o) { o.velocity_range_rad_s = std::nan(""); }), 1U);
  EXPECT_EQ(wrong([](DriveOptions& o) { set(o, Key::kVelocityLimit, 50.0); }), 1U);
  EXPECT_EQ(wrong([](DriveOptions& o) { set(o, Key::kVelocityLimit, 136.0); }), 0U);
  EXPECT_EQ(wrong([](DriveOptions& o) { set(o, Key::kTorqueFeedback, 1.0); }, old_options()), 1U);
  EXPECT_EQ(wrong([](DriveOptions& o) { o.watchdog_ns = 0; }), 1U);
  EXPECT_EQ(wrong([](DriveOptions& o) { set_endpoint(o, Parameter::kEncoderRate, 7.0); }), 1U);
  EXPECT_EQ(wrong([](DriveOptions& o) { set_endpoint(o, Parameter::kEncoderRate, 201.0); },
                  endpoint_options()),
            1U);
  EXPECT_EQ(wrong([](DriveOptions& o) { set_endpoint(o, Parameter::kEnableWatchdog, 0.0); },
                  endpoint_options()),
            1U);
  EXPECT_EQ(wrong([](DriveOptions& o) { set(o, Key::kRevision, 0.0); }, endpoint_options()), 1U);
  EXPECT_EQ(
      wrong([](DriveOptions& o) { set_endpoint(o, Parameter::kEncoderRate, 7.0); }, old_options()),
      1U);
}

TEST(OdriveFamily, HasItsLine) {
  const Family own = family();
  const Family* line = &own;
  EXPECT_EQ(line->name, "odrive");
  EXPECT_LE(line->settings.size(), kMaxDriveSettings);
  EXPECT_EQ(line->settings.size(), static_cast<std::size_t>(Key::kFirstEndpoint) + kParameterCount);
  EXPECT_NEAR(line->position_period_rad(bench_options()), kTurn, 1e-12);
  EXPECT_EQ(line->make_scanner(true), nullptr);
  EXPECT_NE(line->make_zeroing(bench_options()), nullptr);
}

TEST(OdriveFamily, CountsTheFramesThatTheDriverSends) {
  for (const double feedback : {0.0, 1.0}) {
    for (const double torque : {0.0, 2.0}) {
      for (DriveOptions options : {bench_options(), old_options()}) {
        set(options, Key::kFeedback, feedback);
        set(options, Key::kTorqueFeedback, torque);
        double commands = 0.0;
        for (const CyclicFrame& frame : cyclic_frames(options, 1000.0)) {
          commands += frame.reply ? 0.0 : frame.share;
        }
        Bench bench(options);
        ASSERT_GT(bench.run_until(control::DriveCondition::kEnabled, enable()), 0);
        bench.sent.clear();
        bench.run(1000, enable(0.1));
        EXPECT_NEAR(static_cast<double>(bench.sent.size()) * 1e-3, commands, 0.002);
      }
    }
  }
}

struct Stage {
  /// Runs a dialogue against the drive. @return milliseconds until it was over; -1: never.
  int play(BenchDialogue& dialogue, Simulated& drive, int at_most = 20'000) {
    std::array<Frame, SimulatedDrive::kMaxReplies> said;
    for (int i = 0; i < at_most; ++i) {
      now_ns += 1'000'000;
      if (const auto frame = dialogue.transmit(now_ns)) {
        sent.push_back(*frame);
        const std::size_t count = drive.receive(*frame, now_ns, said);
        for (std::size_t k = 0; k < count; ++k) {
          dialogue.receive({said[k], now_ns + 200'000});
        }
      }
      const std::size_t count = drive.speak(now_ns + 300'000, said);
      for (std::size_t k = 0; k < count; ++k) {
        dialogue.receive({said[k], now_ns + 400'000});
      }
      if (dialogue.over()) {
        return i;
      }
    }
    return -1;
  }
  std::int64_t now_ns = 1'000'000'000;
  std::vector<Frame> sent;
};

TEST(OdriveScanner, FindsEitherFirmwareByAskingOnly) {
  for (const bool old : {false, true}) {
    Stage stage;
    const DriveOptions options = old ? old_options() : bench_options();
    Simulated drive(options);
    OdriveScanner scanner;
    EXPECT_GT(stage.play(scanner, drive), 0);
    ASSERT_EQ(scanner.found().size(), 1U);
    const FoundDrive found = scanner.found()[0];
    EXPECT_EQ(found.id, kNode);
    EXPECT_EQ(found.firmware.substr(0, 3), old ? "0.5" : "0.6");
    EXPECT_FALSE(found.remarks.empty());
    const auto option = std::find_if(found.options.begin(), found.options.end(),
                                     [](const auto& one) { return one.first == "firmware"; });
    ASSERT_NE(option, found.options.end());
    EXPECT_EQ(option->second, old ? "\"0.5\"" : "\"0.6\"");
    for (const Frame& frame : stage.sent) {
      EXPECT_TRUE(frame.remote);
    }
  }
}

TEST(OdriveScanner, OtherTrafficIsNoODrive) {
  OdriveScanner scanner;
  for (int i = 0; i < 1100; ++i) {
    const std::int64_t now_ns = 1'000'000 * (i + 1);
    scanner.transmit(now_ns);
    Frame frame;
    frame.id = 0x021;
    frame.length = 8;
    frame.data[4] = static_cast<std::uint8_t>(i);  // a state report of something else
    scanner.receive({frame, now_ns});
    frame.id = 0x041;
    frame.data[4] = 1;
    scanner.receive({frame, now_ns});  // as a heartbeat, but nobody answers
  }
  EXPECT_TRUE(scanner.over());
  EXPECT_TRUE(scanner.found().empty());
}

TEST(OdriveZeroing, SetsSavesAndReadsBack) {
  Stage stage;
  Simulated drive(bench_options());
  drive.set_shaft(0.3 * kTurn, 0.0);
  OdriveZeroing zeroing(bench_options());
  EXPECT_GT(stage.play(zeroing, drive), 0);
  EXPECT_TRUE(zeroing.done()) << zeroing.report();
  EXPECT_NEAR(zeroing.before_rad(), 0.3 * kTurn, 1e-3);
  EXPECT_NEAR(zeroing.after_rad(), 0.0, 1e-3);
  EXPECT_FALSE(zeroing.report().empty());
}

TEST(OdriveZeroing, RefusesWhatMovesErrsIsEnabledOrCannotKeepIt) {
  const auto refusal = [](auto prepare, const DriveOptions& options) {
    Stage stage;
    Simulated drive(options);
    prepare(drive);
    OdriveZeroing zeroing(options);
    stage.play(zeroing, drive);
    EXPECT_TRUE(zeroing.over());
    EXPECT_FALSE(zeroing.done());
    for (const Frame& frame : stage.sent) {
      EXPECT_TRUE(frame.remote);
    }
    return zeroing.report();
  };
  const DriveOptions options = bench_options();
  EXPECT_NE(refusal([](Simulated& drive) { drive.set_shaft(0.0, 1.0); }, options).find("moves"),
            std::string::npos);
  EXPECT_NE(refusal([](Simulated& drive) { drive.inject_error(kActiveBase + 13); }, options)
                .find("error"),
            std::string::npos);
  EXPECT_NE(refusal([](Simulated& drive) { drive.set_estimate_valid(false); }, options).find("NaN"),
            std::string::npos);
  const auto enable_it = [](Simulated& drive) {
    std::array<Frame, SimulatedDrive::kMaxReplies> said;
    drive.set_parameter(Parameter::kEnableWatchdog, 0.0);
    drive.receive(*encode(kNode, kSetAxisState, {kAxisClosedLoop}), 0, said);
  };
  EXPECT_NE(refusal(enable_it, options).find("not idle"), std::string::npos);
  EXPECT_NE(refusal([](Simulated&) {}, old_options()).find("0.5"), std::string::npos);
  EXPECT_NE(refusal([](Simulated& drive) { drive.set_parameter(Parameter::kHeartbeatRate, 0.0); },
                    options)
                .find("did not"),
            std::string::npos);
}

}  // namespace
}  // namespace geodesic::drivers::odrive::test
