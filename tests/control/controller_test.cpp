// The controller as a whole, against drives that obey: starts, stops, laws, faults and commands.
#include "control/controller.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "control/mechanism/gravity.hpp"
#include "control/mechanism/workspace.hpp"
#include "tests/control/planar_arm.hpp"

namespace geodesic::control {
namespace {

using testing::Bench;
using testing::kPeriod;
using testing::planar_mechanism;
using testing::planar_options;
using enum SupervisorState;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

Eigen::VectorXd gravity_torque(double q) {
  const Mechanism mechanism = planar_mechanism();
  Workspace workspace(mechanism);
  return gravity(mechanism, workspace, Eigen::VectorXd(Eigen::Vector2d(q, q)));
}

TEST(Controller, RefusesJointsThatNoDriveCanMove) {
  TreeDescription tree = testing::planar_tree();
  tree.joints.back().kind = JointKind::kSpherical;
  try {
    Controller(Mechanism(tree, Eigen::Vector3d::Zero()), planar_options());
    FAIL() << "accepted";
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("'" + tree.joints.back().name + "' is spherical"),
              std::string::npos)
        << error.what();
  }
}

TEST(Controller, RefusesOptionsThatDoNotFit) {
  ControllerOptions options = planar_options();
  options.joints.pop_back();
  EXPECT_THROW(Controller(planar_mechanism(), options), std::invalid_argument);
  options = planar_options();
  std::swap(options.joints[0], options.joints[1]);
  EXPECT_THROW(Controller(planar_mechanism(), options), std::invalid_argument);
  options = planar_options();
  options.joints[0].damping = kNan;
  try {
    const Controller controller(planar_mechanism(), options);
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("joint 'joint1': damping"), std::string::npos);
  }
}

TEST(Controller, StartRampsTheModelsTorqueInAndNeverExceedsIt) {
  Bench bench;
  const Eigen::VectorXd needed = gravity_torque(0.3);
  ASSERT_TRUE(bench.run_until(kActive));
  EXPECT_EQ(bench.command.joint[0].torque, 0.0);
  EXPECT_EQ(bench.command.joint[0].position, 0.3);  // the measured pose
  double last = 0.0;
  for (int i = 0; i < 1000; ++i) {
    bench.cycle();
    const double torque = bench.command.joint[0].torque;
    EXPECT_LE(std::abs(torque), std::abs(needed[0]) + 1e-12);
    EXPECT_LE(std::abs(bench.command.joint[1].torque), std::abs(needed[1]) + 1e-12);
    EXPECT_GE(torque, last);
    last = torque;
  }
  EXPECT_NEAR(bench.command.joint[0].torque, needed[0], 1e-9);
  EXPECT_NEAR(bench.report().model_torque[1], needed[1], 1e-9);
  EXPECT_EQ(bench.report().authority, 1.0);
}

/// The model's torque of a moving arm that is compensated so far.
Eigen::Vector2d moving_torque(double coriolis) {
  ControllerOptions options = planar_options();
  options.coriolis = coriolis;
  Bench bench(options);
  EXPECT_TRUE(bench.run_until(kActive));
  for (int i = 0; i < 200; ++i) {
    for (std::size_t k = 0; k < 2; ++k) {
      JointState& joint = bench.arm.state.joint[k];
      joint.velocity = k == 0 ? 0.7 : -1.1;
      joint.position += joint.velocity * 1e-9 * static_cast<double>(kPeriod);
    }
    bench.cycle();
  }
  EXPECT_EQ(bench.state(), kActive);
  return {bench.report().model_torque[0], bench.report().model_torque[1]};
}

TEST(Controller, CompensatesTheChosenShareOfTheCoriolisTorque) {
  const Eigen::Vector2d none = moving_torque(0.0);
  const Eigen::Vector2d some = moving_torque(0.3);
  const Eigen::Vector2d all = moving_torque(1.0);
  // The textbook's 2R arm: h = m2 l1 lc2 sin(q2); -h (2 v1 v2 + v2^2) and h v1^2.
  const double ahead_s = 1e-9 * 1.5 * static_cast<double>(kPeriod);
  const double h = 2.0 * 0.5 * 0.25 * std::sin(0.3 - 1.1 * (0.2 + ahead_s));
  EXPECT_NEAR(all[0] - none[0], -h * (2.0 * 0.7 * -1.1 + 1.1 * 1.1), 1e-4);
  EXPECT_NEAR(all[1] - none[1], h * 0.7 * 0.7, 1e-4);
  EXPECT_NEAR((some - (none + 0.3 * (all - none))).norm(), 0.0, 1e-12);
}

