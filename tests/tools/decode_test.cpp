// `geodesic decode` as people call it: with a robot file, with a drive named on the command line,
// live, and with lines that are no frames.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/tools/simulated_bench.hpp"
#include "tools/geodesic/error_frame_words.hpp"
#include "tools/geodesic/frame_meaning.hpp"

namespace geodesic::tools::test {
namespace {

TEST(Decode, SaysWhatFramesMeanLive) {
  const TemporaryFolder folder;
  const std::string robot = bench_robot(folder, "can0");
  Program decode(folder, {"decode", robot});
  decode.say("(1.5) can0 002#FFFFFFFFFFFFFFFC\n");
  for (int i = 0; i < 200 && decode.out().empty(); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  EXPECT_EQ(decode.out(), "(1.5) can0 002 joint2: enable\n");
  decode.say("(1.6) can0 002#R\n(1.7) can0 20000064#0008000000000000\n(1.8) can0 zzz#00\n");
  decode.end_input();
  EXPECT_EQ(decode.wait(), 1);
  EXPECT_NE(decode.out().find("-: remote request"), std::string::npos) << decode.out();
  EXPECT_NE(decode.out().find("bus error frame"), std::string::npos);
  EXPECT_NE(decode.err().find("standard input:4: error:"), std::string::npos) << decode.err();
}

TEST(Decode, NeedsNoRobotFileForOneDrive) {
  const TemporaryFolder folder;
  std::ofstream(folder / "log") << "(1.0) can0 011#117FFF7FF7FF191A\n(1.1) can0 012#00\n";
  const std::string log = (folder / "log").string();
  std::vector<std::string> words{"decode",
                                 "--family",
                                 "damiao",
                                 "--id",
                                 "1",
                                 "--reply-id",
                                 "0x11",
                                 "--set",
                                 "position_range_rad=12.5",
                                 "--set",
                                 "velocity_range_rad_s=30",
                                 "--set",
                                 "torque_range_nm=10",
                                 "--json"};
  words.push_back(log);
  Program decode(folder, words);
  ASSERT_EQ(decode.wait(), 0) << decode.err();
  const auto first = nlohmann::json::parse(decode.out().substr(0, decode.out().find('\n')));
  EXPECT_EQ(first["joint"], "0x1");
  EXPECT_EQ(first["kind"], "state");
  EXPECT_NE(decode.out().find("\"unknown\""), std::string::npos);

  const auto refused = [&](std::vector<std::string> call, const char* text) {
    call.insert(call.begin(), "decode");
    Program program(folder, call);
    EXPECT_EQ(program.wait(), 1);
    EXPECT_NE(program.err().find(text), std::string::npos) << program.err();
  };
  refused({log, "--family", "damia", "--id", "1"}, "did you mean \"damiao\"?");
  refused({log, "--family", "damiao", "--id", "1"}, "--set");
  refused({log, "--family", "damiao", "--id", "1", "--set", "torque=3"}, "has no \"torque\"");
  refused({log, "--family", "damiao", "--id", "1", "--set", "torque"}, "expected KEY=VALUE");
  refused({}, "whose frames are they?");
}

TEST(Decode, ByFamilyAlsoWhereItSpeaksOnCanFdOnly) {
  const TemporaryFolder folder;
  // tests/data/vectors/moteus.csv: registers as int16, feed-forward torque 2.7161 in steps of 0.01.
  std::ofstream(folder / "log")
      << "(1.0) can0 00008003##1"
         "01000A040620008000000F0100000000900105273200052B000011001F01130D"
         "\n";
  Program decode(folder, {"decode", "--family", "moteus", "--id", "3", (folder / "log").string()});
  ASSERT_EQ(decode.wait(), 0) << decode.err();
  EXPECT_NE(decode.out().find("feed-forward torque 2.71 N·m"), std::string::npos) << decode.out();
}

TEST(Decode, PutsErrorFramesIntoWords) {
  drivers::Frame frame;
  frame.error = true;
  const auto words = [&frame] {
    std::string text;
    for (const auto& field : error_frame_words(frame))
      text += field.name + " " + field.value + "; ";
    return text;
  };
  frame.id = 0x64;  // controller, acknowledgement, bus-off
  frame.data[1] = 0x20;
  EXPECT_EQ(words(),
            "controller error-passive by sending; acknowledgement none: nobody else on the bus "
            "takes frames; bus-off the controller has left the bus; ");
  frame.id = 0x208;
  frame.data[2] = 0x84;
  frame.data[6] = 128;
  EXPECT_EQ(words(),
            "protocol bit stuffing is wrong (bit rate?), while sending; errors sending 128; errors "
            "receiving 0; ");
  frame.id = 0x1000;
  EXPECT_EQ(words(), "class 0x1000; ");
}

TEST(Decode, NamesEveryJointThatAFrameSpeaksTo) {
  config::Robot robot;
  robot.arm.buses.emplace_back();
  for (std::uint32_t i = 1; i <= 2; ++i) {
    drivers::JointOptions joint;
    joint.name = "joint" + std::to_string(i);
    joint.drive = damiao(i);
    joint.drive.reply_id = 0x11;  // as it must not be
    robot.arm.joints.push_back(joint);
  }
  CandumpLine line;
  line.frame.id = 0x11;
  line.frame.length = 8;
  line.frame.data = {0x01};
  EXPECT_EQ(meaning_of(line, robot).joint, "joint1");
  robot.arm.joints[1].drive.id = 0x21;  // the same low bits: the frame is both's
  EXPECT_EQ(meaning_of(line, robot).joint, "joint1, joint2");
  robot.arm.joints[1].drive.torque_range_nm = 5.0;
  const FrameMeaning two = meaning_of(line, robot);
  EXPECT_EQ(two.joint, "joint1");
  EXPECT_EQ(two.fields.back().name, "also read as");
  EXPECT_EQ(two.fields.back().value, "state of joint2");
}

}  // namespace
}  // namespace geodesic::tools::test
