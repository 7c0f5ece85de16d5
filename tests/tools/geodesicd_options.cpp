// geodesicd's command line, and what it may change of a robot.
#include "tools/geodesicd/options.hpp"

#include <gtest/gtest.h>

#include "tests/tools/geodesicd_fixture.hpp"

namespace geodesic::tools {
namespace {

ParseResult parse(std::vector<const char*> arguments) {
  arguments.insert(arguments.begin(), "geodesicd");
  return parse_command_line(static_cast<int>(arguments.size()), arguments.data());
}

TEST(CommandLine, TakesOneBusAFlag) {
  const ParseResult parsed =
      parse({"--bus", "vcan0", "--bus", "unix:/tmp/b", "robot.toml", "--seconds", "2.5"});
  ASSERT_TRUE(parsed.options);
  EXPECT_EQ(parsed.options->buses, (std::vector<std::string>{"vcan0", "unix:/tmp/b"}));
  EXPECT_EQ(parsed.options->robot, "robot.toml");
  EXPECT_DOUBLE_EQ(parsed.options->seconds, 2.5);
  EXPECT_EQ(parsed.options->log_level, Severity::kInfo);
}

TEST(CommandLine, RefusesNonsenseAsUsage) {
  for (const std::vector<const char*>& wrong : {std::vector<const char*>{},
                                                {"robot.toml", "--seconds", "-1"},
                                                {"robot.toml", "--lwa", "x"},
                                                {"robot.toml", "--law", "flaot"},
                                                {"robot.toml", "--log-level", "loud"},
                                                {"robot.toml", "another.toml"}}) {
    const ParseResult parsed = parse(wrong);
    EXPECT_FALSE(parsed.options);
    EXPECT_EQ(parsed.code, ExitCode::kUsage);
  }
}

TEST(CommandLine, HelpAndVersionAreNoErrors) {
  testing::internal::CaptureStdout();
  EXPECT_EQ(parse({"--help"}).code, ExitCode::kClean);
  const std::string help = testing::internal::GetCapturedStdout();
  for (const char* part : {"--summary", "--simulated-time", "Exit codes", "Examples", "--bus"}) {
    EXPECT_NE(help.find(part), std::string::npos) << part;
  }
  testing::internal::CaptureStdout();
  EXPECT_EQ(parse({"--version"}).code, ExitCode::kClean);
  EXPECT_NE(testing::internal::GetCapturedStdout().find(GEODESIC_VERSION), std::string::npos);
}

TEST(VirtualBus, IsWhatNoRealArmCanBeBehind) {
  EXPECT_TRUE(is_virtual_bus("vcan0"));
  EXPECT_TRUE(is_virtual_bus("vxcan12"));
  EXPECT_TRUE(is_virtual_bus("unix:/tmp/arm.bus"));
  EXPECT_FALSE(is_virtual_bus("can0"));
  EXPECT_FALSE(is_virtual_bus("slcan0"));
  EXPECT_FALSE(is_virtual_bus(""));
}

TEST(Apply, KeepsWhatIsForSimulationAwayFromRealBuses) {
  CommandLine line;
  line.allow_zero_law = true;
  config::Robot robot = small_robot();
  EXPECT_FALSE(apply(line, robot));
  EXPECT_TRUE(robot.controller.allow_zero_law);
  robot.arm.buses[0].interface = "can0";
  ASSERT_TRUE(apply(line, robot));
  EXPECT_NE(apply(line, robot)->find("can0"), std::string::npos);
  line = {};
  EXPECT_FALSE(apply(line, robot));
  line.simulated_time = true;
  EXPECT_TRUE(apply(line, robot));
}

TEST(Apply, PutsTheCommandLineOverTheFile) {
  CommandLine line;
  line.law = "hold";
  line.no_start = true;
  config::Robot robot = small_robot();
  EXPECT_FALSE(apply(line, robot));
  EXPECT_EQ(robot.controller.law, control::LawKind::kHold);
  EXPECT_FALSE(robot.controller.start_active);
  line.law = "zero";
  EXPECT_TRUE(apply(line, robot)) << "needs --allow-zero-law";
  line.allow_zero_law = true;
  EXPECT_FALSE(apply(line, robot));
}

}  // namespace
}  // namespace geodesic::tools
