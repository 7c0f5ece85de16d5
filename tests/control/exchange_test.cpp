// Going over to another setup while the arm runs: no step in torque, the new setup's torque to the
// bit in the end, and the old one's when it is taken back.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "control/controller.hpp"
#include "tests/control/planar_arm.hpp"

namespace geodesic::control {
namespace {

using testing::Bench;
using testing::kPeriod;
using testing::planar_mechanism;
using testing::planar_options;
using enum SupervisorState;
using Tuned = Setup;  // gtest keeps the name for itself

Tuned random_setup(std::mt19937& random) {
  const auto between = [&random](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  TreeDescription tree = testing::planar_tree();
  tree.links[2].inertia.mass_kg = between(0.5, 4.0);
  ControllerOptions options = planar_options();
  options.retune_s = between(0.05, 0.5);
  for (JointTuning& joint : options.joints) {
    joint.damping = between(0.0, 3.0);
    joint.coulomb_friction = between(0.0, 1.0);
    joint.hold_stiffness = between(0.0, 100.0);
    joint.torque_limit = between(15.0, 60.0);
    joint.torque_rate_limit = between(100.0, 5000.0);
  }
  return {options, Mechanism(tree, Eigen::Vector3d(0.0, between(-9.81, 9.81), 0.0))};
}

void place(Bench& bench, double q1, double q2, double v1, double v2) {
  bench.arm.state.joint[0].position = q1;
  bench.arm.state.joint[1].position = q2;
  bench.arm.state.joint[0].velocity = v1;
  bench.arm.state.joint[1].velocity = v2;
}

/// A bench that has been active for long enough to have whole authority.
Bench& active(Bench& bench) {
  EXPECT_TRUE(bench.run_until(kActive));
  for (int i = 0; i < 1100; ++i) {
    bench.cycle();
  }
  return bench;
}

TEST(Exchange, TorqueNeverStepsAndEndsAsTheNewSetupsToTheBit) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> pose(-1.2, 1.2);
  for (int run = 0; run < 20; ++run) {
    const Tuned old_setup = random_setup(random);
    const Tuned new_setup = random_setup(random);
    ASSERT_TRUE(unexchangeable(old_setup, new_setup).empty());
    Bench bench;
    ASSERT_EQ(bench.controller.exchange(&old_setup), nullptr);
    Bench fresh;
    ASSERT_EQ(fresh.controller.exchange(&new_setup), nullptr);
    active(bench);
    active(fresh);
    const double q1 = pose(random);
    const double q2 = pose(random);
    // A pose that steps is a jump, and a velocity without motion a stuck encoder: the arm goes
    // there within a second, then stands.
    for (int i = 0; i <= 1500; ++i) {
      const double part = std::min(1.0, i / 1000.0);
      for (Bench* each : {&bench, &fresh}) {
        const double going = part < 1.0 ? 1.0 : 0.0;
        place(*each, 0.3 + part * (q1 - 0.3), 0.3 + part * (q2 - 0.3), going * (q1 - 0.3),
              going * (q2 - 0.3));
        each->cycle();
        ASSERT_EQ(each->state(), kActive);
      }
    }
    ASSERT_EQ(bench.controller.exchange(&new_setup), &old_setup);
    const double from[2] = {bench.command.joint[0].torque, bench.command.joint[1].torque};
    double last[2] = {from[0], from[1]};
    bool told = false;
    for (int i = 0; i < 2500; ++i) {
      bench.cycle();
      fresh.cycle();
      told |= bench.report().retuning;
      for (std::size_t k = 0; k < 2; ++k) {
        const JointTuning& tuning = new_setup.options.joints[k];
        const double torque = bench.command.joint[k].torque;
        const double whole = std::abs(fresh.command.joint[k].torque - from[k]);
        const double bound =
            std::min(whole * 1e-3 / new_setup.options.retune_s, tuning.torque_rate_limit * 1e-3);
        // The pose stands still, so that the new law does not change by itself.
        ASSERT_LE(std::abs(torque - last[k]), bound + 1e-9) << run << " " << i << " " << k;
        last[k] = torque;
      }
    }
    EXPECT_TRUE(told);
    EXPECT_FALSE(bench.report().retuning);
    EXPECT_EQ(bench.command.joint[0].torque, fresh.command.joint[0].torque);
    EXPECT_EQ(bench.command.joint[1].torque, fresh.command.joint[1].torque);
  }
}

TEST(Exchange, TakenBackIsTheOldSetupToTheBit) {
  std::mt19937 random(5);
  const Tuned other = random_setup(random);
  Bench bench;
  active(bench);
  const double before = bench.command.joint[0].torque;
  EXPECT_EQ(bench.controller.exchange(&other), nullptr);
  for (int i = 0; i < 20; ++i) {
    bench.cycle();
  }
  const double half_way = bench.command.joint[0].torque;
  EXPECT_EQ(bench.controller.exchange(nullptr), &other);  // in the middle of the change
  bench.cycle();
  EXPECT_NEAR(bench.command.joint[0].torque, half_way, std::abs(before - half_way) * 3e-3 + 1e-9);
  for (int i = 0; i < 2000; ++i) {
    bench.cycle();
  }
  EXPECT_EQ(bench.command.joint[0].torque, before);
  EXPECT_FALSE(bench.report().retuning);
}

TEST(Exchange, IsRefusedWhereTheArmWouldBeOutsideAtOnce) {
  Bench bench;
  active(bench);
  ControllerOptions options = planar_options();
  options.joints[0].position_upper = 0.2;  // the arm is at 0.3
  const Tuned narrow{options, planar_mechanism()};
  EXPECT_EQ(bench.controller.exchange(&narrow), &narrow);
  bench.cycle();
  EXPECT_EQ(bench.state(), kActive);
}

TEST(Exchange, DuringLoweringEndsAtZero) {
  std::mt19937 random(3);
  const Tuned other = random_setup(random);
  Bench bench;
  active(bench);
  bench.controller.request({Request::Kind::kStop, LawKind::kFloat});
  ASSERT_TRUE(bench.run_until(kLowering));
  for (int i = 0; i < 300; ++i) {
    bench.cycle();
  }
  bench.controller.exchange(&other);
  double last = bench.command.joint[0].torque;
  while (bench.state() == kLowering) {
    bench.cycle();
    ASSERT_LE(std::abs(bench.command.joint[0].torque - last), 0.5);
    last = bench.command.joint[0].torque;
  }
  EXPECT_EQ(bench.state(), kOff);
  EXPECT_EQ(last, 0.0);
}

TEST(Exchange, NamesWhatMayNotChange) {
  const Tuned setup{planar_options(), planar_mechanism()};
  EXPECT_TRUE(unexchangeable(setup, setup).empty());
  const auto complains = [&setup](const Tuned& other, const char* what) {
    for (const std::string& complaint : unexchangeable(setup, other)) {
      if (complaint.find(what) != std::string::npos) {
        return true;
      }
    }
    return false;
  };
  Tuned other = setup;
  other.options.joints.pop_back();
  EXPECT_TRUE(complains(other, "the joints are joint1, joint2 and would be joint1"));
  other = setup;
  other.options.law = LawKind::kHold;
  EXPECT_TRUE(complains(other, "the law at start"));
  other = setup;
  other.options.arms = {{"left", 1}, {"right", 2}};
  EXPECT_TRUE(complains(other, "the arms"));
  other = setup;
  other.options.joints[0].damping = -1.0;
  EXPECT_TRUE(complains(other, "joint 'joint1': damping"));
  TreeDescription tree = testing::planar_tree();
  tree.joints[1].parent_from_joint.translation().x() = 0.6;
  other.mechanism = Mechanism(tree, Eigen::Vector3d(0.0, -9.81, 0.0));
  EXPECT_TRUE(complains(other, "joint 'joint2': its place and axis"));
}

}  // namespace
}  // namespace geodesic::control
