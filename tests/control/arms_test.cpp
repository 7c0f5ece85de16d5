// Two arms of one robot: each its own start, stop and faults, and what one's fault means to the
// other.
#include "control/arms.hpp"

#include <gtest/gtest.h>

#include <stdexcept>

#include "control/safety/supervise_arms.hpp"
#include "tests/control/planar_arm.hpp"

namespace geodesic::control {
namespace {

using testing::kPeriod;
using enum SupervisorState;

/// The planar arm twice on one base: left1, left2 on bus 0, right1, right2 on bus 1.
Mechanism two_arms() {
  const TreeDescription one = testing::planar_tree();
  TreeDescription both;
  both.name = "two";
  both.root_link = "base";
  both.links.push_back(one.links[0]);
  for (const std::string side : {"left", "right"}) {
    for (std::size_t i = 0; i < 2; ++i) {
      LinkDescription link = one.links[i + 1];
      link.name = side + "_" + link.name;
      both.links.push_back(link);
      JointDescription joint = one.joints[i];
      joint.name = side + std::to_string(i + 1);
      joint.parent_link = i == 0 ? "base" : side + "_link1";
      joint.child_link = link.name;
      both.joints.push_back(joint);
    }
  }
  return {both, Eigen::Vector3d(0.0, -9.81, 0.0)};
}

ControllerOptions two_arm_options(OtherArm other_arm) {
  const ControllerOptions one = testing::planar_options();
  ControllerOptions both = one;
  both.joints.clear();
  for (const std::string side : {"left", "right"}) {
    for (std::size_t i = 0; i < 2; ++i) {
      JointTuning joint = one.joints[i];
      joint.name = side + std::to_string(i + 1);
      joint.bus = side == "left" ? 0 : 1;
      both.joints.push_back(joint);
    }
  }
  both.arms = {{"left", 0b0011}, {"right", 0b1100}};
  both.safety.other_arm = other_arm;
  return both;
}

struct TwoArms {
  explicit TwoArms(OtherArm other_arm) : controller(two_arms(), two_arm_options(other_arm)) {
    arm.state.buses = 2;
  }

  template <class Disturb>
  void run(int cycles, Disturb disturb) {
    for (int i = 0; i < cycles; ++i) {
      arm.obey(command);
      ArmState seen = arm.state;
      disturb(seen);
      command = controller.update(seen, kPeriod);
      for (std::size_t k = 0; k < controller.report().events; ++k) {
        told.push_back(controller.report().event[k]);
      }
    }
  }
  void run(int cycles) {
    run(cycles, [](ArmState&) {});
  }
  SupervisorState left() const { return controller.report().arm[0].state; }
  SupervisorState right() const { return controller.report().arm[1].state; }

