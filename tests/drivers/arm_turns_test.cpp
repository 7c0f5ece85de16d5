// Turns that a drive forgets while it is off: the arm finds them by the start band, refuses what it
// cannot know, and leaves them alone while the drive was not off.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <utility>

#include "drivers/arm.hpp"
#include "drivers/families.hpp"
#include "rt/clock.hpp"
#include "tests/drivers/fake_bus.hpp"

namespace geodesic::drivers::test {
namespace {

using control::ArmState;
using control::DriveCondition;
using control::DriveMode;

constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr double kCode = 2.0 * 12.5 / 65535.0;

/// One joint at half the drive's speed, reversed; its drive knows the angle within one turn.
class Turns {
 public:
  Turns(double lower, double upper, double start) {
    ArmOptions options;
    options.buses.resize(1);
    JointOptions joint;
    joint.name = "elbow";
    joint.direction = -1.0;
    joint.ratio = 0.5;
    joint.offset = 0.2;
    joint.start_lower = lower;
    joint.start_upper = upper;
    joint.drive.family = "damiao";
    joint.drive.id = 1;
    joint.drive.reply_id = 0x11;
    joint.drive.position_range_rad = 12.5;
    joint.drive.velocity_range_rad_s = 30.0;
    joint.drive.torque_range_nm = 10.0;
    joint.drive.watchdog_ns = 10'000'000'000;  // this machine may pause
    options.joints = {joint};
    std::unique_ptr<SimulatedDrive> made = find_family("damiao")->make_simulated(joint.drive);
    drive = made.get();
    wire.drives.push_back(std::move(made));
    move(start);
    drive->power_cycle();
    std::vector<std::unique_ptr<Bus>> buses;
    buses.push_back(std::make_unique<FakeBus>(wire));
    arm = std::make_unique<Arm>(options, std::move(buses));
  }

  void move(double joint) { drive->set_shaft((joint - 0.2) / -0.5, 0.0); }

  const ArmState& run(int cycles) {
    const ArmState* state = nullptr;
    for (int i = 0; i < cycles; ++i) {
      arm->transmit(command, rt::now_ns());
      state = &arm->receive(rt::now_ns(), rt::now_ns() + 20'000'000);
    }
    return *state;
  }

  FakeWire wire;
  SimulatedDrive* drive = nullptr;
  control::ArmCommand command{.joints = 1, .joint = {}};
  std::unique_ptr<Arm> arm;
};

TEST(ArmTurns, TheBandSaysInWhichTurnTheDriveWasSwitchedOn) {
  for (const double start : {-4.1, -1.3, 0.2, 1.7, 5.5}) {
    Turns bench(start - 0.7, start + 0.8, start);
    const ArmState& state = bench.run(30);
    EXPECT_EQ(state.joint[0].condition, DriveCondition::kDisabled) << start;
    EXPECT_NEAR(state.joint[0].position, start, kCode) << start;
  }
}

TEST(ArmTurns, OutsideTheBandIsRefusedAndSaysWhere) {
  Turns bench(-0.5, 0.5, 1.9);  // and a turn of the drive is half a turn here
  const ArmState& state = bench.run(30);
  EXPECT_EQ(state.joint[0].condition, DriveCondition::kRefused);
  const DriveComplaint& complaint = bench.arm->complaint(0);
  EXPECT_NEAR(std::remainder(complaint.found - 1.9, 0.5 * kTurn), 0.0, kCode);
  EXPECT_NE(std::string(complaint.fix).find("start_lower"), std::string::npos);
  bench.command.joint[0].mode = DriveMode::kEnable;
  EXPECT_EQ(bench.run(50).joint[0].condition, DriveCondition::kRefused);
}

TEST(ArmTurns, AnAmbiguousBandIsRefused) {
  Turns bench(-4.0, 4.0, 0.3);
  EXPECT_EQ(bench.run(30).joint[0].condition, DriveCondition::kRefused);
  EXPECT_NE(std::string(bench.arm->complaint(0).fix).find("more than one turn"), std::string::npos);
}

TEST(ArmTurns, ARestartKeepsTheTurnsOfADriveThatWasNotOff) {
  Turns bench(-1.0, 1.0, 0.8);
  bench.run(30);
  for (double joint = 0.8; joint < 3.0; joint += 0.2) {  // out of the band, by hand
    bench.move(joint);
    bench.run(1);
  }
  bench.arm->restart();
  const ArmState& state = bench.run(30);
  EXPECT_EQ(state.joint[0].condition, DriveCondition::kDisabled);
  EXPECT_NEAR(state.joint[0].position, 2.8, 0.21);
}

TEST(ArmTurns, ADriveThatLostItsTurnsIsFoundAgain) {
  Turns bench(-1.0, 1.0, 0.8);
  bench.run(30);
  for (double joint = 0.8; joint < 2.7; joint += 0.2) {
    bench.move(joint);
    bench.run(1);
  }
  bench.drive->power_cycle();  // so fast that nobody noticed the silence
  bench.arm->restart();
  const ArmState& state = bench.run(30);
  // 2.6 at the joint can be 2.6 - pi as well, and only that lies in the band.
  EXPECT_EQ(state.joint[0].condition, DriveCondition::kDisabled);
  EXPECT_NEAR(state.joint[0].position, 2.6 - 0.5 * kTurn, 0.01);
}

}  // namespace
}  // namespace geodesic::drivers::test
