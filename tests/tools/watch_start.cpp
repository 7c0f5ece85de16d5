// The check at arm-up on a simulated arm: wrong sign, wrong masses, a payload nobody told of, and
// the arms that are right: on a stand, and let go of at any moment of the ramp.
#include <fmt/format.h>

#include "tests/tools/watch_bench.hpp"

namespace geodesic::tools {
namespace {

using control::Fault;
using control::StaticCheckState;
using control::SupervisorState;
using control::Suspect;

struct Start {
  bool failed = false;
  control::FaultEvent event;
  double authority = 0.0;  ///< when it was found
  double travel = 0.0;     ///< largest distance of any joint from its start, active or stopping
  double fastest = 0.0;
  StaticCheckState state = StaticCheckState::kOff;
  SupervisorState left = SupervisorState::kOff;  ///< the state at the end
};

/// A start whose stand leaves at `release` (more than 1: never); `reversed` is that joint, or -1.
Start start(const config::Robot& believed, const config::Robot& real, double release,
            int reversed = -1) {
  test::WatchLoop loop(believed, real);
  if (reversed >= 0) loop.cell.sign[static_cast<std::size_t>(reversed)] = -1.0;
  std::vector<double> from;
  for (std::size_t i = 0; i < loop.cell.state.joints; ++i) {
    from.push_back(loop.cell.physics.position(i));
  }
  Start result;
  for (int cycle = 0; cycle < (result.failed ? 9000 : 2500); ++cycle) {
    loop.cycle();
    if (result.failed && loop.report().state == SupervisorState::kFault) break;
    if (loop.report().state == SupervisorState::kActive && loop.report().authority >= release) {
      loop.cell.on_stand = false;
    }
    if (!result.failed && loop.first(Fault::kStaticTorque) != nullptr) {
      result.failed = true;
      result.event = *loop.first(Fault::kStaticTorque);
      result.authority = loop.report().authority;
    }
    // Until it is let down on purpose.
    const bool torque = loop.report().state == SupervisorState::kActive ||
                        loop.report().state == SupervisorState::kStopping;
    for (std::size_t i = 0; torque && i < from.size(); ++i) {
      result.travel = std::max(result.travel, std::abs(loop.cell.physics.position(i) - from[i]));
      result.fastest = std::max(result.fastest, std::abs(loop.cell.physics.velocity(i)));
    }
    for (std::size_t i = 0; i < from.size(); ++i) {
      result.state = std::max(result.state, loop.report().static_check[i]);
    }
  }
  for (const control::FaultEvent& event : loop.events) {
    EXPECT_TRUE(event.fault == Fault::kStaticTorque || event.action == control::Action::kWarn)
        << control::policy(event.fault).name;
  }
  result.left = loop.report().state;
  return result;
}

void tell(const char* what, const Start& seen, const config::Robot& robot) {
  if (seen.failed) {
    fmt::print(
        "{:<34} {} at authority {:.2f}: {:+.2f} of {:.2f}, suspect {} {:.2f}; travel {:.3f}, "
        "{:.2f} rad/s\n",
        what, robot.arm.joints[static_cast<std::size_t>(seen.event.joint)].name, seen.authority,
        seen.event.found, seen.event.limit, static_cast<int>(seen.event.suspicion.what),
        seen.event.suspicion.size, seen.travel, seen.fastest);
  } else {
    fmt::print("{:<34} no fault, {}; travel {:.4f}, {:.2f} rad/s\n", what,
               control::to_string(seen.state), seen.travel, seen.fastest);
  }
}

class ArmUp : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    robot_ = test::load(GetParam());
    robot_.simulation.floor = false;
  }
  config::Robot robot_;
};

TEST_P(ArmUp, TheRightArmRaisesNothingWheneverItIsLetGo) {
  for (const double release : {0.1, 0.3, 0.6, 0.9}) {
    const Start seen = start(robot_, robot_, release);
    tell("right, let go in the ramp", seen, robot_);
    EXPECT_FALSE(seen.failed) << release;
    EXPECT_EQ(seen.left, SupervisorState::kActive);
    EXPECT_LT(seen.travel, 0.06);
  }
}

