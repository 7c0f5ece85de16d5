// Contacts on a simulated arm, by MuJoCo: a force on a link, a moving arm that hits the floor, a
// hand. Each is found within 10 ms of the moment the true torque passes the configured one.
#include <fmt/format.h>

#include "control/mechanism/kinematics.hpp"
#include "tests/tools/watch_bench.hpp"

namespace geodesic::tools {
namespace {

using control::ContactReaction;
using control::Fault;
using control::LawKind;
using control::SupervisorState;

class Contact : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    robot_ = test::load(GetParam());
    robot_.simulation.floor = false;
  }
  config::Robot robot_;
};

/// A loop whose start is over and whose stand has left.
void settle(test::WatchLoop& loop) {
  ASSERT_TRUE(loop.run_until_authority(1.0));
  loop.cell.on_stand = false;
  loop.run(0.5);
  ASSERT_EQ(loop.report().state, SupervisorState::kActive);
  ASSERT_EQ(loop.first(Fault::kContact), nullptr);
}

/// What `force` [N, world] at the link's origin is at each joint: J' f.
Eigen::VectorXd joint_torques(const config::Robot& robot, const Physics& physics,
                              const std::string& link, const Eigen::Vector3d& force) {
  const control::Mechanism mechanism = test::mechanism_of(robot);
  control::Workspace workspace(mechanism);
  Eigen::VectorXd q(mechanism.dof());
  for (Eigen::Index i = 0; i < q.size(); ++i) q[i] = physics.position(static_cast<std::size_t>(i));
  const control::Jacobian& columns =
      control::jacobian(mechanism, workspace, q, *mechanism.find_link(link));
  return columns.topRows<3>().transpose() * force;
}

/// A force on the tool along `direction` that makes the contact torque at one joint, less at
/// others.
Eigen::Vector3d configured_force(const config::Robot& robot, const Physics& physics,
                                 const Eigen::Vector3d& direction) {
  const Eigen::VectorXd unit = joint_torques(robot, physics, robot.tool_link, direction);
  double scale = std::numeric_limits<double>::infinity();
  for (Eigen::Index i = 0; i < unit.size(); ++i) {
    const double torque = robot.controller.joints[static_cast<std::size_t>(i)].contact_torque;
    scale = std::min(scale, torque / std::max(std::abs(unit[i]), 1e-9));
  }
  return scale * direction;
}

TEST_P(Contact, AForceThatMakesTheConfiguredTorqueIsFoundWithin10Ms) {
  for (const Eigen::Vector3d& direction :
       {Eigen::Vector3d(1.0, 0.2, -0.3), Eigen::Vector3d(-0.2, -1.0, 0.1),
        Eigen::Vector3d(0.3, -0.4, 1.0)}) {
    test::WatchLoop loop(robot_, robot_);
    settle(loop);
    const Eigen::Vector3d force = configured_force(robot_, loop.cell.physics, direction);
    const int link = loop.cell.physics.find_link(robot_.tool_link);
    loop.cell.push = [&](Physics& physics) { physics.add_force(link, force); };
    int cycles = 0;
    while (loop.first(Fault::kContact) == nullptr && cycles < 100) {
      loop.cycle();
      ++cycles;
    }
    fmt::print("{} pushed with {:.1f} N: found in {} ms\n", robot_.name, force.norm(), cycles);
    EXPECT_LE(cycles, 10);
    ASSERT_NE(loop.first(Fault::kContact), nullptr);
    EXPECT_EQ(loop.first(Fault::kContact)->action, control::Action::kWarn);
    // Carries on, and the contact ends after it has ended.
    loop.cell.push = nullptr;
    EXPECT_NE(loop.report().touched, 0U);
  }
}

TEST_P(Contact, ALittleLessThanTheLevelIsNone) {
  test::WatchLoop loop(robot_, robot_);
  settle(loop);
  const Eigen::Vector3d force =
      configured_force(robot_, loop.cell.physics, Eigen::Vector3d(1.0, 0.2, -0.3));
  const int link = loop.cell.physics.find_link(robot_.tool_link);
  loop.cell.push = [&](Physics& physics) { physics.add_force(link, 0.5 * force); };
  loop.run(0.05);
  EXPECT_EQ(loop.first(Fault::kContact), nullptr);
}

