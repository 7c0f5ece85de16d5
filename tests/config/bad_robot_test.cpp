// Every way a robot file can be wrong: each is refused, at its line and column, in these words.
#include "tests/config/bench.hpp"

namespace geodesic::config {
namespace {

struct Bad {
  const char* what;
  const char* from;
  const char* to;
  int line;
  int column;
  const char* fragment;
};

const Bad kBad[] = {
    // TOML and the reader
    {"broken syntax", "rate_hz = 1000", "rate_hz = ", 5, 11, "not valid TOML"},
    {"key twice", "tool_link = \"tip\"", "tool_link = \"tip\"\nname = \"x\"", 7, 8, "redefine"},
    {"unknown key", "rate_hz = 1000", "rate_hx = 1000", 5, 1,
     "unknown option \"rate_hx\" in [robot]; did you mean \"rate_hz\"? Allowed here: name, urdf"},
    {"unknown key far off", "rate_hz = 1000", "zzz = 1", 5, 1,
     "unknown option \"zzz\" in [robot]."},
    {"unknown table", "[simulation.pose]", "[simulator.pose]", 22, 2,
     "unknown option \"simulator\" at the top of the file; did you mean \"simulation\"?"},
    {"unknown in joint", "name = \"elbow\"", "name = \"elbow\"\ntorqe_limit = 3", 19, 1,
     "unknown option \"torqe_limit\" in [[joint]] \"elbow\"; did you mean \"torque_limit\"?"},
    {"unknown in drive", "id = 0x01", "idd = 0x01", 15, 30, "unknown option \"idd\" in drive of"},
    {"string for number", "rate_hz = 1000", "rate_hz = \"1000\"", 5, 11,
     "rate_hz: found the string \"1000\", expected a number [Hz], 50 to 4000; write 1000 without"},
    {"number for string", "name = \"two\"", "name = 2", 2, 8,
     "found the integer 2, expected a str"},
    {"empty string", "name = \"two\"", "name = \"\"", 2, 8, "expected a string that is not empty"},
    {"array for table", "[[bus]]\nname", "[bus]\nname", 8, 1, "[[bus]]"},
    {"float for integer", "id = 0x01", "id = 1.5", 15, 35, "found the number 1.5, expected an int"},
    {"flag", "interface = \"can0\"", "interface = \"can0\"\nfd = 1", 11, 6,
     "fd: found the integer 1, expected true or false"},
    {"nan", "rate_hz = 1000", "rate_hz = nan", 5, 11, "expected a finite number"},
    {"inf", "bus = \"arm\"", "bus = \"arm\"\ntorque_limit = inf", 15, 16, "leave the option out"},
    {"gravity short", "[0, -9.81, 0]", "[0, -9.81]", 4, 11, "three numbers [m/s²], -30 to 30 (it"},
    {"gravity words", "[0, -9.81, 0]", "[0, \"down\", 0]", 4, 15, "found the string \"down\""},
    {"rate low", "rate_hz = 1000", "rate_hz = 49", 5, 11,
     "found the integer 49, expected a number"},
    {"rate high", "rate_hz = 1000", "rate_hz = 4001", 5, 11, "50 to 4000"},
    {"law", "[simulation.pose]", "[control]\nlaw = \"flaot\"\n[simulation.pose]", 23, 7,
     "expected one of: float, hold, damp; did you mean \"float\"?"},
    {"missing name", "name = \"two\"\n", "", 1, 1, "[robot]: \"name\" is missing"},
    {"missing drive id", "id = 0x01, ", "", 15, 9, "\"id\" is missing"},
    {"missing drive", "drive = { family = \"damiao\", id = 0x01",
     "# = { family = \"damiao\", id = 1", 12, 1, "[[joint]] \"shoulder\": \"drive\" is missing"},
    // files
    {"no URDF", "two.urdf", "three.urdf", 3, 8, "there is no file"},
    // the robot
    {"tool link", "tool_link = \"tip\"", "tool_link = \"tap\"", 6, 13,
     "the URDF has no link \"tap\"; did you mean \"tip\"?"},
    {"lock unknown", "tool_link = \"tip\"", "lock = { elbw = 0.0 }", 6, 10,
     "the URDF has no joint \"elbw\"; did you mean \"elbow\"?"},
    {"lock fixed", "tool_link = \"tip\"", "lock = { tip_joint = 0.0 }", 6, 10, "is fixed already"},
    {"lock outside", "tool_link = \"tip\"", "lock = { elbow = 2.6 }", 6, 18,
     "2.6 for joint \"elbow\" is outside the URDF's limits, -2.5 to 2.5"},
    {"locked and driven", "tool_link = \"tip\"", "lock = { elbow = 0.6 }", 18, 8, "is locked"},
    // buses
    {"interface", "\"can0\"", "\"a/b\"", 10, 13, "expected the name of a network interface"},
    {"unix path", "\"can0\"", "\"unix:\"", 10, 13, "expected a path after unix:"},
    {"data rate without fd", "\"can0\"", "\"can0\"\ndata_bit_rate = 5_000_000", 11, 17,
     "fd = false"},
    {"usb path", "\"can0\"", "\"usb:1\"", 10, 13, "expected bus and ports after usb:"},
    {"serial", "\"can0\"", "\"serial:\"", 10, 13, "expected the adapter's serial number"},
    {"sample point", "\"can0\"", "\"can0\"\nsample_point = 80", 11, 16, "0.5 to 0.95"},
    {"data sample point without fd", "\"can0\"", "\"can0\"\ndata_sample_point = 0.8", 11, 21,
     "fd = false"},
    {"restart", "\"can0\"", "\"can0\"\nrestart_ms = -1", 11, 14, "0 to 10000"},
    {"queue", "\"can0\"", "\"can0\"\nqueue = 0", 11, 9, "1 to 4096"},
    {"data rate slow", "\"can0\"", "\"can0\"\nfd = true\ndata_bit_rate = 500_000", 12, 17,
     "500000 bit/s is slower than the nominal 1000000"},
    {"unused bus", "\"can0\"", "\"can0\"\n[[bus]]\nname = \"b\"\ninterface = \"can1\"", 11, 1,
     "no joint is on bus \"b\""},
    {"bus twice", "\"can0\"", "\"can0\"\n[[bus]]\nname = \"arm\"\ninterface = \"can1\"", 12, 8,
     "a second bus \"arm\"; the first is in line 9"},
    {"interface twice", "\"can0\"", "\"can0\"\n[[bus]]\nname = \"b\"\ninterface = \"can0\"", 13, 13,
     "are both on \"can0\""},
    {"unknown bus", "bus = \"arm\"", "bus = \"arn\"", 14, 7,
     "no bus \"arn\"; did you mean \"arm\"?"},
    {"rate the bus cannot carry", "rate_hz = 1000", "rate_hz = 2000", 5, 11,
     "2 drives, classic CAN 1 Mbit/s: 2 commands of 8 bytes * 135.0 us + 2 replies of 8 bytes * "
     "135.0 us = 540.0 us a cycle at worst (444.0 us without stuff bits), 108.0 % of the period of "
     "500.0 us; up to 95 % may be used: 1759 Hz at most"},
    {"deadline", "[simulation.pose]", "[realtime]\nreceive_deadline = 0.4\n[simulation.pose]", 23,
     20, "0.4 of a period is 400.0 us, but bus \"arm\" is busy for 444.0 us"},
    // joints
    {"joint unknown", "name = \"elbow\"", "name = \"elbo\"", 18, 8,
     "the URDF has no joint \"elbo\"; did you mean \"elbow\"? Its joints that move: elbow, "
     "shoulder"},
    {"joint without drive", "name = \"elbow\"", "name = \"elbo\"", 3, 8,
     "joint \"elbow\" (line 26 of the URDF) moves but has no [[joint]]"},
    {"joint fixed", "name = \"elbow\"", "name = \"tip_joint\"", 18, 8, "is fixed in the URDF"},
    {"joint twice", "name = \"elbow\"", "name = \"shoulder\"", 18, 8,
     "a second [[joint]] \"shoulder\"; the first is in line 12"},
    {"direction 0", "bus = \"arm\"", "bus = \"arm\"\ndirection = 0", 15, 13, "expected 1 or -1"},
    {"ratio 0", "bus = \"arm\"", "bus = \"arm\"\nratio = 0", 15, 9, "more than 0"},
    {"torque beyond the drive", "bus = \"arm\"", "bus = \"arm\"\nratio = 2\ntorque_limit = 28", 16,
     16, "torque_limit 28 N·m is more than the drive's 27 N·m (torque_range_nm 54 / ratio 2)"},
    {"velocity beyond the drive", "bus = \"arm\"", "bus = \"arm\"\nvelocity_limit = 46", 15, 18,
     "velocity_limit 46 rad/s is more than the drive's 45 rad/s (velocity_range_rad_s 45 * ratio "
     "1)"},
    {"position beyond the drive", "bus = \"arm\"", "bus = \"arm\"\nratio = 0.2", 12, 1,
     "position_lower -3.14 rad is outside what the drive can count, -2.5 to 2.5 rad"},
    {"position beyond by offset", "bus = \"arm\"", "bus = \"arm\"\noffset = 10.0", 12, 1,
     "position_lower -3.14 rad is outside what the drive can count, -2.5 to 22.5 rad"},
    {"position crossed", "bus = \"arm\"", "bus = \"arm\"\nposition_lower = 1\nposition_upper = 0.5",
     16, 18, "position_lower 1 is not below position_upper 0.5"},
    {"margin", "bus = \"arm\"", "bus = \"arm\"\nsoft_margin = 3.2", 15, 15,
     "leaves nothing of a travel"},
    {"temperatures", "bus = \"arm\"", "bus = \"arm\"\ntemperature_warn_c = 90", 15, 22,
     "temperature_warn_c 90 is above temperature_limit_c 85"},
    {"watchdog", "id = 0x01", "watchdog_ms = 2.5, id = 0x01", 15, 44,
     "watchdog_ms 2.5 is shorter than three periods, 3 * 1 ms = 3 ms"},
    {"pose outside", "elbow = -0.5", "elbow = -2.6", 23, 9, "outside its limits, -2.5 to 2.5"},
    {"pose unknown", "elbow = -0.5", "elbw = -0.5", 23, 1, "no [[joint]] \"elbw\"; did you mean"},
    // drives and identifiers
    {"family", "family = \"damiao\"", "family = \"damiaou\"", 15, 20,
     "found \"damiaou\", expected one of: damiao"},
    {"id twice", "id = 0x02", "id = 0x01", 20, 35,
     "id: 0x01 is the id of joint \"shoulder\" (line 12)"},
    {"reply twice", "reply_id = 0x12", "reply_id = 0x11", 20, 52,
     "drive: 0x11 that it answers on is one that the drive of joint"},
    {"reply is an id", "reply_id = 0x12", "reply_id = 0x01", 20, 52, "reply_id: 0x01 is the id of"},
    {"id is a reply", "id = 0x02", "id = 0x11", 20, 35, "id: 0x11 is the reply_id of"},
    {"reply is another mode's command", "reply_id = 0x12", "reply_id = 0x101", 20, 52, "0x101"},
    {"special id", "reply_id = 0x12", "reply_id = 0x7FF", 20, 35, "0x7FF"},
};

class BadRobot : public Bench, public ::testing::WithParamInterface<Bad> {};

TEST_P(BadRobot, IsRefusedWhereItStands) {
  const Bad& bad = GetParam();
  write("robot.toml", replaced(kRobotToml, bad.from, bad.to));
  const LoadResult result = load();
  EXPECT_FALSE(result.ok);
  EXPECT_TRUE(says(result.messages, "robot.toml", bad.line, bad.column, bad.fragment,
                   Message::Severity::kError))
      << "expected " << bad.line << ":" << bad.column << ": " << bad.fragment << "\nfound\n"
      << all_of(result.messages);
}

INSTANTIATE_TEST_SUITE_P(Table, BadRobot, ::testing::ValuesIn(kBad),
                         [](const auto& bad) { return test_name(bad.param.what); });

using RobotFiles = Bench;

TEST_F(RobotFiles, TheBaseIsValid) {
  const LoadResult result = load();
  EXPECT_TRUE(result.ok) << all_of(result.messages);
  EXPECT_TRUE(result.messages.empty()) << all_of(result.messages);
}

TEST_F(RobotFiles, AllFindingsAreReportedTogetherInOrder) {
  std::string text = replaced(kRobotToml, "rate_hz = 1000", "rate_hz = 9999");
  text = replaced(text, "name = \"elbow\"", "nam = \"elbow\"");
  text = replaced(text, "elbow = -0.5", "elbow = true");
  write("robot.toml", text);
  write("two.urdf", replaced(kTwoUrdf, "value=\"0.9\"", "value=\"heavy\""));
  const LoadResult result = load();
  EXPECT_FALSE(result.ok);
  ASSERT_EQ(result.messages.size(), 5U) << all_of(result.messages);
  EXPECT_EQ(result.messages[0].place.line, 5);
  EXPECT_EQ(result.messages[1].place.line, 17);
  EXPECT_EQ(result.messages[2].place.line, 18);
  EXPECT_EQ(result.messages[3].place.line, 23);
  EXPECT_EQ(result.messages[4].place.file.filename(), "two.urdf");
}

TEST_F(RobotFiles, AJointThatNoDriveCanMoveIsRefusedByNameAndKind) {
  for (const std::string kind : {"planar", "floating"}) {
    write("two.urdf", replaced(kTwoUrdf, "<joint name=\"elbow\" type=\"revolute\">",
                               "<joint name=\"elbow\" type=\"" + kind + "\">"));
    const LoadResult result = load();
    EXPECT_FALSE(result.ok);
    ASSERT_EQ(result.messages.size(), 1U) << all_of(result.messages);
    EXPECT_TRUE(says(result.messages, "two.urdf", 26, 3,
                     "joint \"elbow\" is " + kind + ": no drive can move it; expected revolute",
                     Message::Severity::kError))
        << all_of(result.messages);
  }
}

TEST_F(RobotFiles, MissingFileFolderAndEmptyFile) {
  LoadResult result = load_robot(folder() / "none.toml");
  EXPECT_FALSE(result.ok);
  EXPECT_NE(all_of(result.messages).find("there is no file"), std::string::npos);
  result = load_robot(folder());
  EXPECT_FALSE(result.ok);
  EXPECT_NE(all_of(result.messages).find("is a folder"), std::string::npos);
  write("robot.toml", "");
  result = load();
  EXPECT_FALSE(result.ok);
  EXPECT_TRUE(
      says(result.messages, "robot.toml", 1, 1, "\"robot\" is missing", Message::Severity::kError));
  EXPECT_TRUE(
      says(result.messages, "robot.toml", 1, 1, "\"joint\" is missing", Message::Severity::kError));
}

TEST_F(RobotFiles, TooManyBusesAndJoints) {
  std::string text(kRobotToml);
  for (int i = 0; i < 8; ++i) {
    text += "[[bus]]\nname = \"b" + std::to_string(i) + "\"\ninterface = \"vcan" +
            std::to_string(i) + "\"\n";
  }
  for (int i = 0; i < 31; ++i) text += "[[joint]]\nname = \"j" + std::to_string(i) + "\"\n";
  write("robot.toml", text);
  const std::string found = all_of(load().messages);
  EXPECT_NE(found.find("9 buses, expected at most 8"), std::string::npos) << found;
  EXPECT_NE(found.find("33 joints, expected at most 32"), std::string::npos) << found;
}

}  // namespace
}  // namespace geodesic::config
