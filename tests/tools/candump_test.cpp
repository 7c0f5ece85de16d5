// candump's lines, and what they mean to a robot.
#include "tools/geodesic/candump.hpp"

#include <gtest/gtest.h>

#include "tests/tools/sim_robot.hpp"
#include "tools/geodesic/frame_meaning.hpp"

namespace geodesic::tools {
namespace {

CandumpLine good(std::string_view text) {
  std::string why;
  const auto line = parse_candump(text, why);
  EXPECT_TRUE(line.has_value()) << text << ": " << why;
  return line.value_or(CandumpLine());
}

TEST(Candump, CompactLines) {
  const CandumpLine classic = good("(1436509052.249713) vcan0 044#2A366C2B0000");
  EXPECT_EQ(classic.time, "1436509052.249713");
  EXPECT_EQ(classic.interface, "vcan0");
  EXPECT_EQ(classic.frame.id, 0x44U);
  EXPECT_FALSE(classic.frame.extended);
  EXPECT_EQ(classic.frame.length, 6);
  EXPECT_EQ(classic.frame.data[1], 0x36);

  const CandumpLine fd = good("(0.1) can1 12345678##1000102030405060708090A0B");
  EXPECT_TRUE(fd.frame.extended);
  EXPECT_TRUE(fd.frame.fd);
  EXPECT_TRUE(fd.frame.bit_rate_switch);
  EXPECT_EQ(fd.frame.length, 12);
  EXPECT_FALSE(good("can0 001##0AA").frame.bit_rate_switch);

  EXPECT_TRUE(good("(0.1) can0 123#R").frame.remote);
  EXPECT_EQ(good("(0.1) can0 123#R8").frame.length, 8);
  EXPECT_TRUE(good("  can0  123   [4]  remote request").frame.remote);
  EXPECT_EQ(good("  can0  123   [4]  remote request").frame.length, 4);
  EXPECT_TRUE(good("(0.1) can0 20000040#0000000000000000").frame.error);
  EXPECT_EQ(good("(0.1) can0 7FF#").frame.length, 0);
  EXPECT_EQ(good("(1.5) can0 001#11.22.33 R").frame.length, 3);
}

TEST(Candump, SpacedLines) {
  const CandumpLine plain = good("  vcan0  011   [8]  01 7F FF 7F F7 FF 19 1A");
  EXPECT_EQ(plain.frame.id, 0x11U);
  EXPECT_EQ(plain.frame.length, 8);
  EXPECT_EQ(plain.frame.data[7], 0x1A);
  EXPECT_EQ(good(" (001.25)  can0  TX - -  001   [2]  AA BB   '..'").frame.data[1], 0xBB);
  EXPECT_TRUE(good(" can0  001  [08]  01 02 03 04 05 06 07 08").frame.fd);
  EXPECT_EQ(good(" (2026-11-22 14:00:00.1) can0 001 [0]").time, "2026-11-22 14:00:00.1");
}

TEST(Candump, NothingToSayOfBlanksAndComments) {
  std::string why = "x";
  EXPECT_FALSE(parse_candump("", why).has_value());
  EXPECT_TRUE(why.empty());
  EXPECT_FALSE(parse_candump("# a comment", why).has_value());
  EXPECT_TRUE(why.empty());
}

TEST(Candump, SaysWhatIsWrong) {
  for (const char* text :
       {"hello", "(1.0) can0", "(1.0 can0 001#11", "(1.0) can0 01#11", "(1.0) can0 8FF#11",
        "(1.0) can0 001#1", "(1.0) can0 001#GG", "(1.0) can0 001#112233445566778899",
        "(1.0) can0 001##", "(1.0) can0 001##1112233445566778899", "can0 001 [3] 11 22",
        "can0 001 [x] 11"}) {
    std::string why;
    EXPECT_FALSE(parse_candump(text, why).has_value()) << text;
    EXPECT_FALSE(why.empty()) << text;
  }
}

TEST(Candump, MeaningByJointAndBus) {
  config::Robot robot = test::chain(2);
  robot.arm.buses[0].interface = "can0";
  const CandumpLine enable = good("(1.0) can0 002#FFFFFFFFFFFFFFFC");
  EXPECT_EQ(meaning_of(enable, robot).joint, "joint2");
  // One bus: the log may name it otherwise.
  EXPECT_EQ(meaning_of(good("(1.0) vcan7 002#FFFFFFFFFFFFFFFC"), robot).joint, "joint2");
  const FrameMeaning state = meaning_of(good("(1.0) can0 011#117FFF7FF7FF191A"), robot);
  EXPECT_EQ(state.joint, "joint1");
  EXPECT_FALSE(state.fields.empty());
  EXPECT_EQ(meaning_of(good("(1.0) can0 555#00"), robot).kind, "unknown");
  EXPECT_EQ(meaning_of(good("(1.0) can0 20000040#0000000000000000"), robot).kind,
            "bus error frame");

  robot.arm.buses.push_back(robot.arm.buses[0]);
  robot.arm.buses[1].interface = "can1";
  robot.arm.joints[1].bus = 1;
  EXPECT_EQ(meaning_of(good("(1.0) can1 002#FFFFFFFFFFFFFFFC"), robot).joint, "joint2");
  EXPECT_EQ(meaning_of(enable, robot).joint, "");
  EXPECT_NE(meaning_of(good("(1.0) can9 002#11"), robot).kind.find("can9"), std::string::npos);
}

}  // namespace
}  // namespace geodesic::tools