TEST(Controller, CommandsFollowTheState) {
  Bench bench;
  bench.cycle();
  EXPECT_EQ(bench.state(), kConnecting);
  EXPECT_TRUE(bench.report().restart_drives);
  EXPECT_EQ(bench.command.joint[0].mode, DriveMode::kMonitor);
  ASSERT_TRUE(bench.run_until(kEnabling));
  EXPECT_EQ(bench.command.joint[0].mode, DriveMode::kEnable);
  EXPECT_EQ(bench.command.joint[0].torque, 0.0);
  ASSERT_TRUE(bench.run_until(kActive));
  for (int i = 0; i < 1500; ++i) {
    bench.cycle();
  }
  EXPECT_EQ(bench.command.joint[0].damping, 0.0);
  bench.controller.request({Request::Kind::kStop, LawKind::kFloat});
  bench.controller.request({Request::Kind::kLaw, LawKind::kHold});  // does not undo the stop
  bench.cycle();
  EXPECT_EQ(bench.state(), kStopping);
  EXPECT_EQ(bench.command.joint[0].mode, DriveMode::kEnable);
  EXPECT_NEAR(bench.command.joint[0].torque, gravity_torque(0.3)[0], 1e-9);
  ASSERT_TRUE(bench.run_until(kLowering));
  bench.cycle();
  EXPECT_EQ(bench.command.joint[0].damping, 1.5);
  for (int i = 0; i < 499; ++i) {
    bench.cycle();
  }
  EXPECT_NEAR(bench.command.joint[0].torque, 0.5 * gravity_torque(0.3)[0], 1e-2);
  ASSERT_TRUE(bench.run_until(kOff));
  EXPECT_EQ(bench.command.joint[0].mode, DriveMode::kDisable);
  bench.cycle();
  EXPECT_EQ(bench.command.joint[0].mode, DriveMode::kMonitor);  // it has told that it is disabled
  EXPECT_EQ(bench.command.joint[0].torque, 0.0);
}

TEST(Controller, TorqueStaysWithinLimitAndRateAcrossEverything) {
  ControllerOptions options = planar_options();
  options.allow_zero_law = true;
  for (JointTuning& joint : options.joints) {
    joint.torque_limit = 12.0;
    joint.torque_rate_limit = 500.0;
  }
  Bench bench(options);
  ASSERT_TRUE(bench.run_until(kActive));
  std::array<double, 2> last{};
  bool saturated = false;
  const std::array<LawKind, 4> laws{LawKind::kZero, LawKind::kHold, LawKind::kDamp,
                                    LawKind::kFloat};
  for (int i = 0; i < 8000; ++i) {
    if (i % 1000 == 500) {
      bench.controller.request({Request::Kind::kLaw, laws[static_cast<std::size_t>(i / 1000) % 4]});
    }
    bench.arm.state.joint[0].position = 0.3 + 0.2 * std::sin(0.004 * i);
    bench.arm.state.joint[0].velocity = 0.8 * std::cos(0.004 * i);
    bench.cycle();
    ASSERT_EQ(bench.state(), kActive);
    saturated |= bench.raised(Fault::kTorqueSaturated, 0);
    for (std::size_t k = 0; k < 2; ++k) {
      const double torque = bench.command.joint[k].torque;
      ASSERT_LE(std::abs(torque), 12.0);
      ASSERT_LE(std::abs(torque - last[k]), 0.5 + 1e-12);
      last[k] = torque;
    }
  }
  EXPECT_TRUE(saturated);
}

TEST(Controller, HoldIsAboutThePoseAtEntry) {
  Bench bench;
  ASSERT_TRUE(bench.run_until(kActive));
  for (int i = 0; i < 1200; ++i) {
    bench.cycle();
  }
  bench.controller.request({Request::Kind::kLaw, LawKind::kHold});
  bench.cycle();
  EXPECT_EQ(bench.report().law, LawKind::kHold);
  EXPECT_NEAR(bench.command.joint[1].torque, gravity_torque(0.3)[1], 1e-9);  // no jolt
  bench.arm.state.joint[1].position = 0.31;
  for (int i = 0; i < 5; ++i) {
    bench.cycle();
  }
  EXPECT_NEAR(bench.command.joint[1].torque, bench.report().model_torque[1] - 50.0 * 0.01, 1e-9);
}

