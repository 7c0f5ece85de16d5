// The robots that come with geodesic load, with the figures their READMEs promise; --bus, --strict,
// locks and defaults do what the reference says.
#include <cmath>

#include "config/budget.hpp"
#include "control/mechanism/mechanism.hpp"
#include "tests/config/bench.hpp"

namespace geodesic::config {
namespace {

const std::filesystem::path kRobots = std::filesystem::path(GEODESIC_SOURCE_DIR) / "config/robots";

struct Shipped {
  const char* folder;
  std::size_t joints;
  std::size_t buses;
  std::size_t warnings;
};

class ShippedRobot : public ::testing::TestWithParam<Shipped> {};

TEST_P(ShippedRobot, Loads) {
  const Shipped& expected = GetParam();
  const LoadResult result = load_robot(kRobots / expected.folder / "robot.toml");
  ASSERT_TRUE(result.ok) << all_of(result.messages);
  EXPECT_EQ(result.messages.size(), expected.warnings) << all_of(result.messages);
  const Robot& robot = result.robot;
  EXPECT_EQ(robot.name, expected.folder);
  EXPECT_EQ(robot.period_ns, 1'000'000);
  EXPECT_EQ(robot.arm.buses.size(), expected.buses);
  ASSERT_EQ(robot.arm.joints.size(), expected.joints);
  ASSERT_EQ(robot.controller.joints.size(), expected.joints);
  ASSERT_EQ(robot.simulation.joints.size(), expected.joints);
  ASSERT_EQ(robot.simulation.pose.size(), expected.joints);
  EXPECT_FALSE(robot.controller.allow_zero_law);  // can0 is real

  // In the mechanism's order of v, each with limits that keep it safe.
  const control::Mechanism mechanism(robot.tree, robot.gravity);
  ASSERT_EQ(mechanism.joint_names().size(), expected.joints);
  for (std::size_t i = 0; i < expected.joints; ++i) {
    const control::JointTuning& joint = robot.controller.joints[i];
    EXPECT_EQ(mechanism.joint_names()[i], joint.name);
    EXPECT_EQ(robot.arm.joints[i].name, joint.name);
    EXPECT_TRUE(std::isfinite(joint.torque_limit + joint.velocity_limit + joint.position_lower +
                              joint.position_upper + joint.torque_rate_limit));
    EXPECT_GT(joint.stop_damping, 0.0);
    EXPECT_GT(joint.drive_damping, 0.0);
    EXPECT_GT(joint.wall_stiffness, 0.0);
    // The simulated arm starts off its walls, and has friction.
    EXPECT_GT(robot.simulation.pose[i], joint.position_lower + joint.soft_margin) << joint.name;
    EXPECT_LT(robot.simulation.pose[i], joint.position_upper - joint.soft_margin) << joint.name;
    EXPECT_GT(robot.simulation.joints[i].coulomb_friction, 0.0);
    EXPECT_EQ(robot.simulation.joints[i].rotor_inertia, joint.rotor_inertia);
  }
  EXPECT_TRUE(bus_budget(robot).carried);
}

TEST_P(ShippedRobot, BusOverride) {
  const Shipped& expected = GetParam();
  LoadOptions options;
  for (std::size_t i = 0; i < expected.buses; ++i) {
    options.bus_override.push_back("vcan" + std::to_string(i));
  }
  const LoadResult result = load_robot(kRobots / expected.folder / "robot.toml", options);
  ASSERT_TRUE(result.ok) << all_of(result.messages);
  for (std::size_t i = 0; i < expected.buses; ++i) {
    EXPECT_EQ(result.robot.arm.buses[i].interface, options.bus_override[i]);
  }
  EXPECT_TRUE(result.robot.controller.allow_zero_law);
  options.bus_override.push_back("vcan9");
  if (expected.buses == 1) {
    EXPECT_FALSE(load_robot(kRobots / expected.folder / "robot.toml", options).ok);
  }
}

INSTANTIATE_TEST_SUITE_P(Robots, ShippedRobot,
                         ::testing::Values(Shipped{"planar2r", 2, 1, 0},
                                           Shipped{"quad12", 12, 3, 0}, Shipped{"openarm", 8, 1, 2},
                                           Shipped{"openarm-bimanual", 16, 2, 4}),
                         [](const auto& shipped) { return test_name(shipped.param.folder); });

TEST(Robots, OneBusForTwoIsRefused) {
  LoadOptions options;
  options.bus_override = {"vcan0"};
  const LoadResult result = load_robot(kRobots / "openarm-bimanual/robot.toml", options);
  EXPECT_FALSE(result.ok);
  EXPECT_NE(all_of(result.messages).find("name one for each, in order"), std::string::npos);
}

TEST(Robots, StrictRefusesThePublishedFingers) {
  LoadOptions options;
  options.strict = true;
  const LoadResult result = load_robot(kRobots / "openarm/robot.toml", options);
  EXPECT_FALSE(result.ok);
  EXPECT_TRUE(says(result.messages, "openarm.urdf", 73, 7,
                   "link \"openarm_right_finger\": no body can have this inertia",
                   Message::Severity::kError))
      << all_of(result.messages);
  EXPECT_TRUE(load_robot(kRobots / "planar2r/robot.toml", options).ok);
  EXPECT_TRUE(load_robot(kRobots / "quad12/robot.toml", options).ok);
}

TEST(Robots, OpenArmFigures) {
  const LoadResult result = load_robot(kRobots / "openarm/robot.toml");
  ASSERT_TRUE(result.ok);
  const Robot& robot = result.robot;
  EXPECT_EQ(robot.controller.joints[0].torque_limit, 40.0);  // the URDF's, below the drive's 54
  const auto& gripper = robot.arm.joints.back();
  EXPECT_EQ(gripper.name, "openarm_finger_joint1");
  EXPECT_EQ(gripper.direction, -1.0);
  EXPECT_NEAR(gripper.ratio * 1.0472, 0.044, 1e-6);
  // One drive range at the fingers: 30 rad/s * ratio, less than the URDF's 10 m/s.
  EXPECT_NEAR(robot.controller.joints.back().velocity_limit, 30 * gripper.ratio, 1e-12);
  const control::Mechanism mechanism(robot.tree, robot.gravity);
  EXPECT_NEAR(mechanism.moving_mass(), 4.746784149515509, 1e-12);
}

TEST(Robots, BusBudgetAgreesWithTheArithmetic) {
  const LoadResult planar = load_robot(kRobots / "planar2r/robot.toml");
  const BudgetReport report = bus_budget(planar.robot);
  ASSERT_EQ(report.buses.size(), 1U);
  EXPECT_EQ(report.buses[0].drives, 2U);
  EXPECT_EQ(report.buses[0].budget().worst_ns, 4 * 135'000);
  EXPECT_EQ(report.buses[0].budget().best_ns, 4 * 111'000);
}

using RobotFiles = Bench;

TEST_F(RobotFiles, LockFixesTheJointWhereItIs) {
  std::string text = replaced(kRobotToml, "tool_link = \"tip\"", "lock = { elbow = 0.5 }");
  text.erase(text.find("[[joint]]\nname = \"elbow\""));
  write("robot.toml", text);
  const LoadResult result = load();
  ASSERT_TRUE(result.ok) << all_of(result.messages);
  ASSERT_EQ(result.robot.arm.joints.size(), 1U);
  for (const control::JointDescription& joint : result.robot.tree.joints) {
    if (joint.name != "elbow") continue;
    EXPECT_EQ(joint.kind, control::JointKind::kFixed);
    EXPECT_NEAR(joint.parent_from_joint.linear()(1, 0), std::sin(0.5), 1e-15);
    EXPECT_EQ(joint.parent_from_joint.translation().x(), 0.5);
  }
}

TEST_F(RobotFiles, DefaultsApplyUnlessAJointSaysOtherwise) {
  std::string text(kRobotToml);
  text = replaced(text, "name = \"elbow\"", "name = \"elbow\"\ndamping = 0.1");
  text += "[defaults.joint]\ndamping = 0.3\nhold_stiffness = 7\ndrive = { watchdog_ms = 20 }\n";
  write("robot.toml", text);
  const LoadResult result = load();
  ASSERT_TRUE(result.ok) << all_of(result.messages);
  EXPECT_EQ(result.robot.controller.joints[0].damping, 0.3);
  EXPECT_EQ(result.robot.controller.joints[1].damping, 0.1);
  EXPECT_EQ(result.robot.controller.joints[1].hold_stiffness, 7.0);
  EXPECT_EQ(result.robot.arm.joints[1].drive.watchdog_ns, 20'000'000);
}

TEST_F(RobotFiles, LimitsDefaultToTheLesserOfUrdfAndDrive) {
  const LoadResult result = load();
  EXPECT_EQ(result.robot.controller.joints[0].torque_limit, 54.0);  // URDF 100
  EXPECT_EQ(result.robot.controller.joints[1].torque_limit, 20.0);  // URDF 20
  EXPECT_EQ(result.robot.controller.joints[1].velocity_limit, 10.0);
  EXPECT_EQ(result.robot.controller.joints[1].position_upper, 2.5);
  EXPECT_EQ(result.robot.simulation.pose[1], -0.5);
}

TEST_F(RobotFiles, ContinuousJointIsLimitedByWhatTheDriveCounts) {
  write("two.urdf", replaced(kTwoUrdf, "name=\"elbow\" type=\"revolute\"",
                             "name=\"elbow\" type=\"continuous\""));
  const LoadResult result = load();
  ASSERT_TRUE(result.ok) << all_of(result.messages);
  EXPECT_EQ(result.robot.controller.joints[1].position_lower, -12.5);
  EXPECT_EQ(result.robot.controller.joints[1].position_upper, 12.5);
}

}  // namespace
}  // namespace geodesic::config
