// Every transition of the state machine, step by step.
#include "control/safety/supervisor.hpp"

#include <gtest/gtest.h>

#include "tests/control/safety/machine.hpp"

namespace geodesic::control {
namespace {

using testing::kAll;
using testing::kJoints;
using testing::Machine;
using enum SupervisorState;

TEST(Supervisor, StartsByItselfOnceAndTellsTheDrives) {
  Machine machine;
  EXPECT_EQ(machine.step(), kConnecting);
  EXPECT_TRUE(machine.decision.restart_drives);
  machine.obey();
  machine.step();
  EXPECT_FALSE(machine.decision.restart_drives);
  EXPECT_GT(machine.run_until(kActive), 0);
  machine.flags.stop_requested = true;
  EXPECT_GT(machine.run_until(kOff), 0);
  EXPECT_EQ(machine.run(5000), kOff);  // no second time
}

TEST(Supervisor, WaitsForARequestIfToldSo) {
  Machine machine;
  machine.options.start_active = false;
  EXPECT_EQ(machine.run(5000), kOff);
  machine.flags.law_requested = true;
  EXPECT_EQ(machine.step(), kConnecting);
  EXPECT_TRUE(machine.decision.restart_drives);
}

TEST(Supervisor, PassesEveryStateOnTheWayUpAndDown) {
  Machine machine;
  EXPECT_GE(machine.run_until(kConnecting), 0);
  EXPECT_GE(machine.run_until(kReady), 2);
  EXPECT_GE(machine.run_until(kEnabling), 100);  // stop_rest_s at rest first
  EXPECT_GE(machine.run_until(kActive), 1);
  machine.flags.stop_requested = true;
  EXPECT_EQ(machine.run(1), kStopping);
  EXPECT_EQ(machine.run_until(kLowering), 100);
  EXPECT_EQ(machine.run_until(kOff), 1000);
}

TEST(Supervisor, StopBeforeTorqueGoesStraightToOff) {
  for (const SupervisorState from : {kConnecting, kReady, kEnabling}) {
    Machine machine;
    ASSERT_GE(machine.run_until(from), 0);
    machine.flags.stop_requested = true;
    machine.flags.law_requested = true;  // a stop wins
    EXPECT_EQ(machine.run(1), kOff) << to_string(from);
  }
}

TEST(Supervisor, ConnectsOnlyWithEveryJoint) {
  for (std::size_t joint = 0; joint < kJoints; ++joint) {
    Machine machine;
    machine.flags.fresh = kAll & ~bit(joint);
    EXPECT_EQ(machine.run(2000), kConnecting);
    EXPECT_EQ(machine.run_until(kFault) + 2000, 3001);
    EXPECT_EQ(machine.told(Fault::kConnectTimeout), 1);
    EXPECT_EQ(machine.decision.event[0].joint, static_cast<int>(joint));
  }
}

TEST(Supervisor, NamesADriveErrorThatTheDialogueDoesNotClear) {
  Machine machine;
  machine.flags.error = bit(1);
  EXPECT_EQ(machine.run(1000), kConnecting);
  machine.flags.error = 0;
  EXPECT_EQ(machine.run(5), kReady);

  Machine stuck;
  stuck.flags.error = bit(1);
  EXPECT_GT(stuck.run_until(kFault), 2999);
  EXPECT_EQ(stuck.told(Fault::kDriveError), 1);
  EXPECT_EQ(stuck.told(Fault::kConnectTimeout), 0);
}

TEST(Supervisor, RefusedDriveEndsTheStart) {
  Machine machine;
  machine.run(2);
  machine.flags.refused = bit(2);
  EXPECT_EQ(machine.run(1), kFault);
  EXPECT_EQ(machine.told(Fault::kDriveRefused), 1);
}

TEST(Supervisor, StartsOnlyFromRest) {
  Machine machine;
  machine.flags.moving = bit(0);
  ASSERT_GE(machine.run_until(kReady), 0);
  machine.run(1);
  EXPECT_EQ(machine.told(Fault::kNotAtRest), 1);
  machine.run(1);
  EXPECT_EQ(machine.told(Fault::kNotAtRest), 0);  // an edge, told once
  EXPECT_EQ(machine.run(3000), kReady);
  machine.flags.moving = 0;
  EXPECT_EQ(machine.run(50), kReady);
  machine.flags.moving = bit(1);  // a turning point of a swing is no rest
  machine.run(1);
  machine.flags.moving = 0;
  EXPECT_EQ(machine.run(90), kReady);
  EXPECT_EQ(machine.run(20), kActive);
}

TEST(Supervisor, StartsOnlyInsideTheLimits) {
  Machine machine;
  machine.flags.outside = bit(2);
  ASSERT_GE(machine.run_until(kReady), 0);
  machine.run(1);
  EXPECT_EQ(machine.told(Fault::kStartOutsideLimits), 1);
  EXPECT_EQ(machine.run(3000), kReady);
  machine.flags.outside = 0;
  EXPECT_EQ(machine.run(10), kActive);
}

TEST(Supervisor, EnablingThatTakesTooLongNamesTheJoint) {
  Machine machine;
  ASSERT_GE(machine.run_until(kEnabling), 0);
  for (int i = 0; i < 501 && machine.state() == kEnabling; ++i) {
    machine.obey();
    machine.flags.enabled &= ~bit(1);
    machine.step();
  }
  EXPECT_EQ(machine.state(), kFault);
  EXPECT_EQ(machine.told(Fault::kEnableTimeout), 1);
  EXPECT_EQ(machine.decision.event[0].joint, 1);
}

TEST(Supervisor, AnArmThatMovesWhileEnablingDoesNotBecomeActive) {
  Machine machine;
  ASSERT_GE(machine.run_until(kEnabling), 0);
  machine.flags.moving = bit(0);
  EXPECT_EQ(machine.run(499), kEnabling);
  EXPECT_EQ(machine.run(2), kFault);
}

TEST(Supervisor, AuthorityRampsUpHoldsAndRampsDown) {
  Machine machine;
  ASSERT_GE(machine.run_until(kActive), 0);
  EXPECT_EQ(machine.memory.authority, 0.0);
  machine.run(250);
  EXPECT_NEAR(machine.memory.authority, 0.25, 1e-9);
  machine.flags.unrested = bit(0);
  machine.flags.stop_requested = true;
  machine.run(1);
  EXPECT_NEAR(machine.memory.authority, 0.25, 1e-9);
  machine.run(1000);
  EXPECT_NEAR(machine.memory.authority, 0.25, 1e-9);  // never rises while stopping
  machine.flags.unrested = 0;
  ASSERT_GE(machine.run_until(kLowering), 0);
  machine.run(500);
  EXPECT_NEAR(machine.memory.authority, 0.125, 1e-9);
  ASSERT_GE(machine.run_until(kOff), 0);
  EXPECT_EQ(machine.memory.authority, 0.0);
}

TEST(Supervisor, AStopThatFindsNoRestTimesOut) {
  Machine machine;
  ASSERT_GE(machine.run_until(kActive), 0);
  machine.flags.unrested = bit(0);
  machine.flags.stop_requested = true;
  machine.run(1);
  EXPECT_EQ(machine.run_until(kLowering), 2000);
}

TEST(Supervisor, ASilentJointIsAFaultAfterExactlySilentCycles) {
  Machine machine;
  ASSERT_GE(machine.run_until(kActive), 0);
  machine.flags.fresh = kAll & ~bit(1);
  EXPECT_EQ(machine.run(machine.options.safety.silent_cycles - 1), kActive);
  machine.flags.fresh = kAll;  // one answer, and the count begins anew
  EXPECT_EQ(machine.run(1), kActive);
  machine.flags.fresh = kAll & ~bit(1);
  EXPECT_EQ(machine.run(machine.options.safety.silent_cycles - 1), kActive);
  EXPECT_EQ(machine.run(1), kStopping);
  EXPECT_EQ(machine.told(Fault::kJointSilent), 1);
  EXPECT_EQ(machine.decision.event[0].joint, 1);
  EXPECT_GT(machine.run_until(kFault), 0);
}

TEST(Supervisor, OverrunsInARowAreAFault) {
  Machine machine;
  ASSERT_GE(machine.run_until(kActive), 0);
  machine.flags.overran = true;
  EXPECT_EQ(machine.run(9), kActive);
  machine.flags.overran = false;
  EXPECT_EQ(machine.run(1), kActive);
  machine.flags.overran = true;
  EXPECT_EQ(machine.run(10), kStopping);
  EXPECT_EQ(machine.told(Fault::kOverrun), 1);
  EXPECT_EQ(machine.decision.event[0].joint, kNoJoint);
}

TEST(Supervisor, AFailedDriveIsDisabledWhileTheOthersHold) {
  Machine machine;
  ASSERT_GE(machine.run_until(kActive), 0);
  machine.flags.error = bit(1);
  EXPECT_EQ(machine.run(1), kStopping);
  EXPECT_EQ(machine.told(Fault::kDriveError), 1);
  EXPECT_EQ(machine.told(Fault::kDriveDisabled), 0);
  EXPECT_EQ(drive_mode(machine.memory, 1, DriveCondition::kError), DriveMode::kDisable);
  EXPECT_EQ(drive_mode(machine.memory, 0, DriveCondition::kEnabled), DriveMode::kEnable);
  machine.flags.error = 0;  // it does not come back in the middle of the stop
  machine.run(1);
  EXPECT_EQ(drive_mode(machine.memory, 1, DriveCondition::kDisabled), DriveMode::kDisable);
}

TEST(Supervisor, ADriveThatLeavesEnabledIsAFault) {
  Machine machine;
  ASSERT_GE(machine.run_until(kActive), 0);
  machine.obey();
  machine.flags.enabled = kAll & ~bit(0);
  EXPECT_EQ(machine.step(), kStopping);
  EXPECT_EQ(machine.told(Fault::kDriveDisabled), 1);
}

TEST(Supervisor, DriveModesFollowTheState) {
  Machine machine;
  EXPECT_EQ(drive_mode(machine.memory, 0, DriveCondition::kEnabled), DriveMode::kDisable);
  EXPECT_EQ(drive_mode(machine.memory, 0, DriveCondition::kDisabled), DriveMode::kMonitor);
  machine.run_until(kConnecting);
  EXPECT_EQ(drive_mode(machine.memory, 0, DriveCondition::kUnknown), DriveMode::kMonitor);
  EXPECT_EQ(drive_mode(machine.memory, 0, DriveCondition::kEnabled), DriveMode::kDisable);
  machine.run_until(kEnabling);
  EXPECT_EQ(drive_mode(machine.memory, 0, DriveCondition::kDisabled), DriveMode::kEnable);
}

TEST(Supervisor, AWarningIsToldOncePerRise) {
  Machine machine;
  ASSERT_GE(machine.run_until(kActive), 0);
  int told = 0;
  for (int i = 0; i < 5000; ++i) {
    machine.set(Fault::kTorqueSaturated, i % 2 == 0 ? bit(0) : 0);  // chatters at the limit
    machine.run(1);
    told += machine.told(Fault::kTorqueSaturated);
  }
  EXPECT_EQ(told, 1);
  machine.set(Fault::kTorqueSaturated, 0);
  machine.run(1100);
  machine.set(Fault::kTorqueSaturated, bit(0));
  machine.run(1);
  EXPECT_EQ(machine.told(Fault::kTorqueSaturated), 1);
  EXPECT_EQ(machine.state(), kActive);
}

TEST(Supervisor, MoreEventsThanFitAreToldLater) {
  Machine machine;
  machine.options.joints = first(kMaxJoints);
  machine.flags.fresh = ~BitSet{0};
  const auto run = [&machine](int steps) {
    for (int i = 0; i < steps; ++i) {
      const bool enable = machine.state() == kEnabling || makes_torque(machine.state());
      machine.flags.enabled = enable ? ~BitSet{0} : 0;
      machine.flags.disabled = enable ? 0 : ~BitSet{0};
      machine.step();
    }
  };
  run(200);
  ASSERT_EQ(machine.state(), kActive);
  machine.set(Fault::kNotFinite, ~BitSet{0});
  run(1);
  EXPECT_EQ(machine.decision.events, kMaxEventsPerCycle);
  EXPECT_EQ(machine.state(), kLowering);
  run(1);
  EXPECT_EQ(machine.decision.events, kMaxJoints - kMaxEventsPerCycle);
  run(1);
  EXPECT_EQ(machine.decision.events, 0u);
}

}  // namespace
}  // namespace geodesic::control