TEST(Controller, LawZeroIsForSimulationOnly) {
  ControllerOptions options = planar_options();
  options.law = LawKind::kZero;
  EXPECT_THROW(Controller(planar_mechanism(), options), std::invalid_argument);
  Bench bench;
  ASSERT_TRUE(bench.run_until(kActive));
  bench.controller.request({Request::Kind::kLaw, LawKind::kZero});
  bench.cycle();
  EXPECT_EQ(bench.report().law, LawKind::kFloat);
  ASSERT_NE(bench.report().refused, nullptr);
  bench.cycle();
  EXPECT_EQ(bench.report().refused, nullptr);
  bench.controller.request({Request::Kind::kLaw, static_cast<LawKind>(200)});
  bench.cycle();
  EXPECT_NE(bench.report().refused, nullptr);

  options.allow_zero_law = true;
  Bench simulated(options);
  ASSERT_TRUE(simulated.run_until(kActive));
  for (int i = 0; i < 1500; ++i) {
    simulated.cycle();
    ASSERT_EQ(simulated.command.joint[0].torque, 0.0);
  }
}

TEST(Controller, RequestWhileStoppingIsRefused) {
  Bench bench;
  ASSERT_TRUE(bench.run_until(kActive));
  bench.controller.request({Request::Kind::kStop, LawKind::kFloat});
  bench.cycle();
  bench.controller.request({Request::Kind::kLaw, LawKind::kHold});
  bench.cycle();
  EXPECT_NE(bench.report().refused, nullptr);
  ASSERT_TRUE(bench.run_until(kOff));
  bench.controller.request({Request::Kind::kLaw, LawKind::kHold});
  ASSERT_TRUE(bench.run_until(kActive));
  EXPECT_EQ(bench.report().law, LawKind::kHold);
}

TEST(Controller, ASilentJointIsHeldWhereItWasSeen) {
  Bench bench;
  ASSERT_TRUE(bench.run_until(kActive));
  for (int i = 0; i < 1200; ++i) {
    bench.cycle();
  }
  const auto silence = [](ArmState& state) { state.joint[1].fresh = false; };
  for (int i = 0; i < 4; ++i) {
    bench.cycle(silence);
    ASSERT_EQ(bench.state(), kActive);
  }
  bench.cycle(silence);
  EXPECT_EQ(bench.state(), kStopping);
  ASSERT_TRUE(bench.raised(Fault::kJointSilent, 1));
  EXPECT_EQ(bench.report().event[0].found, 5.0);
  EXPECT_EQ(bench.report().event[0].limit, 5.0);
  EXPECT_NEAR(bench.command.joint[1].torque, gravity_torque(0.3)[1], 1e-9);
  EXPECT_EQ(bench.command.joint[1].mode, DriveMode::kEnable);
  EXPECT_EQ(bench.command.joint[1].damping, 1.5);
  for (int i = 0; i < 1200; ++i) {
    bench.cycle(silence);
  }
  EXPECT_EQ(bench.state(), kFault);
}

TEST(Controller, ADriveInErrorIsDisabledAndTheOthersHold) {
  Bench bench;
  ASSERT_TRUE(bench.run_until(kActive));
  for (int i = 0; i < 1200; ++i) {
    bench.cycle();
  }
  bench.arm.state.joint[0].condition = DriveCondition::kError;
  bench.arm.state.joint[0].drive_error = 13;
  bench.cycle();
  EXPECT_EQ(bench.state(), kStopping);
  ASSERT_TRUE(bench.raised(Fault::kDriveError, 0));
  EXPECT_EQ(bench.report().event[0].found, 13.0);
  EXPECT_EQ(bench.command.joint[0].mode, DriveMode::kDisable);
  EXPECT_EQ(bench.command.joint[0].torque, 0.0);
  EXPECT_NEAR(bench.command.joint[1].torque, gravity_torque(0.3)[1], 1e-9);
  ASSERT_TRUE(bench.run_until(kFault));
}

