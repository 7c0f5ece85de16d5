// The arm on two buses in memory, its drives simulated: conversion, routing, waiting, losses.
#include "drivers/arm.hpp"

#include <gtest/gtest.h>

#include <unistd.h>

#include <cmath>
#include <utility>

#include "drivers/families.hpp"
#include "rt/clock.hpp"
#include "rt/thread_health.hpp"
#include "tests/drivers/fake_bus.hpp"

namespace geodesic::drivers::test {
namespace {

using control::ArmCommand;
using control::ArmState;
using control::DriveCondition;
using control::DriveMode;

constexpr std::int64_t kWaitNs = 20'000'000;

JointOptions joint(const char* name, std::size_t bus, std::uint32_t id, double direction = 1.0,
                   double ratio = 1.0, double offset = 0.0) {
  JointOptions options;
  options.name = name;
  options.bus = bus;
  options.drive.family = "damiao";
  options.drive.id = id;
  options.drive.reply_id = id + 0x10;
  options.drive.position_range_rad = 12.5;
  options.drive.velocity_range_rad_s = 30.0;
  options.drive.torque_range_nm = 10.0;
  options.drive.watchdog_ns = 10'000'000'000;  // this machine may pause
  options.direction = direction;
  options.ratio = ratio;
  options.offset = offset;
  return options;
}

/// Two buses; on them straight and reversed joints, one with a gear, one of metres.
ArmOptions two_buses() {
  ArmOptions options;
  options.buses.resize(2);
  options.buses[0].name = "left";
  options.buses[1].name = "right";
  options.joints = {joint("a", 0, 1), joint("b", 1, 1, -1.0, 1.0, 0.3),
                    joint("c", 0, 2, -1.0, 0.5, -0.7), joint("d", 1, 7, 1.0, 0.02, 0.01)};
  return options;
}

class Arms : public ::testing::Test {
 protected:
  explicit Arms(ArmOptions with = two_buses()) : options(std::move(with)) {
    std::vector<std::unique_ptr<Bus>> buses;
    for (std::size_t bus = 0; bus < options.buses.size(); ++bus) {
      buses.push_back(std::make_unique<FakeBus>(wires[bus]));
    }
    for (const JointOptions& one : options.joints) {
      std::unique_ptr<SimulatedDrive> made = find_family("damiao")->make_simulated(one.drive);
      drives.push_back(made.get());
      wires[one.bus].drives.push_back(std::move(made));
    }
    arm = std::make_unique<Arm>(options, std::move(buses));
    command.joints = options.joints.size();
  }

  const ArmState& cycle(std::int64_t wait_ns = kWaitNs) {
    tick_ns = options.simulated_time ? tick_ns + 1'000'000 : rt::now_ns();
    arm->transmit(command, tick_ns);
    return arm->receive(tick_ns, rt::now_ns() + wait_ns);
  }

  void all(DriveMode mode) {
    for (control::JointCommand& one : command.joint) {
      one.mode = mode;
    }
  }

  void enable_all() {
    all(DriveMode::kEnable);
    for (int i = 0; i < 200; ++i) {
      const ArmState& state = cycle();
      bool enabled = true;
      for (std::size_t j = 0; j < options.joints.size(); ++j) {
        enabled = enabled && state.joint[j].condition == DriveCondition::kEnabled;
      }
      if (enabled) {
        return;
      }
    }
    FAIL() << "the drives were not enabled";
  }

