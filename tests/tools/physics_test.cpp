// The simulator's mechanics (MuJoCo) against the controller's own equations: two engines, one
// answer. And what only the simulator has: dry friction that holds, stops, mimic gears, the floor.
#include "tools/sim/physics.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "control/mechanism/dynamics.hpp"
#include "control/mechanism/inertia_check.hpp"
#include "tests/tools/sim_robot.hpp"

namespace geodesic::tools {
namespace {

config::Robot load(const std::string& name) {
  config::LoadResult result =
      config::load_robot(std::string(GEODESIC_SOURCE_DIR "/config/robots/") + name + "/robot.toml");
  for (const auto& message : result.messages) {
    if (message.severity == config::Message::Severity::kError) {
      ADD_FAILURE() << config::to_string(message);
    }
  }
  return std::move(result.robot);
}

class PhysicsAgainstControl : public testing::TestWithParam<const char*> {};

TEST_P(PhysicsAgainstControl, SameAccelerationInRandomStates) {
  config::Robot robot = load(GetParam());
  ASSERT_FALSE(robot.arm.joints.empty());
  robot.simulation.floor = false;
  // The simulator cannot have inertias that no body has; compare where both have the same.
  for (control::LinkDescription& link : robot.tree.links) {
    link.inertia = control::check_inertia(link.inertia).nearest;
  }
  control::MechanismOptions options;
  options.rotor_inertia.resize(static_cast<Eigen::Index>(robot.arm.joints.size()));
  for (std::size_t i = 0; i < robot.arm.joints.size(); ++i) {
    robot.simulation.joints[i].coulomb_friction = 0.0;
    robot.simulation.joints[i].viscous_friction = 0.0;
    options.rotor_inertia[static_cast<Eigen::Index>(i)] = robot.simulation.joints[i].rotor_inertia;
  }
  const control::Mechanism mechanism(robot.tree, robot.gravity, options);
  control::Workspace workspace(mechanism);
  Physics physics(robot);
  ASSERT_EQ(static_cast<int>(physics.joints()), mechanism.dof());

  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  for (int sample = 0; sample < 100; ++sample) {
    Eigen::VectorXd q(mechanism.nq());
    Eigen::VectorXd v(mechanism.dof());
    Eigen::VectorXd tau(mechanism.dof());
    for (Eigen::Index i = 0; i < v.size(); ++i) {
      const control::JointLimits& limits = mechanism.joint_limits()[static_cast<std::size_t>(i)];
      const double middle = 0.5 * (limits.lower + limits.upper);
      q[i] = middle + 0.4 * (limits.upper - limits.lower) * unit(random);
      v[i] = unit(random);
      tau[i] = unit(random);
    }
    physics.set_state({q.data(), static_cast<std::size_t>(q.size())},
                      {v.data(), static_cast<std::size_t>(v.size())});
    for (std::size_t i = 0; i < physics.joints(); ++i) {
      physics.set_torque(i, tau[static_cast<Eigen::Index>(i)]);
    }
    const Eigen::VectorXd* expected = control::forward_dynamics(mechanism, workspace, q, v, tau);
    ASSERT_NE(expected, nullptr);
    const double scale = std::max(1.0, expected->lpNorm<Eigen::Infinity>());
    const std::vector<double> found = physics.free_accelerations();
    const std::vector<double> with_gears = physics.accelerations();
    for (std::size_t i = 0; i < found.size(); ++i) {
      const double wanted = (*expected)[static_cast<Eigen::Index>(i)];
      EXPECT_NEAR(found[i], wanted, 1e-6 * scale) << "joint " << i << ", sample " << sample;
      // Mimic gears are constraints that give way a little.
      EXPECT_NEAR(with_gears[i], wanted, 2e-3 * scale) << "joint " << i << ", sample " << sample;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Robots, PhysicsAgainstControl,
                         testing::Values("planar2r", "quad12", "openarm", "openarm-bimanual"),
                         [](const auto& chosen) {
                           std::string name = chosen.param;
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

// 13 mN·m is half a step of the torque a large drive can be commanded.
TEST(Physics, DryFrictionHoldsWithoutCreeping) {
  for (const double rotor : {0.0, 0.012}) {
    config::Robot robot = test::chain(7, 0.05, rotor);
    robot.gravity.setZero();
    Physics physics(robot);
    for (std::size_t i = 0; i < 7; ++i) physics.set_torque(i, i % 2 == 0 ? 0.013 : -0.013);
    for (int step = 0; step < 80'000; ++step) physics.step();  // 20 s
    for (std::size_t i = 0; i < 7; ++i) {
      EXPECT_NEAR(physics.position(i), 0.3, 1e-5) << "joint " << i << ", rotor " << rotor;
    }
  }
}

TEST(Physics, DryFrictionGivesWayAboveItsLimit) {
  config::Robot robot = test::chain(1, 0.05, 0.01);
  robot.gravity.setZero();
  Physics physics(robot);
  const double inertia = 0.01 + 0.9 * (0.04 / 12.0 + 0.1 * 0.1 + 0.01 * 0.01);
  physics.set_torque(0, 0.15);
  for (int step = 0; step < 400; ++step) physics.step();
  EXPECT_NEAR(physics.velocity(0), 0.1 * (0.15 - 0.05) / inertia, 5e-3 * 0.1 * 0.1 / inertia);
}

TEST(Physics, StopsHold) {
  config::Robot robot = test::chain(1, 0.0, 0.01);
  robot.gravity.setZero();
  Physics physics(robot);
  physics.set_torque(0, 2.0);
  for (int step = 0; step < 20'000; ++step) {
    physics.step();
    EXPECT_LT(physics.position(0), 3.0 + 0.05);
  }
  EXPECT_NEAR(physics.position(0), 3.0, 2e-3);
}

TEST(Physics, PushesAccelerateAsTheMassMatrixSays) {
  config::Robot robot = test::chain(3);
  robot.gravity.setZero();
  Physics physics(robot);
  physics.set_torque(1, 0.5);
  const std::vector<double> expected = physics.free_accelerations();
  for (int step = 0; step < 4; ++step) physics.step();
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(physics.velocity(i), expected[i] * 1e-3, 2e-3 * std::abs(expected[1]) * 1e-3);
  }
}

TEST(Physics, ForceOnALinkActsByItsLever) {
  config::Robot robot = test::chain(2);
  robot.gravity.setZero();
  robot.simulation.pose = {0.0, 0.0};
  Physics physics(robot);
  const int link = physics.find_link("link2");  // its origin is 0.2 m along x
  ASSERT_GE(link, 0);
  EXPECT_EQ(physics.find_link("hand"), -1);
  physics.add_force(link, {0.0, 3.0, 0.0});
  EXPECT_NEAR(physics.unbalanced_torques()[0], 0.6, 1e-12);
  EXPECT_NEAR(physics.unbalanced_torques()[1], 0.0, 1e-12);
  physics.clear_forces();
  EXPECT_NEAR(physics.unbalanced_torques()[0], 0.0, 1e-12);
}

TEST(Physics, FloorCarriesWhatFalls) {
  config::Robot robot = test::chain(2, 0.0, 0.01);
  robot.tree.joints[0].axis = Eigen::Vector3d::UnitY();
  robot.simulation.pose = {0.0, 0.0};
  robot.simulation.floor = true;
  robot.simulation.floor_z_m = -0.15;
  Physics physics(robot);
  for (std::size_t i = 0; i < 2; ++i) physics.set_torque(i, 0.0);
  double force = 0.0;
  for (int step = 0; step < 12'000; ++step) {
    physics.step();
    force = std::max(force, physics.floor_force());
  }
  EXPECT_GT(force, 1.0);
  EXPECT_TRUE(physics.finite());
  EXPECT_NEAR(physics.velocity(0), 0.0, 0.05);
}

TEST(Physics, ImpossibleInertiaIsReplacedAndSaid) {
  config::Robot robot = test::chain(2);
  robot.tree.links[2].inertia.inertia_kg_m2 = Eigen::Vector3d(1e-4, 1e-4, 9e-4).asDiagonal();
  const Physics physics(robot);
  ASSERT_EQ(physics.warnings().size(), 1U);
  EXPECT_NE(physics.warnings()[0].find("link2"), std::string::npos);
}

TEST(Physics, RefusesWhatDoesNotFit) {
  config::Robot robot = test::chain(2);
  robot.simulation.pose = {0.0};
  EXPECT_THROW(Physics{robot}, std::invalid_argument);
  robot = test::chain(2);
  robot.arm.joints[1].name = "elbow";
  EXPECT_THROW(Physics{robot}, std::invalid_argument);
  robot = test::chain(2);
  robot.tree.joints[1].child_link = "nowhere";
  EXPECT_THROW(Physics{robot}, std::invalid_argument);
}

}  // namespace
}  // namespace geodesic::tools