TEST(Controller, AnEncoderThatJumpsLeavesTheDrivesDamping) {
  Bench bench;
  ASSERT_TRUE(bench.run_until(kActive));
  for (int i = 0; i < 1200; ++i) {
    bench.cycle();
  }
  bench.arm.state.joint[0].position = 1.3;
  bench.cycle();
  EXPECT_EQ(bench.state(), kLowering);
  ASSERT_TRUE(bench.raised(Fault::kEncoderJump, 0));
  EXPECT_NEAR(bench.report().event[0].found, 1.0, 1e-12);
  for (int i = 0; i < 900; ++i) {
    bench.cycle();
    ASSERT_EQ(bench.state(), kLowering);
    ASSERT_EQ(bench.command.joint[1].mode, DriveMode::kEnable);
    ASSERT_EQ(bench.command.joint[1].torque, 0.0);
    ASSERT_EQ(bench.command.joint[1].damping, 1.5);
  }
  ASSERT_TRUE(bench.run_until(kFault));
}

TEST(Controller, AModelThatYieldsNoNumberCostsTheTorqueNotTheArm) {
  // Gravity beyond all measure: every input is finite, the torque is not.
  TreeDescription tree = testing::planar_tree();
  tree.links[1].inertia.mass_kg = 1e300;
  tree.links[2].inertia.mass_kg = 1e300;
  Controller controller(Mechanism(tree, Eigen::Vector3d(0.0, -1e300, 0.0)), planar_options());
  testing::ObedientArm arm;
  ArmCommand command;
  bool told = false;
  for (int i = 0; i < 6000; ++i) {
    arm.obey(command);
    command = controller.update(arm.state, kPeriod);
    for (std::size_t k = 0; k < 2; ++k) {
      ASSERT_TRUE(std::isfinite(command.joint[k].torque));
      ASSERT_EQ(command.joint[k].torque, 0.0);
    }
    for (std::size_t k = 0; k < controller.report().events; ++k) {
      told |= controller.report().event[k].fault == Fault::kNotFinite;
    }
  }
  EXPECT_TRUE(told);
  EXPECT_EQ(controller.report().state, kFault);
}

TEST(Controller, StartOutsideLimitsIsRefusedWithTheFigures) {
  Bench bench;
  bench.arm.state.joint[1].position = 2.2;
  ASSERT_TRUE(bench.run_until(kReady));
  bench.cycle();
  ASSERT_TRUE(bench.raised(Fault::kStartOutsideLimits, 1));
  EXPECT_EQ(bench.report().event[0].found, 2.2);
  EXPECT_EQ(bench.report().event[0].limit, 2.0);
  for (int i = 0; i < 2000; ++i) {
    bench.cycle();
  }
  EXPECT_EQ(bench.state(), kReady);
  bench.arm.state.joint[1].position = 1.95;
  EXPECT_TRUE(bench.run_until(kActive, 300));
}

TEST(Controller, FaultsOfAJointCarryTheirFigures) {
  const auto event_of = [](auto disturb) {
    Bench bench;
    EXPECT_TRUE(bench.run_until(kActive));
    disturb(bench.arm.state);
    for (int i = 0; i < 20 && bench.report().events == 0; ++i) {
      bench.cycle();
    }
    return bench.report().event[0];
  };
  FaultEvent event = event_of([](ArmState& state) { state.joint[1].temperature_c = 90.0; });
  EXPECT_EQ(event.fault, Fault::kTemperatureWarn);
  EXPECT_EQ(event.found, 90.0);
  EXPECT_EQ(event.limit, 70.0);
  event = event_of([](ArmState& state) { state.joint[1].velocity = 30.0; });
  EXPECT_EQ(event.fault, Fault::kVelocityLimit);
  EXPECT_EQ(event.limit, 5.0);
  event = event_of([](ArmState& state) { state.bus[0].bus_off = true; });
  EXPECT_EQ(event.fault, Fault::kBusOff);
  EXPECT_EQ(event.bus, 0);
  EXPECT_EQ(event.joint, kNoJoint);
  event = event_of([](ArmState& state) { state.overran = true; });
  EXPECT_EQ(event.fault, Fault::kOverrun);
  EXPECT_EQ(event.found, 10.0);
}

}  // namespace
}  // namespace geodesic::control