  ArmOptions options;
  std::array<FakeWire, 2> wires;
  std::vector<SimulatedDrive*> drives;
  std::unique_ptr<Arm> arm;
  ArmCommand command;
  std::int64_t tick_ns = 0;
};

TEST_F(Arms, SendsWhatWasPreparedAndNothingElse) {
  enable_all();
  const ArmCommand holding = command;
  ArmCommand pulling = command;
  pulling.joint.fill({DriveMode::kEnable, 1.0, 0.0, 0.0, 0.0, 0.0});
  wires[0].sent.clear();
  arm->transmit(holding, rt::now_ns());
  const std::vector<Frame> as_it_comes = wires[0].sent;
  arm->receive(rt::now_ns(), rt::now_ns() + kWaitNs);

  wires[0].sent.clear();
  arm->prepare(holding, rt::now_ns());
  EXPECT_TRUE(wires[0].sent.empty());
  arm->transmit(pulling, rt::now_ns());
  ASSERT_EQ(wires[0].sent.size(), as_it_comes.size());
  for (std::size_t i = 0; i < as_it_comes.size(); ++i) {
    EXPECT_EQ(wires[0].sent[i].id, as_it_comes[i].id);
    EXPECT_EQ(wires[0].sent[i].data, as_it_comes[i].data);
  }
  arm->receive(rt::now_ns(), rt::now_ns() + kWaitNs);
  wires[0].sent.clear();
  arm->transmit(pulling, rt::now_ns());  // nothing is prepared any more
  EXPECT_NE(wires[0].sent[0].data, as_it_comes[0].data);
}

TEST_F(Arms, ConfiguresEnablesAndReportsEveryJoint) {
  enable_all();
  const ArmState& state = cycle();
  EXPECT_EQ(state.joints, 4U);
  EXPECT_EQ(state.buses, 2U);
  EXPECT_EQ(state.tick_ns, tick_ns);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_TRUE(state.joint[i].fresh);
    EXPECT_TRUE(drives[i]->enabled());
    EXPECT_GE(state.joint[i].stamp_ns, tick_ns);
    EXPECT_EQ(arm->joint_counters(i).lost, 0U);
    EXPECT_EQ(arm->joint_counters(i).sent, arm->joint_counters(i).received);
    EXPECT_EQ(arm->complaint(i).quantity, nullptr);
  }
  EXPECT_EQ(arm->joints(), 4U);
  EXPECT_EQ(arm->buses(), 2U);
  EXPECT_EQ(arm->bus_counters(0).sent, arm->joint_counters(0).sent + arm->joint_counters(2).sent);
}

TEST_F(Arms, RefusesAJointThatTwoDrivesAnswerFor) {
  enable_all();
  // One link that doubles a frame now and then does not count as a second drive.
  for (int i = 0; i < 400; ++i) {
    wires[0].double_id = i % 5 == 0 ? 0x11U : 0U;
    ASSERT_EQ(cycle().joint[0].condition, DriveCondition::kEnabled) << i;
  }
  wires[0].double_id = 0x11;
  int cycles = 0;
  while (cycle().joint[0].condition != DriveCondition::kRefused && cycles < 100) ++cycles;
  EXPECT_LT(cycles, 50);
  ASSERT_NE(arm->complaint(0).quantity, nullptr);
  EXPECT_STREQ(arm->complaint(0).quantity, "answers to one command");
  EXPECT_EQ(cycle().joint[2].condition, DriveCondition::kEnabled) << "its neighbour is not blamed";
  wires[0].double_id = 0;
  EXPECT_EQ(cycle().joint[0].condition, DriveCondition::kRefused) << "not before restart()";
  arm->restart();
  all(DriveMode::kMonitor);
  for (int i = 0; i < 100; ++i) cycle();
  EXPECT_EQ(arm->complaint(0).quantity, nullptr);
  enable_all();
}

TEST_F(Arms, TurnsJointsIntoDrivesAndBack) {
  enable_all();
  for (std::size_t i = 0; i < 4; ++i) {
    const double scale = options.joints[i].direction * options.joints[i].ratio;
    drives[i]->set_shaft(0.5, 2.0);
    control::JointCommand& wanted = command.joint[i];
    // Chosen so that every drive gets torque 1, stiffness 10 towards 0.7, damping 1 towards 1.
    wanted.torque = 1.0 / scale;
    wanted.position = scale * 0.7 + options.joints[i].offset;
    wanted.velocity = scale * 1.0;
    wanted.stiffness = 10.0 / (scale * scale);
    wanted.damping = 1.0 / (scale * scale);
  }
  cycle();
  const ArmState& state = cycle();
  for (std::size_t i = 0; i < 4; ++i) {
    const double scale = options.joints[i].direction * options.joints[i].ratio;
    const double torque = 1.0 + 10.0 * 0.2 - 1.0 * 1.0;
    EXPECT_NEAR(drives[i]->torque_nm(rt::now_ns()), torque, 0.03);
    EXPECT_NEAR(state.joint[i].position, scale * 0.5 + options.joints[i].offset, 4e-4);
    EXPECT_NEAR(state.joint[i].velocity, scale * 2.0, 0.015);
    EXPECT_NEAR(state.joint[i].torque * scale, torque, 0.03);
    EXPECT_NEAR(state.joint[i].torque * state.joint[i].velocity, torque * 2.0, 0.1);  // power
  }
}

TEST_F(Arms, SendsOneBatchABus) {
  cycle();
  EXPECT_EQ(wires[0].sends, 1U);
  EXPECT_EQ(wires[1].sends, 1U);
  EXPECT_EQ(wires[0].sent.size(), 2U);
  EXPECT_LE(wires[0].receives, 2U);
}

TEST_F(Arms, ASilentJointIsLostOnceACycleAndKeepsNoOneElse) {
  enable_all();
  wires[0].mute_id = 0x12;
  const std::int64_t before = rt::now_ns();
  const ArmState& state = cycle(5'000'000);
  EXPECT_GE(rt::now_ns() - before, 5'000'000);
  EXPECT_FALSE(state.joint[2].fresh);
  EXPECT_TRUE(state.joint[0].fresh && state.joint[1].fresh && state.joint[3].fresh);
  EXPECT_EQ(arm->joint_counters(2).lost, 1U);
  EXPECT_LT(state.joint[2].stamp_ns, tick_ns);
  cycle(1'000'000);
  EXPECT_EQ(arm->joint_counters(2).lost, 2U);
  wires[0].mute_id = 0;
  EXPECT_TRUE(cycle().joint[2].fresh);
  EXPECT_EQ(arm->joint_counters(2).lost, 2U);
}

TEST_F(Arms, ADoubledReplyDoesNotCountForAnotherJoint) {
  enable_all();
  wires[0].mute_id = 0x12;
  wires[0].double_id = 0x11;
  const std::int64_t before = rt::now_ns();
  const ArmState& state = cycle(5'000'000);
  EXPECT_GE(rt::now_ns() - before, 5'000'000);  // it was waited for
  EXPECT_FALSE(state.joint[2].fresh);
  EXPECT_EQ(arm->joint_counters(2).lost, 1U);
  EXPECT_EQ(arm->joint_counters(0).lost, 0U);
}

TEST_F(Arms, ALateReplyIsNewsButNotThisCyclesAnswer) {
  enable_all();
  drives[0]->set_shaft(1.0, 0.0);
  wires[0].hold_id = 0x11;
  cycle(1'000'000);
  const std::int64_t cut_ns = rt::now_ns();
  EXPECT_EQ(arm->joint_counters(0).lost, 1U);
  wires[0].hold_id = 0;
  wires[0].mute_id = 0x11;
  wires[0].release();
  const ArmState& state = cycle(2'000'000);
  EXPECT_NEAR(state.joint[0].position, 1.0, 4e-4);
  EXPECT_LT(state.joint[0].stamp_ns, cut_ns);
  EXPECT_TRUE(state.joint[0].fresh);
  EXPECT_EQ(arm->joint_counters(0).lost, 2U);
}

TEST_F(Arms, AStalledBusOwesNoReplies) {
  enable_all();
  const std::uint64_t sent = arm->joint_counters(0).sent;
  wires[0].stalled = true;
  const std::int64_t before = rt::now_ns();
  const ArmState& state = cycle(500'000'000);
  EXPECT_LT(rt::now_ns() - before, 400'000'000);
  EXPECT_TRUE(state.bus[0].stalled);
  EXPECT_FALSE(state.bus[1].stalled);
  EXPECT_FALSE(state.joint[0].fresh);
  EXPECT_TRUE(state.joint[1].fresh);
  EXPECT_EQ(arm->joint_counters(0).lost, 0U);
  EXPECT_EQ(arm->joint_counters(0).sent, sent);
}

TEST_F(Arms, ABusThatIsGoneIsNotWaitedFor) {
  enable_all();
  wires[0].mute_id = 0x12;
  std::array<int, 2> ends{};
  ASSERT_EQ(pipe(ends.data()), 0);
  close(ends[1]);
  close(std::exchange(wires[0].descriptor, ends[0]));  // polls as hung up
  const std::int64_t before = rt::now_ns();
  const ArmState& state = cycle(500'000'000);
  EXPECT_LT(rt::now_ns() - before, 400'000'000);
  EXPECT_TRUE(state.joint[1].fresh);
}

TEST_F(Arms, StrangersAndErrorFramesAreIgnored) {
  enable_all();
  Frame frame;
  frame.length = 8;
  for (const std::uint32_t id : {0x000U, 0x001U, 0x013U, 0x7FEU}) {
    frame.id = id;
    wires[0].put({frame, rt::now_ns()});
  }
  frame.id = 0x11;
  frame.extended = true;
  wires[0].put({frame, rt::now_ns()});
  frame.extended = false;
  frame.error = true;
  wires[0].put({frame, rt::now_ns()});
  const std::uint64_t received = arm->joint_counters(0).received;
  EXPECT_TRUE(cycle().joint[0].fresh);
  EXPECT_EQ(arm->joint_counters(0).received, received + 1);
}

TEST_F(Arms, AFloodIsReadInBoundedTime) {
  enable_all();
  Frame frame;
  frame.id = 0x3FF;
  for (std::size_t i = 0; i < wires[0].queue.size() - 10; ++i) {
    wires[0].put({frame, rt::now_ns()});
  }
  const ArmState& state = cycle();
  EXPECT_TRUE(state.joint[0].fresh && state.joint[2].fresh);
}

TEST_F(Arms, ReceivingWithoutSendingWaitsForNothing) {
  enable_all();
  const std::int64_t before = rt::now_ns();
  arm->receive(before, before + 500'000'000);
  EXPECT_LT(rt::now_ns() - before, 400'000'000);
  EXPECT_EQ(arm->joint_counters(0).lost, 0U);
}

TEST_F(Arms, JointsBeyondTheCommandAreMonitored) {
  enable_all();
  command.joints = 1;
  for (int i = 0; i < 5; ++i) {
    cycle();
  }
  EXPECT_TRUE(drives[0]->enabled());
  EXPECT_FALSE(drives[1]->enabled() || drives[2]->enabled() || drives[3]->enabled());
}

TEST_F(Arms, NumbersThatAreNotFiniteNeverReachADrive) {
  enable_all();
  command.joint[2].torque = std::nan("");
  cycle();
  EXPECT_NEAR(drives[2]->torque_nm(rt::now_ns()), 0.0, 0.01);
  EXPECT_NE(arm->complaint(2).quantity, nullptr);
  EXPECT_EQ(arm->complaint(0).quantity, nullptr);
}

TEST_F(Arms, ADrivesErrorAndItsRestartAreSeen) {
  enable_all();
  drives[3]->inject_error(10);
  const ArmState& state = cycle();
  EXPECT_EQ(state.joint[3].condition, DriveCondition::kError);
  EXPECT_EQ(state.joint[3].drive_error, 10);
  drives[3]->power_cycle();
  all(DriveMode::kMonitor);
  arm->restart();
  for (int i = 0; i < 50; ++i) {
    cycle();
  }
  EXPECT_EQ(state.joint[3].condition, DriveCondition::kDisabled);
  EXPECT_EQ(state.joint[3].drive_error, 0);
}

TEST_F(Arms, NeverAllocatesOnceBuilt) {
  rt::RealtimeGuard guard;
  enable_all();
  wires[0].mute_id = 0x12;
  cycle(1'000'000);
  all(DriveMode::kDisable);
  for (int i = 0; i < 10; ++i) {
    cycle(1'000'000);
  }
  arm->restart();
  cycle(1'000'000);
  const rt::ThreadHealth seen = guard.seen();
  EXPECT_EQ(seen.allocations, 0U) << to_string(seen);
}

class SimulatedTimeArms : public Arms {
 protected:
  static ArmOptions simulated() {
    ArmOptions with = two_buses();
    with.simulated_time = true;
    return with;
  }
  SimulatedTimeArms() : Arms(simulated()) {}
};

TEST_F(SimulatedTimeArms, StampsWithTheTickAndWaitsBeyondTheDeadline) {
  enable_all();
  const ArmState& state = cycle(-1);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_TRUE(state.joint[i].fresh);
    EXPECT_EQ(state.joint[i].stamp_ns, tick_ns);
  }
}

TEST_F(SimulatedTimeArms, DoNotWaitForADriveButForTheTickOneSecondAtMost) {
  enable_all();
  wires[0].mute_id = 0x12;
  const std::int64_t before = rt::now_ns();
  EXPECT_FALSE(cycle().joint[2].fresh);
  EXPECT_LT(rt::now_ns() - before, 1'000'000'000);
  wires[0].mute_id = kTickId;
  cycle();
  EXPECT_GE(rt::now_ns() - before, 1'000'000'000);
}

}  // namespace
}  // namespace geodesic::drivers::test
