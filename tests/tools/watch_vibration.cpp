// A hold whose gains do not fit: it swings without the detector, and settles with it.
#include <fmt/format.h>

#include "tests/tools/watch_bench.hpp"

namespace geodesic::tools {
namespace {

using control::Fault;
using control::LawKind;
using control::SupervisorState;

struct Swing {
  double late = 0.0;  ///< largest velocity of a joint in the last half second [rad/s]
  double gain = 1.0;
  bool told = false;
  SupervisorState state = SupervisorState::kOff;
};

/// Holds with `factor` times the hold damping of one joint, lets go of the stand, nudges.
Swing hold(config::Robot robot, std::size_t joint, double factor, bool watched,
           double lowest = 0.125) {
  robot.simulation.floor = false;
  robot.controller.law = LawKind::kHold;
  robot.controller.joints[joint].hold_damping *= factor;
  robot.controller.vibration.lowest_authority = lowest;
  for (control::JointTuning& tuning : robot.controller.joints) {
    tuning.velocity_limit = 1e3;  // the swing itself is to be seen
    if (!watched) tuning.vibration_velocity = std::numeric_limits<double>::infinity();
  }
  test::WatchLoop loop(robot, robot);
  EXPECT_TRUE(loop.run_until_authority(1.0));
  loop.cell.on_stand = false;
  loop.cell.push = [&](Physics& physics) {
    physics.set_torque(joint, loop.cell.torque[joint] + 2.0);
  };
  loop.run(0.02);
  loop.cell.push = nullptr;
  loop.run(2.5);
  Swing result;
  for (int cycle = 0; cycle < 500; ++cycle) {
    loop.cycle();
    for (std::size_t i = 0; i < loop.cell.state.joints; ++i) {
      result.late = std::max(result.late, std::abs(loop.cell.physics.velocity(i)));
    }
  }
  result.gain = loop.report().gain[joint];
  result.told = loop.first(Fault::kVibration) != nullptr;
  result.state = loop.report().state;
  fmt::print("{} joint {} hold damping x {}{}: {:.2f} rad/s at the end, gain {:.3f}, {}\n",
             robot.name, joint + 1, factor, watched ? "" : " (not watched)", result.late,
             result.gain, control::to_string(result.state));
  return result;
}

TEST(VibrationOfAnArm, TooHighHoldDampingSwingsWithoutAndSettlesWith) {
  const config::Robot planar = test::load("planar2r");
  const Swing without = hold(planar, 1, 20.0, false);
  EXPECT_GT(without.late, 0.45);
  EXPECT_EQ(without.state, SupervisorState::kActive);
  const Swing with = hold(planar, 1, 20.0, true);
  EXPECT_TRUE(with.told);
  EXPECT_LT(with.gain, 1.0);
  EXPECT_LT(with.late, 0.1);
  EXPECT_EQ(with.state, SupervisorState::kActive);
}

TEST(VibrationOfAnArm, OfAnOpenArmsWrist) {
  const config::Robot arm = test::load("openarm");
  EXPECT_GT(hold(arm, 5, 40.0, false).late, 0.3);
  const Swing with = hold(arm, 5, 40.0, true);
  EXPECT_TRUE(with.told);
  EXPECT_LT(with.late, 0.1);
  EXPECT_EQ(with.state, SupervisorState::kActive);
}

TEST(VibrationOfAnArm, ThatTheLowestGainsDoNotEndStopsIt) {
  const Swing with = hold(test::load("planar2r"), 1, 30.0, true, 1.0);
  EXPECT_TRUE(with.told);
  EXPECT_NE(with.state, SupervisorState::kActive);
}

TEST(VibrationOfAnArm, GainsAsConfiguredRaiseNothing) {
  for (const char* name : {"planar2r", "openarm"}) {
    const Swing calm = hold(test::load(name), 1, 1.0, true);
    EXPECT_FALSE(calm.told) << name;
    EXPECT_EQ(calm.gain, 1.0) << name;
  }
}

}  // namespace
}  // namespace geodesic::tools