TEST_P(Contact, StopIsAControlledStopAndDampGivesWayWhileItLasts) {
  config::Robot stops = robot_;
  stops.controller.safety.contact = ContactReaction::kStop;
  test::WatchLoop stopped(stops, robot_);
  settle(stopped);
  const int link = stopped.cell.physics.find_link(robot_.tool_link);
  const Eigen::Vector3d force =
      configured_force(robot_, stopped.cell.physics, Eigen::Vector3d(1.0, 0.2, -0.3));
  stopped.cell.push = [&](Physics& physics) { physics.add_force(link, force); };
  stopped.run(0.02);
  EXPECT_EQ(stopped.report().state, SupervisorState::kStopping);

  config::Robot damps = robot_;
  damps.controller.safety.contact = ContactReaction::kDamp;
  damps.controller.law = LawKind::kHold;
  test::WatchLoop damped(damps, robot_);
  settle(damped);
  damped.cell.push = [&](Physics& physics) { physics.add_force(link, force); };
  damped.run(0.03);
  ASSERT_NE(damped.first(Fault::kContact), nullptr);
  EXPECT_EQ(damped.first(Fault::kContact)->action, control::Action::kDamp);
  EXPECT_EQ(damped.report().state, SupervisorState::kActive);
  // No spring any more: the torque is the model's less the stop damping.
  for (std::size_t i = 0; i < damped.command.joints; ++i) {
    const control::JointTuning& joint = damps.controller.joints[i];
    const double expected =
        damped.report().model_torque[i] - joint.stop_damping * damped.report().velocity[i];
    if (std::abs(expected) < 0.9 * joint.torque_limit &&
        damped.report().position[i] > joint.position_lower + joint.soft_margin &&
        damped.report().position[i] < joint.position_upper - joint.soft_margin) {
      EXPECT_NEAR(damped.command.joint[i].torque, expected, 1.5) << joint.name;
    }
  }
}

TEST_P(Contact, FloatAndHoldAsConfiguredRaiseNothing) {
  for (const LawKind law : {LawKind::kFloat, LawKind::kHold}) {
    const double size = law == LawKind::kFloat ? 0.5 : 3.0;
    config::Robot calm = robot_;
    calm.controller.law = law;
    test::WatchLoop loop(calm, calm);
    ASSERT_TRUE(loop.run_until_authority(1.0));
    loop.cell.on_stand = false;
    loop.run(1.0);
    // A hand leads it about, gently.
    const int link = loop.cell.physics.find_link(calm.tool_link);
    double t = 0.0;
    loop.cell.push = [&](Physics& physics) {
      t += physics.timestep_s();
      physics.add_force(
          link, size * Eigen::Vector3d(std::sin(6.0 * t), std::cos(5.0 * t), std::sin(4.0 * t)));
    };
    loop.run(2.0);
    EXPECT_EQ(loop.report().state, SupervisorState::kActive);
    for (const control::FaultEvent& event : loop.events) {
      ADD_FAILURE() << control::policy(event.fault).name << " of joint " << event.joint << ": "
                    << event.found << ", limit " << event.limit;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Robots, Contact, testing::Values("planar2r", "openarm"),
                         [](const auto& one) { return std::string(one.param); });

TEST(ContactWithTheFloor, IsFoundWithin10MsOfTheTorqueItMakes) {
  config::Robot robot = test::load("openarm");
  robot.simulation.floor = true;
  const control::Mechanism mechanism = test::mechanism_of(robot);
  const Eigen::VectorXd pose = Eigen::Map<const Eigen::VectorXd>(
      robot.simulation.pose.data(), static_cast<Eigen::Index>(robot.simulation.pose.size()));
  robot.simulation.floor_z_m =
      control::link_pose(mechanism, pose, *mechanism.find_link(robot.tool_link)).translation.z() -
      0.1;
  test::WatchLoop loop(robot, robot);
  settle(loop);
  // Pushed downwards by a hand on the elbow until the hand of the arm meets the floor.
  const int link = loop.cell.physics.find_link("openarm_link4");
  std::optional<double> passed_s;
  double t = 0.0;
  double force_at_contact = 0.0;
  loop.cell.push = [&](Physics& physics) {
    t += physics.timestep_s();
    if (physics.floor_force() == 0.0 && !passed_s) {
      physics.add_force(link, Eigen::Vector3d(0.0, 0.0, -12.0));
    }
    const std::vector<double> true_torque = physics.contact_torques();
    for (std::size_t i = 0; i < true_torque.size() && !passed_s; ++i) {
      if (std::abs(true_torque[i]) > robot.controller.joints[i].contact_torque) {
        passed_s = t;
        force_at_contact = physics.floor_force();
      }
    }
  };
  std::optional<double> found_s;
  for (int cycle = 0; cycle < 3000 && !found_s; ++cycle) {
    loop.cycle();
    if (loop.first(Fault::kContact) != nullptr) found_s = t;
  }
  ASSERT_TRUE(passed_s.has_value()) << "the floor was not hit hard enough";
  ASSERT_TRUE(found_s.has_value());
  fmt::print("floor: {:.0f} N when the torque passed, found {:.1f} ms later\n", force_at_contact,
             1e3 * (*found_s - *passed_s));
  EXPECT_LE(*found_s - *passed_s, 0.010);
}

}  // namespace
}  // namespace geodesic::tools
