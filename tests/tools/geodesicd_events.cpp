// What the log says of events, and in which shape its lines leave.
#include <gtest/gtest.h>
#include <spdlog/sinks/ostream_sink.h>

#include <limits>
#include <sstream>

#include "tests/tools/geodesicd_fixture.hpp"
#include "tools/geodesicd/event_text.hpp"

namespace geodesic::tools {
namespace {

constexpr std::int64_t kStartNs = 5'000'000'000;

class EventTextTest : public testing::Test {
 protected:
  EventText of(control::Fault fault, int joint, int bus, double found, double limit) {
    event_.tick_ns = kStartNs + 1'234'000'000;
    event_.fault = {.time_ns = event_.tick_ns,
                    .fault = fault,
                    .action = control::policy(fault).action,
                    .joint = joint,
                    .bus = bus,
                    .found = found,
                    .limit = limit,
                    .suspicion = {}};
    return describe(event_, words_, kStartNs);
  }
  static void expect_contains(const std::string& text, std::initializer_list<const char*> parts) {
    for (const char* part : parts) {
      EXPECT_NE(text.find(part), std::string::npos) << "no '" << part << "' in: " << text;
    }
  }

  config::Robot robot_ = small_robot();
  Vocabulary words_{robot_};
  Event event_;
};

TEST_F(EventTextTest, ASilentJointHasItsBusAndItsLastFrame) {
  event_.frame_age_ns = 5'200'000;
  event_.last_frame.id = 0x11;
  event_.last_frame.length = 2;
  event_.last_frame.data = {0xAB, 0x01};
  robot_.arm.joints[0].drive.family = "damiao";
  robot_.arm.joints[0].drive.id = 0x1F;
  const EventText text = of(control::Fault::kJointSilent, 0, -1, 5, 5);
  expect_contains(text.text,
                  {"joint_silent at swing, bus arm (vcan0), damiao id 0x1F", "found 5, limit 5",
                   "cycles in a row", "last good frame 5.2 ms ago: 011#AB01", "controlled stop",
                   "t = 1.234 s"});
  EXPECT_EQ(text.severity, Severity::kError);
  EXPECT_EQ(text.fields.at("joint"), "swing");
  EXPECT_EQ(text.fields.at("bus"), "vcan0");
  EXPECT_EQ(text.fields.at("drive_id"), 0x1F);
  EXPECT_EQ(text.fields.at("last_frame"), "011#AB01");
  EXPECT_EQ(text.fields.at("class"), "controlled_stop");
}

TEST_F(EventTextTest, UnitsFollowTheJoint) {
  expect_contains(of(control::Fault::kPositionLimit, 0, -1, 1.62, 1.57).text,
                  {"found 1.62, limit 1.57 rad"});
  expect_contains(of(control::Fault::kPositionLimit, 1, -1, 0.62, 0.57).text,
                  {"found 0.62, limit 0.57 m;"});
  expect_contains(of(control::Fault::kVelocityLimit, 1, -1, 2, 1).text, {"limit 1 m/s"});
  expect_contains(of(control::Fault::kTorqueSaturated, 0, -1, 20, 18).text, {"limit 18 N·m"});
  const EventText warm = of(control::Fault::kTemperatureWarn, 0, -1, 71, 70);
  expect_contains(warm.text, {"°C", "carrying on"});
  EXPECT_EQ(warm.severity, Severity::kWarning);
}

TEST_F(EventTextTest, ADriveErrorIsInTheWordsOfItsFamily) {
  event_.drive_error = 0x8;
  const EventText text = of(control::Fault::kDriveError, 1, -1, 8, 0);
  expect_contains(text.text, {"drive_error at slide", "the drive reports: ", "(0x8)"});
  EXPECT_EQ(text.text.find("unknown"), std::string::npos) << text.text;
  EXPECT_TRUE(text.fields.contains("drive_error"));
}

TEST_F(EventTextTest, ARefusedDriveHasItsComplaintAndTheFix) {
  event_.complaint = {"PMAX (register 21) [rad]", 3.14, 12.5, "write the drive's figure"};
  const EventText text = of(control::Fault::kDriveRefused, 0, -1, 0, 0);
  expect_contains(text.text,
                  {"PMAX (register 21) [rad]: the drive has 3.14, the configuration expects 12.5",
                   "write the drive's figure", "no frame from it yet", "torque off"});
}

TEST_F(EventTextTest, ABusFaultNamesTheBus) {
  const EventText text = of(control::Fault::kBusDown, control::kNoJoint, 0, 0, 0);
  expect_contains(text.text, {"bus_down at bus arm (vcan0)"});
  EXPECT_FALSE(text.fields.contains("joint"));
}

TEST_F(EventTextTest, EveryFaultOfTheTableCanBeTold) {
  for (std::size_t i = 0; i < static_cast<std::size_t>(control::Fault::kCount); ++i) {
    const auto fault = static_cast<control::Fault>(i);
    expect_contains(of(fault, 0, -1, 1, 2).text, {control::policy(fault).name});
    expect_contains(of(fault, control::kNoJoint, -1, 1, 2).text, {control::policy(fault).meaning});
  }
}

TEST_F(EventTextTest, StatesAndRefusals) {
  event_.kind = Event::Kind::kState;
  event_.tick_ns = kStartNs + 2'000'000'000;
  event_.from = control::SupervisorState::kEnabling;
  event_.to = control::SupervisorState::kActive;
  EXPECT_EQ(describe(event_, words_, kStartNs).text, "enabling -> active(float) [t = 2.000 s]");
  event_.to = control::SupervisorState::kFault;
  EXPECT_EQ(describe(event_, words_, kStartNs).severity, Severity::kError);
  event_.kind = Event::Kind::kRefusal;
  event_.refusal = "the arm is stopping";
  expect_contains(describe(event_, words_, kStartNs).text, {"not followed: the arm is stopping"});
}

TEST(BusText, SaysWhatIsWrong) {
  control::BusState bus;
  EXPECT_EQ(describe(bus), "ok");
  bus.down = bus.stalled = true;
  EXPECT_EQ(describe(bus), "down, stalled");
}

std::string logged(const LogOptions& options, Severity severity, const std::string& text,
                   const nlohmann::ordered_json& fields = {}) {
  std::ostringstream out;
  Log log(options, std::make_shared<spdlog::sinks::ostream_sink_mt>(out));
  log.write(severity, text, fields);
  return out.str();
}

TEST(Log, CarriesPrioritiesToTheJournalAndNothingElse) {
  LogOptions journal;
  journal.journal = true;
  EXPECT_EQ(logged(journal, Severity::kWarning, "warm"), "<4>warm\n");
  EXPECT_EQ(logged(journal, Severity::kCritical, "stuck"), "<2>stuck\n");
  EXPECT_EQ(logged(journal, Severity::kDebug, "detail"), "") << "below the level";
}

TEST(Log, IsReadableElsewhere) {
  const std::string line = logged({}, Severity::kError, "fault");
  EXPECT_NE(line.find(" error fault\n"), std::string::npos) << line;
  EXPECT_EQ(line.find('\x1b'), std::string::npos) << line;
}

TEST(Log, WritesJsonThatParsesWhateverTheText) {
  LogOptions json;
  json.json = true;
  const std::string line =
      logged(json, Severity::kError, "a \"quoted\"\nline \xff",
             {{"found", std::numeric_limits<double>::infinity()}, {"joint", "swing"}});
  EXPECT_EQ(line.find('\n'), line.size() - 1);
  const auto parsed = nlohmann::json::parse(line);
  EXPECT_EQ(parsed.at("level"), "error");
  EXPECT_EQ(parsed.at("joint"), "swing");
  EXPECT_TRUE(parsed.at("time").is_number());
}

}  // namespace
}  // namespace geodesic::tools
