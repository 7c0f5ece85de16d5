// Every option's change is found, by its path alone, and says whether a running daemon takes it; a
// tuned value is checked like a written one.
#include "config/difference.hpp"

#include <fmt/format.h>

#include "config/options/options.hpp"
#include "config/options/toml_reader.hpp"
#include "config/settings.hpp"
#include "config/setup.hpp"
#include "control/mechanism/dynamics.hpp"
#include "tests/config/bench.hpp"

namespace geodesic::config {
namespace {

std::string lines(const std::vector<Change>& changes) {
  std::string text;
  for (const Change& change : changes) text += to_string(change) + "\n";
  return text;
}

class Difference : public Bench {
 public:
  /// The robot with a line added to its shoulder, or with anything else replaced.
  LoadResult with(std::string_view from, std::string_view to) {
    write("robot.toml", replaced(kRobotToml, from, to));
    return load();
  }
  LoadResult tuned(std::vector<Override> overrides) const {
    LoadOptions options;
    options.overrides = std::move(overrides);
    return load(options);
  }
};

TEST_F(Difference, NoneBetweenEqualRobots) {
  EXPECT_EQ(lines(difference(load().robot, load().robot)), "");
}

TEST_F(Difference, NamesOptionOldNewAndUnit) {
  const Robot before = load().robot;
  const Robot after = with("name = \"elbow\"", "name = \"elbow\"\nhold_stiffness = 30").robot;
  EXPECT_EQ(lines(difference(before, after)), "joint.elbow.hold_stiffness: 0 -> 30 N·m/rad\n");
  EXPECT_EQ(difference(before, after).front().place.line, 19);
  EXPECT_EQ(difference(before, after).front().live, Live::kYes);
}

TEST_F(Difference, DefaultsThatAreNoConstantAreNamed) {
  const Robot before = load().robot;
  const Robot after = with("name = \"elbow\"", "name = \"elbow\"\nposition_upper = 2").robot;
  EXPECT_EQ(lines(difference(before, after)),
            "joint.elbow.position_upper: (the URDF's) -> 2 rad\n");
}

TEST_F(Difference, DefaultsOfAllJointsShowAtEachJoint) {
  const Robot before = load().robot;
  const Robot after =
      with("[simulation.pose]", "[defaults.joint]\ndamping = 0.5\n[simulation.pose]").robot;
  EXPECT_EQ(
      lines(difference(before, after)),
      "joint.shoulder.damping: 0 -> 0.5 N·m·s/rad\njoint.elbow.damping: 0 -> 0.5 N·m·s/rad\n");
}

TEST_F(Difference, RateNeedsARestart) {
  const Robot before = load().robot;
  const std::vector<Change> changes =
      difference(before, with("rate_hz = 1000", "rate_hz = 500").robot);
  ASSERT_EQ(lines(changes), "robot.rate_hz: 1000 -> 500 Hz\n");
  EXPECT_EQ(changes.front().live, Live::kNo);
}

TEST_F(Difference, LinksMassIsLiveItsGeometryIsNot) {
  const Robot before = load().robot;
  write("two.urdf", replaced(kTwoUrdf, "<mass value=\"1.3\"/>", "<mass value=\"1.5\"/>"));
  const std::vector<Change> mass = difference(before, load().robot);
  ASSERT_EQ(lines(mass), "urdf.link.upper.mass: 1.3 -> 1.5 kg\n");
  EXPECT_EQ(mass.front().live, Live::kYes);
  write("two.urdf", replaced(kTwoUrdf, "<origin xyz=\"0.5 0 0\"", "<origin xyz=\"0.6 0 0\""));
  const std::vector<Change> origin = difference(before, load().robot);
  ASSERT_EQ(origin.size(), 1U) << lines(origin);
  EXPECT_EQ(origin.front().path, "urdf.joint.elbow.origin");
  EXPECT_EQ(origin.front().live, Live::kNo);
}

TEST_F(Difference, AJointMoreIsOneChange) {
  const Robot small = load().robot;
  write("robot.toml", replaced(kRobotToml, "tool_link = \"tip\"", "lock = { elbow = 0.0 }"));
  std::string text(kRobotToml);
  text = replaced(text, "tool_link = \"tip\"\n", "tool_link = \"tip\"\nlock = { elbow = 0.0 }\n");
  const std::size_t at = text.rfind("[[joint]]");
  text.erase(at, text.find("[simulation.pose]") - at);
  text = replaced(text, "elbow = -0.5", "shoulder = -0.5");
  write("robot.toml", text);
  const LoadResult locked = load();
  ASSERT_TRUE(locked.ok) << all_of(locked.messages);
  const std::string said = lines(difference(small, locked.robot));
  EXPECT_NE(said.find("joint.elbow: there -> -\n"), std::string::npos) << said;
  EXPECT_EQ(said.find("joint.elbow.damping"), std::string::npos) << said;
}

/// A value of the same kind that differs and is allowed where one can be made up; else nothing.
std::optional<std::string> another(const Setting& setting) {
  const std::string& value = setting.value;
  if (setting.element) return std::nullopt;
  if (value == "true" || value == "false") return value == "true" ? "false" : "true";
  if (value.starts_with('[') && setting.live == Live::kYes) return "[0, 0, 0.001]";
  if (value.starts_with('[')) return "[0]";
  if (value.starts_with('{') || value.starts_with('"')) return std::nullopt;
  if (value.empty()) {
    const std::string& option = setting.steps.back();
    if (option.ends_with("sample_point")) return std::nullopt;
    return option == "data_bit_rate" ? std::nullopt : std::optional<std::string>("1.25");
  }
  const double number = std::stod(value);
  const bool whole = value.find_first_of(".e") == std::string::npos;
  return fmt::format("{}", whole ? number + 1.0 : number * 0.97);
}

// What a running daemon takes must reach nothing but the controller's options, the model and the
// payloads: all else was fixed when it started.
TEST_F(Difference, EveryOptionIsFoundAndLiveOnesTouchOnlyWhatCanMoveOver) {
  write("robot.toml",
        std::string(kRobotToml) +
            "[[payload]]\nname = \"box\"\nmass = 0.5\ninertia = [0.01, 0.01, 0.01]\n");
  const LoadResult before = load();
  ASSERT_TRUE(before.ok) << all_of(before.messages);
  int live = 0;
  int changed = 0;
  for (const Setting& setting : before.robot.settings) {
    EXPECT_NE(setting.live, Live::kUnsaid) << setting.path;
    const std::optional<std::string> value = another(setting);
    if (!value) continue;
    const LoadResult after = tuned({{setting.path, *value}});
    if (!after.ok) continue;  // most numbers will do; some clash with others
    ++changed;
    const std::vector<Change> changes = difference(before.robot, after.robot);
    ASSERT_EQ(changes.size(), 1U) << setting.path << "=" << *value << "\n" << lines(changes);
    EXPECT_EQ(changes.front().path, setting.path);
    EXPECT_EQ(changes.front().live, setting.live);
    if (setting.live != Live::kYes) continue;
    ++live;
    EXPECT_EQ(after.robot.period_ns, before.robot.period_ns) << setting.path;
    EXPECT_EQ(after.robot.realtime.receive_deadline, before.robot.realtime.receive_deadline);
    EXPECT_EQ(after.robot.controller.law, before.robot.controller.law) << setting.path;
    for (std::size_t i = 0; i < before.robot.arm.joints.size(); ++i) {
      const drivers::JointOptions& a = before.robot.arm.joints[i];
      const drivers::JointOptions& b = after.robot.arm.joints[i];
      EXPECT_TRUE(a.offset == b.offset && a.ratio == b.ratio && a.direction == b.direction &&
                  a.drive.watchdog_ns == b.drive.watchdog_ns && a.drive.id == b.drive.id &&
                  a.drive.torque_range_nm == b.drive.torque_range_nm)
          << setting.path;
    }
  }
  EXPECT_GT(live, 50);
  EXPECT_GT(changed, 80);
}

TEST_F(Difference, TunedValuesAreCheckedAsWrittenOnes) {
  const LoadResult wrong = tuned({{"joint.elbow.damping", "-1"}, {"safety.lower_s", "\"slow\""}});
  EXPECT_FALSE(wrong.ok);
  const std::string said = all_of(wrong.messages);
  EXPECT_NE(said.find("joint.elbow.damping=-1: error: damping: found the integer -1"),
            std::string::npos)
      << said;
  EXPECT_NE(said.find("safety.lower_s=\"slow\": error: lower_s: found the string"),
            std::string::npos)
      << said;
  const LoadResult clash = tuned({{"joint.elbow.position_upper", "-2.6"}});
  EXPECT_FALSE(clash.ok);
  EXPECT_NE(all_of(clash.messages).find("joint.elbow.position_upper=-2.6: error"),
            std::string::npos)
      << all_of(clash.messages);
}

TEST_F(Difference, UnknownPathsGetTheNearest) {
  const LoadResult wrong = tuned({{"joint.elbow.dampnig", "1"}});
  EXPECT_FALSE(wrong.ok);
  EXPECT_NE(all_of(wrong.messages).find("did you mean \"joint.elbow.damping\"?"), std::string::npos)
      << all_of(wrong.messages);
  EXPECT_FALSE(tuned({{"joint.elbow", "1"}}).ok);
  EXPECT_FALSE(tuned({{"", "1"}}).ok);
}

TEST_F(Difference, ATunedValueIsTheWrittenOneToTheBit) {
  const LoadResult asked = tuned({{"joint.elbow.damping", "0.1234567890123456789"},
                                  {"safety.lower_s", "1.5"},
                                  {"robot.gravity", "[0.1, -9.8, 1e-3]"}});
  ASSERT_TRUE(asked.ok) << all_of(asked.messages);
  std::string text =
      replaced(kRobotToml, "name = \"elbow\"", "name = \"elbow\"\ndamping = 0.1234567890123456789");
  text = replaced(text, "gravity = [0, -9.81, 0]", "gravity = [0.1, -9.8, 1e-3]");
  write("robot.toml", text + "[safety]\nlower_s = 1.5\n");
  const LoadResult written = load();
  ASSERT_TRUE(written.ok) << all_of(written.messages);
  EXPECT_EQ(lines(difference(asked.robot, written.robot)), "");
  EXPECT_EQ(asked.robot.controller.joints[1].damping, written.robot.controller.joints[1].damping);
}

TEST(TomlValue, WhatPeopleType) {
  EXPECT_EQ(as_toml_value("30"), "30");
  EXPECT_EQ(as_toml_value(" 1e-3 "), "1e-3");
  EXPECT_EQ(as_toml_value("[0, 0, -9.81]"), "[0, 0, -9.81]");
  EXPECT_EQ(as_toml_value("true"), "true");
  EXPECT_EQ(as_toml_value("gripper_box"), "\"gripper_box\"");
  EXPECT_EQ(as_toml_value("\"gripper box\""), "\"gripper box\"");
  for (const char* wrong : {"", " ", "1 2", "1\nx = 2", "[1", "a=b", "3 # note", "1, 2", "]"}) {
    EXPECT_EQ(as_toml_value(wrong), std::nullopt) << wrong;
  }
}

// ---- payloads

constexpr const char* kBox =
    "[[payload]]\nname = \"box\"\nmass = 2\ncom = [0.1, 0.05, 0]\n"
    "inertia = [0.02, 0.03, 0.04]\nproducts = [0.001, 0, 0]\n";

class Payloads : public Difference {};

// Independent of with_payload(): the same body as a link of its own, welded to the tip.
TEST_F(Payloads, WeighAsALinkOfTheirOwn) {
  write("robot.toml", std::string(kRobotToml) + kBox);
  const LoadResult loaded = tuned({{"payload", "\"box\""}});
  ASSERT_TRUE(loaded.ok) << all_of(loaded.messages);
  ASSERT_EQ(loaded.robot.payload, 0U);
  control::TreeDescription welded = load().robot.tree;
  control::LinkDescription box;
  box.name = "box";
  box.inertia.mass_kg = 2.0;
  box.inertia.com_m = {0.1, 0.05, 0.0};
  box.inertia.inertia_kg_m2 << 0.02, 0.001, 0, 0.001, 0.03, 0, 0, 0, 0.04;
  welded.links.push_back(box);
  control::JointDescription weld;
  weld.name = "weld";
  weld.parent_link = "tip";
  weld.child_link = "box";
  welded.joints.push_back(weld);
  const control::Mechanism with = make_mechanism(loaded.robot, loaded.robot.payload);
  const control::Mechanism expected(welded, loaded.robot.gravity);
  control::Workspace a(with);
  control::Workspace b(expected);
  const Eigen::Vector2d q(0.3, -1.1);
  const Eigen::Vector2d v(1.0, -2.0);
  EXPECT_TRUE(control::bias(with, a, q, v).isApprox(control::bias(expected, b, q, v), 1e-13));
}

TEST_F(Payloads, NoneIsTheBareArmToTheBit) {
  const Robot bare = load().robot;
  write("robot.toml", std::string(kRobotToml) + kBox);
  const Robot carried_nothing = tuned({{"robot.payload", "\"none\""}}).robot;
  const control::Mechanism a = make_mechanism(bare, bare.payload);
  const control::Mechanism b = make_mechanism(carried_nothing, carried_nothing.payload);
  control::Workspace wa(a);
  control::Workspace wb(b);
  const Eigen::Vector2d q(0.3, -1.1);
  EXPECT_EQ(control::gravity(a, wa, q), control::gravity(b, wb, q));
}

TEST_F(Payloads, WrongOnesAreNamed) {
  const auto said = [&](const std::string& more) {
    write("robot.toml", std::string(kRobotToml) + more);
    const LoadResult loaded = load();
    EXPECT_FALSE(loaded.ok);
    return all_of(loaded.messages);
  };
  const std::string flat =
      said("[[payload]]\nname = \"box\"\nmass = 1\ninertia = [0.1, 0.1, 0.9]\n");
  EXPECT_NE(flat.find(":27:11: error: payload \"box\": no body can have this inertia"),
            std::string::npos)
      << flat;
  EXPECT_NE(said("[[payload]]\nname = \"box\"\nmass = 1\nlink = \"tpi\"\n")
                .find("the URDF has no link \"tpi\"; did you mean \"tip\"?"),
            std::string::npos);
  EXPECT_NE(said(std::string(kBox) + kBox).find("a second [[payload]] \"box\""), std::string::npos);
  EXPECT_NE(said("[[payload]]\nname = \"none\"\nmass = 1\n").find("choose another"),
            std::string::npos);
  EXPECT_NE(said("[[payload]]\nname = \"box\"\nmass = 0\n").find("mass: found the integer 0"),
            std::string::npos);
  write("robot.toml", std::string(kRobotToml) + kBox);
  const std::string missing = all_of(tuned({{"payload", "\"bxo\""}}).messages);
  EXPECT_NE(missing.find("there is no [[payload]] \"bxo\"; did you mean \"box\"?"),
            std::string::npos)
      << missing;
}

TEST_F(Payloads, MayBeAddedWhileRunning) {
  const Robot before = load().robot;
  write("robot.toml", std::string(kRobotToml) + kBox);
  const std::vector<Change> changes = difference(before, load().robot);
  ASSERT_EQ(lines(changes), "payload.box: - -> there\n");
  EXPECT_EQ(changes.front().live, Live::kYes);
}

}  // namespace
}  // namespace geodesic::config