TEST_P(ArmUp, OnItsStandThereIsNothingToSee) {
  const Start seen = start(robot_, robot_, 2.0);
  tell("right, on its stand", seen, robot_);
  EXPECT_FALSE(seen.failed);
  EXPECT_EQ(seen.state, StaticCheckState::kPending);
  EXPECT_LT(seen.travel, 0.002);
  // Nor does a payload show as long as the stand carries it.
  config::Robot loaded = robot_;
  test::add_payload(loaded, 1.0);
  EXPECT_FALSE(start(robot_, loaded, 2.0).failed);
}

TEST_P(ArmUp, HeavierMassesAreNamedBeforeFullAuthority) {
  config::Robot heavier = robot_;
  test::scale_masses(heavier, [](std::size_t) { return 1.3; });
  for (const double release : {0.2, 0.8}) {
    const Start seen = start(robot_, heavier, release);
    tell("masses + 30 %", seen, robot_);
    ASSERT_TRUE(seen.failed);
    EXPECT_LT(seen.authority, 1.0);
    EXPECT_EQ(seen.event.suspicion.what, Suspect::kWrongMass);
    EXPECT_NEAR(seen.event.suspicion.size, 0.3, 0.15);
    EXPECT_EQ(seen.left, SupervisorState::kFault);
  }
}

TEST_P(ArmUp, LighterMassesLiftOffAndAreNamed) {
  config::Robot lighter = robot_;
  test::scale_masses(lighter, [](std::size_t) { return 0.6; });
  const Start seen = start(robot_, lighter, 2.0);  // it leaves the stand by itself
  tell("masses - 40 %", seen, robot_);
  ASSERT_TRUE(seen.failed);
  EXPECT_LT(seen.authority, 1.0);
  EXPECT_EQ(seen.event.suspicion.what, Suspect::kWrongMass);
  EXPECT_LT(seen.event.suspicion.size, -0.2);
}

TEST_P(ArmUp, AnUncountedPayloadIsNamedAndWeighed) {
  config::Robot loaded = robot_;
  test::add_payload(loaded, 1.0);
  for (const double release : {0.2, 0.4, 0.6, 0.8}) {
    const Start seen = start(robot_, loaded, release);
    tell("payload 1 kg", seen, robot_);
    ASSERT_TRUE(seen.failed);
    EXPECT_LT(seen.authority, 1.0);
    EXPECT_LT(seen.travel, 0.3);  // held while it is stopped
    EXPECT_EQ(seen.event.suspicion.what, Suspect::kPayload);
    EXPECT_NEAR(seen.event.suspicion.size, 1.0, 0.3);
    EXPECT_EQ(seen.left, SupervisorState::kFault);
  }
}

TEST_P(ArmUp, AWrongSignIsCaughtFast) {
  // Joints that carry something; one that does not shows nothing until it moves.
  const bool planar = robot_.controller.joints.size() == 2;
  for (const int joint : {planar ? 0 : 1, planar ? 1 : 3}) {
    const Start seen = start(robot_, robot_, 2.0, joint);
    tell("sign flipped", seen, robot_);
    ASSERT_TRUE(seen.failed) << joint;
    EXPECT_EQ(seen.event.joint, joint);
    EXPECT_EQ(seen.event.suspicion.what, Suspect::kWrongSign);
    EXPECT_LT(seen.authority, 0.3);
    EXPECT_LT(seen.fastest, 3.0);
    EXPECT_EQ(seen.left, SupervisorState::kFault);
  }
}

INSTANTIATE_TEST_SUITE_P(Robots, ArmUp, testing::Values("planar2r", "openarm"),
                         [](const auto& one) { return std::string(one.param); });

}  // namespace
}  // namespace geodesic::tools