  Controller controller;
  testing::ObedientArm arm{4};
  ArmCommand command;
  std::vector<FaultEvent> told;
};

TEST(Arms, BothStartByThemselves) {
  TwoArms robot(OtherArm::kStop);
  robot.run(1500);
  EXPECT_EQ(robot.left(), kActive);
  EXPECT_EQ(robot.right(), kActive);
  EXPECT_EQ(robot.controller.report().arms, 2u);
  EXPECT_EQ(robot.command.joint[0].torque, robot.command.joint[2].torque);
}

TEST(Arms, TheOtherStopsACycleLaterOrCarriesOn) {
  for (const OtherArm other_arm : {OtherArm::kStop, OtherArm::kCarryOn}) {
    TwoArms robot(other_arm);
    robot.run(1500);
    robot.told.clear();
    const double held = robot.command.joint[2].torque;
    robot.run(1, [](ArmState& state) { state.bus[0].bus_off = true; });
    EXPECT_EQ(robot.left(), kStopping);
    EXPECT_EQ(robot.right(), kActive);
    ASSERT_EQ(robot.told.size(), 1u);
    EXPECT_EQ(robot.told[0].fault, Fault::kBusOff);
    EXPECT_EQ(robot.told[0].arm, 0);
    robot.run(1);
    if (other_arm == OtherArm::kStop) {
      EXPECT_EQ(robot.right(), kStopping);
      ASSERT_EQ(robot.told.size(), 2u);
      EXPECT_EQ(robot.told[1].fault, Fault::kOtherArm);
      EXPECT_EQ(robot.told[1].arm, 1);
      EXPECT_NEAR(robot.command.joint[2].torque, held, 1e-9);  // held, not dropped
      robot.run(4000);
      EXPECT_EQ(robot.left(), kFault);
      EXPECT_EQ(robot.right(), kFault);
      EXPECT_EQ(robot.controller.report().state, kFault);
      // Asked again, both start.
      robot.controller.request({Request::Kind::kLaw, LawKind::kFloat});
      robot.run(1500);
      EXPECT_EQ(robot.left(), kActive);
      EXPECT_EQ(robot.right(), kActive);
    } else {
      robot.run(4000);
      EXPECT_EQ(robot.left(), kFault);
      EXPECT_EQ(robot.right(), kActive);
      EXPECT_EQ(robot.controller.report().state, kActive);
      EXPECT_EQ(robot.command.joint[2].torque, held);
      EXPECT_EQ(robot.command.joint[0].torque, 0.0);
      // The one that failed is asked by itself; the drives of the other are left alone.
      Request again{Request::Kind::kLaw, LawKind::kFloat};
      again.arm = 0;
      robot.controller.request(again);
      robot.run(1);
      EXPECT_EQ(robot.controller.report().restart, 0b0011u);
      robot.run(1500);
      EXPECT_EQ(robot.left(), kActive);
      EXPECT_EQ(robot.command.joint[2].torque, held);
    }
  }
}

TEST(Arms, AStopConcernsAllOrOne) {
  TwoArms robot(OtherArm::kStop);
  robot.run(1500);
  Request stop{Request::Kind::kStop, LawKind::kFloat};
  stop.arm = 1;
  robot.controller.request(stop);
  robot.run(2000);
  EXPECT_EQ(robot.left(), kActive);  // a stop that was asked for is no fault
  EXPECT_EQ(robot.right(), kOff);
  robot.controller.request({Request::Kind::kStop, LawKind::kFloat});
  robot.run(2000);
  EXPECT_EQ(robot.left(), kOff);
  EXPECT_EQ(robot.controller.report().state, kOff);
  stop.arm = 7;
  robot.controller.request(stop);
  robot.run(1);
  EXPECT_STREQ(robot.controller.report().refused, "there is no such arm");
}

TEST(Arms, OneThatNeverConnectsDoesNotHinderTheOther) {
  TwoArms robot(OtherArm::kCarryOn);
  robot.run(5000, [](ArmState& state) {
    for (std::size_t i = 0; i < 2; ++i) {
      state.joint[i] = JointState{};
    }
  });
  EXPECT_EQ(robot.left(), kFault);
  EXPECT_EQ(robot.right(), kActive);
  TwoArms whole(OtherArm::kCarryOn);
  whole.run(5000);
  EXPECT_EQ(robot.command.joint[2].torque, whole.command.joint[2].torque);
  EXPECT_NE(robot.command.joint[2].torque, 0.0);
}

TEST(Arms, OverrunsConcernAll) {
  TwoArms robot(OtherArm::kCarryOn);
  robot.run(1500);
  robot.run(10, [](ArmState& state) { state.overran = true; });
  EXPECT_EQ(robot.left(), kStopping);
  EXPECT_EQ(robot.right(), kStopping);
}

TEST(Arms, JointsThatCarryEachOtherAreOneArm) {
  ControllerOptions options = testing::planar_options();
  options.arms = {{"upper", 1}, {"lower", 2}};
  EXPECT_TRUE(check_arms(options).empty());
  ASSERT_EQ(check_arms(options, testing::planar_mechanism()).size(), 1u);
  EXPECT_THROW(Controller(testing::planar_mechanism(), options), std::invalid_argument);
  options.arms = {{"upper", 1}};
  ASSERT_EQ(check(options).size(), 1u);
  EXPECT_NE(check(options)[0].find("'joint2' belongs to no arm"), std::string::npos);
  options.arms = {{"a", 3}, {"a", 2}};
  EXPECT_EQ(check(options).size(), 2u);
}

TEST(Arms, TheRobotsStateIsThatInWhichMostCanMove) {
  EXPECT_EQ(overall(kOff, kFault), kFault);
  EXPECT_EQ(overall(kFault, kConnecting), kConnecting);
  EXPECT_EQ(overall(kLowering, kEnabling), kLowering);
  EXPECT_EQ(overall(kStopping, kActive), kActive);
  EXPECT_EQ(overall(kOff, kOff), kOff);
}

// A joint that misses replies: predicted, damped and faded, stopped; and counted.
TEST(MissingReplies, ArePredictedThenDampedThenStopped) {
  ControllerOptions options = testing::planar_options();
  options.law = LawKind::kHold;
  options.safety.carry_on_cycles = 3;
  options.safety.damp_cycles = 5;
  options.safety.silent_cycles = 9;
  testing::Bench bench(options);
  ASSERT_TRUE(bench.run_until(kActive));
  for (int i = 0; i < 1200; ++i) {
    bench.cycle();
  }
  bench.arm.state.joint[1].position = 0.4;  // the spring of hold pulls by 5 N·m
  for (int i = 0; i < 100; ++i) {
    bench.cycle();
  }
  const auto spring = [&bench] {
    return bench.command.joint[1].torque - bench.report().model_torque[1];
  };
  const auto silence = [](ArmState& state) { state.joint[1].fresh = false; };
  for (int missed = 1; missed <= 8; ++missed) {
    bench.cycle(silence);
    ASSERT_EQ(bench.state(), kActive);
    EXPECT_EQ(bench.report().missing[1].run, static_cast<std::uint32_t>(missed));
    EXPECT_EQ(bench.command.joint[1].damping, missed >= 5 ? 1.5 : 0.0) << missed;
    EXPECT_NEAR(spring(), -5.0 * (missed < 5 ? 1.0 : (9 - missed) / 5.0), 0.05) << missed;
    EXPECT_EQ(bench.command.joint[0].damping, 0.0);
  }
  bench.cycle();
  EXPECT_EQ(bench.report().missing[1].run, 0u);
  EXPECT_EQ(bench.report().missing[1].longest, 8u);
  EXPECT_EQ(bench.report().missing[1].total, 8u);
  EXPECT_EQ(bench.command.joint[1].damping, 0.0);
  for (int i = 0; i < 9; ++i) {
    bench.cycle(silence);
  }
  EXPECT_EQ(bench.state(), kStopping);
  EXPECT_EQ(bench.report().missing[0].total, 0u);
}

TEST(MissingReplies, OptionsKeepTheirOrder) {
  ControllerOptions options = testing::planar_options();
  options.safety.damp_cycles = options.safety.carry_on_cycles;
  ASSERT_EQ(check(options).size(), 1u);
  EXPECT_NE(check(options)[0].find("damp_cycles is 2"), std::string::npos);
  options = testing::planar_options();
  options.safety.silent_cycles = 2;
  ASSERT_EQ(check(options).size(), 1u);
  EXPECT_NE(check(options)[0].find("silent_cycles is 2"), std::string::npos);
}

// A falling arm is never the first answer: after lowering the drives damp until it rests.
TEST(Settling, DrivesDampUntilTheArmRests) {
  testing::Bench bench;
  ASSERT_TRUE(bench.run_until(kActive));
  bench.controller.request({Request::Kind::kStop, LawKind::kFloat});
  ASSERT_TRUE(bench.run_until(kLowering));
  bench.arm.state.joint[0].velocity = 0.2;  // it sinks
  for (int i = 0; i < 1500; ++i) {
    bench.arm.state.joint[0].position -= 0.2e-3;
    bench.cycle();
    ASSERT_EQ(bench.state(), kLowering);
  }
  EXPECT_EQ(bench.command.joint[0].torque, 0.0);
  EXPECT_EQ(bench.command.joint[0].mode, DriveMode::kEnable);
  EXPECT_EQ(bench.command.joint[0].damping, 1.5);
  bench.arm.state.joint[0].velocity = 0.0;  // it has come down
  EXPECT_TRUE(bench.run_until(kOff, 150));
}

}  // namespace
}  // namespace geodesic::control
