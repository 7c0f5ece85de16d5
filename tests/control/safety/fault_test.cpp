// Every fault leads where the table says, from every state it is looked for in; and no sequence of
// flags whatever makes torque where there must be none.
#include <gtest/gtest.h>

#include <random>

#include "control/safety/supervisor.hpp"
#include "tests/control/safety/machine.hpp"

namespace geodesic::control {
namespace {

using testing::kAll;
using testing::kJoints;
using testing::Machine;
using enum SupervisorState;

/// Makes `fault` true on subject 0, by whatever means it is found.
void provoke(Machine& machine, Fault fault) {
  switch (fault) {
    case Fault::kJointSilent:
      machine.flags.fresh = kAll & ~bit(0);
      machine.memory.silent[0] = 1000;
      break;
    case Fault::kDriveError:
      machine.flags.error = bit(0);
      break;
    case Fault::kDriveRefused:
      machine.flags.refused = bit(0);
      break;
    case Fault::kDriveDisabled:
      machine.flags.enabled &= ~bit(0);
      break;
    case Fault::kOverrun:
      machine.flags.overran = true;
      machine.memory.overruns = 1000;
      break;
    case Fault::kConnectTimeout:
    case Fault::kEnableTimeout:
      machine.flags.fresh = kAll & ~bit(0);
      machine.memory.silent[0] = 0;
      machine.memory.answers[0] = 0;
      machine.now_ns += 10'000'000'000;
      break;
    case Fault::kNotAtRest:
      machine.flags.moving = bit(0);
      break;
    case Fault::kStartOutsideLimits:
      machine.flags.outside = bit(0);
      break;
    default:
      machine.set(fault, bit(0));
  }
}

SupervisorState expected_after(Action action, SupervisorState from) {
  if (action < Action::kControlledStop) {
    return from;
  }
  if (!makes_torque(from) || action == Action::kTorqueOff) {
    return kFault;
  }
  if (action == Action::kDriveDamping || from == kLowering) {
    return kLowering;
  }
  return kStopping;
}

/// A machine in `state`, in the middle of it.
Machine machine_in(SupervisorState state) {
  Machine machine;
  if (state == kStopping || state == kLowering) {
    machine.run_until(kActive);
    machine.run(300);
    machine.flags.stop_requested = true;
  }
  EXPECT_GE(machine.run_until(state), 0);
  if (state == kActive) {
    machine.run(300);
  }
  return machine;
}

TEST(Fault, LeadsToItsActionFromEveryStateAndEndsInFault) {
  for (std::size_t i = 0; i < kFaults; ++i) {
    const FaultPolicy& line = policy(static_cast<Fault>(i));
    for (const SupervisorState from :
         {kConnecting, kReady, kEnabling, kActive, kStopping, kLowering}) {
      if (!has(line.states, static_cast<std::size_t>(from)) ||
          (line.fault == Fault::kDriveError && from == kConnecting)) {
        continue;  // the error at connecting has a test of its own
      }
      SCOPED_TRACE(std::string(line.name) + " in " + to_string(from));
      Machine machine = machine_in(from);
      const double authority = machine.memory.authority;
      machine.obey();
      provoke(machine, line.fault);
      machine.step();
      EXPECT_GE(machine.told(line.fault), 1);
      EXPECT_LE(machine.memory.authority, authority + 0.0011);
      if (line.action < Action::kControlledStop) {
        EXPECT_TRUE(machine.state() == from || machine.state() == kReady ||
                    (from == kConnecting && machine.state() == kConnecting) ||
                    (from == kEnabling && machine.state() == kActive));
        continue;
      }
      EXPECT_EQ(machine.state(), expected_after(line.action, from));
      if (line.action == Action::kDriveDamping && makes_torque(from)) {
        EXPECT_TRUE(machine.memory.drives_only);
        EXPECT_EQ(machine.memory.authority, 0.0);
      }
      // The condition goes away; the fault does not.
      machine.flags = Flags{};
      machine.flags.fresh = kAll;
      EXPECT_GE(machine.run_until(kFault), 0);
      EXPECT_EQ(machine.run(10'000), kFault);
      EXPECT_EQ(drive_mode(machine.memory, 0, DriveCondition::kEnabled), DriveMode::kDisable);
      machine.flags.stop_requested = true;
      EXPECT_EQ(machine.run(10), kFault);
      // Only an operator's request begins anew, from the beginning.
      machine.flags.law_requested = true;
      machine.step();
      EXPECT_EQ(machine.state(), kConnecting);
      EXPECT_TRUE(machine.decision.restart_drives);
      EXPECT_GE(machine.run_until(kActive), 0);
    }
  }
}

TEST(Fault, WorstOfSeveralWins) {
  Machine machine = machine_in(kActive);
  machine.set(Fault::kVelocityLimit, bit(0));
  machine.set(Fault::kEncoderJump, bit(1));
  machine.set(Fault::kTemperatureWarn, kAll);
  EXPECT_EQ(machine.run(1), kLowering);
  EXPECT_EQ(worst_action(machine.options, machine.memory), Action::kDriveDamping);
  EXPECT_EQ(machine.decision.events, 2u + kJoints);
}

TEST(Fault, AWorseOneTakesOverAStop) {
  Machine machine = machine_in(kStopping);
  machine.set(Fault::kNotFinite, bit(2));
  EXPECT_EQ(machine.run(1), kLowering);
  EXPECT_TRUE(machine.memory.drives_only);
  EXPECT_EQ(machine.run_until(kFault), 3000);  // lowered, then settled: no rest is believed
}

TEST(Fault, IsNotLookedForInOffAndFault) {
  Machine machine;
  machine.options.start_active = false;
  machine.flags.present.fill(~BitSet{0});
  EXPECT_EQ(machine.run(100), kOff);
  EXPECT_EQ(machine.decision.events, 0u);
}

// Flags at random, for long: what must never happen never does.
TEST(Fault, NoSequenceOfFlagsBreaksTheInvariants) {
  std::mt19937 random(7);
  const auto chance = [&random](unsigned one_in) { return random() % one_in == 0; };
  int reached_active = 0;
  for (int run = 0; run < 300; ++run) {
    Machine machine;
    machine.options.start_active = run % 2 == 0;
    const unsigned one_in = 20u << (run % 8);  // from a storm to a calm
    int rested = 0;
    for (int step = 0; step < 3000; ++step) {
      machine.obey();
      Flags& flags = machine.flags;
      const auto joint = [&random]() { return bit(random() % kJoints); };
      flags.fresh = chance(one_in) ? kAll & ~joint() : kAll;
      flags.moving = chance(one_in) ? joint() : 0;
      flags.unrested = flags.moving;
      flags.outside = chance(one_in) ? joint() : 0;
      flags.error = chance(8 * one_in) ? joint() : 0;
      flags.refused = chance(8 * one_in) ? joint() : 0;
      flags.enabled &= chance(8 * one_in) ? ~joint() : ~BitSet{0};
      flags.overran = chance(3);
      flags.law_requested = chance(300);
      flags.stop_requested = chance(800);
      flags.present.fill(0);
      for (std::size_t i = 0; i < kFaults; ++i) {
        flags.present[i] = chance(64 * one_in) ? joint() : 0;
      }
      const SupervisorMemory before = machine.memory;
      const Flags seen = flags;
      rested = seen.moving == 0 ? rested + 1 : 0;
      machine.step();
      const SupervisorState from = before.state;
      const SupervisorState to = machine.state();

      // Torque only where torque may be, and active only from enabling.
      ASSERT_TRUE(makes_torque(to) || machine.memory.authority == 0.0);
      ASSERT_GE(machine.memory.authority, 0.0);
      ASSERT_LE(machine.memory.authority, 1.0);
      if (to == kActive && from != kActive) {
        ++reached_active;
        ASSERT_EQ(from, kEnabling);
        ASSERT_EQ(seen.fresh & seen.enabled & kAll, kAll);
        ASSERT_EQ((seen.moving | seen.outside) & kAll, 0u);
        ASSERT_EQ(machine.memory.authority, 0.0);
      }
      if (to == kEnabling && from != kEnabling) {
        ASSERT_EQ(from, kReady);
        ASSERT_GE(rested, 100);
        ASSERT_EQ(seen.fresh & seen.disabled & kAll, kAll);
        ASSERT_EQ(seen.outside & kAll, 0u);
      }
      if (to == kConnecting && from != kConnecting) {
        ASSERT_TRUE(from == kOff || from == kFault);
        ASSERT_TRUE(seen.law_requested || !before.start_done);
      }
      if (from == kFault && to != kFault) {
        ASSERT_EQ(to, kConnecting);
        ASSERT_TRUE(seen.law_requested);
      }
      // No way down ends in off if there was a fault.
      if (to == kOff && from == kLowering) {
        ASSERT_LT(worst_action(machine.options, machine.memory), Action::kControlledStop);
      }
      // After active, authority only falls.
      if (from != kActive && makes_torque(from) && makes_torque(to)) {
        ASSERT_LE(machine.memory.authority, before.authority);
      }
      // Torque goes at once to nothing only on purpose: encoders not trusted, or lowered to zero.
      if (makes_torque(from) && !makes_torque(to)) {
        ASSERT_EQ(from, kLowering);
      }
      ASSERT_LE(machine.decision.events, kMaxEventsPerCycle);
    }
  }
  EXPECT_GT(reached_active, 100);
}

}  // namespace
}  // namespace geodesic::control
