// A controller and MuJoCo face to face, without bus or drive dialogue: what the drives report is
// quantised as theirs, commands leave a cycle after they were computed. The arm that moves and the
// one the controller believes in may differ.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "config/robot.hpp"
#include "control/controller.hpp"
#include "tools/sim/physics.hpp"

namespace geodesic::tools::test {

/// One of the robots of config/robots.
inline config::Robot load(const std::string& name) {
  const std::filesystem::path robots = GEODESIC_SOURCE_DIR "/config/robots";
  config::LoadResult result = config::load_robot(robots / name / "robot.toml");
  EXPECT_TRUE(result.ok);
  return result.robot;
}

/// All masses and inertias, times `factor` of the link's number.
inline void scale_masses(config::Robot& robot, const std::function<double(std::size_t)>& factor) {
  for (std::size_t i = 0; i < robot.tree.links.size(); ++i) {
    control::LinkInertia& inertia = robot.tree.links[i].inertia;
    inertia.mass_kg *= factor(i);
    inertia.inertia_kg_m2 *= factor(i);
  }
}

/// A lump fixed at the origin of the robot's tool link.
inline void add_payload(config::Robot& robot, double mass_kg) {
  for (control::LinkDescription& link : robot.tree.links) {
    if (link.name != robot.tool_link) continue;
    link.inertia.mass_kg += mass_kg;
    link.inertia.inertia_kg_m2 += 4e-4 * mass_kg * Eigen::Matrix3d::Identity();
  }
}

inline control::Mechanism mechanism_of(const config::Robot& robot) {
  control::MechanismOptions options;
  options.rotor_inertia.resize(static_cast<Eigen::Index>(robot.controller.joints.size()));
  for (std::size_t i = 0; i < robot.controller.joints.size(); ++i) {
    options.rotor_inertia[static_cast<Eigen::Index>(i)] = robot.controller.joints[i].rotor_inertia;
  }
  return {robot.tree, robot.gravity, options};
}

/// A value as a drive reports it: truncated to a code of so many bits over +-range.
inline double truncated(double value, double range, unsigned bits) {
  const double top = std::ldexp(1.0, static_cast<int>(bits)) - 1.0;
  const double code = std::floor((std::clamp(value, -range, range) + range) * top / (2.0 * range));
  return code / top * 2.0 * range - range;
}

/// The arm and its drives.
class Cell {
 public:
  explicit Cell(const config::Robot& real)
      : physics(real, static_cast<double>(real.period_ns) * 1e-9 / kSubsteps),
        robot_(real),
        period_ns_(real.period_ns) {
    state.joints = physics.joints();
    state.buses = real.arm.buses.size();
    state.tick_ns = 1'000'000'000;
    torque.assign(physics.joints(), 0.0);
    sign.assign(physics.joints(), 1.0);
    for (std::size_t i = 0; i < state.joints; ++i) state.joint[i].temperature_c = 30.0;
  }

  static constexpr int kSubsteps = 4;
  Physics physics;
  control::ArmState state;
  std::vector<double> torque;  ///< of the drives on the joints, as commanded and quantised
  std::vector<double> sign;    ///< -1: the torque acts the other way round
  bool on_stand = false;
  /// Called before each substep, to push.
  std::function<void(Physics&)> push;

  /// The next tick: `command` reaches the drives, and they answer.
  void answer(const control::ArmCommand& command) {
    state.tick_ns += period_ns_;
    command_ = command;
    for (std::size_t i = 0; i < state.joints; ++i) {
      control::JointState& joint = state.joint[i];
      obey(joint, command.joint[i].mode);
      const drivers::JointOptions& options = robot_.arm.joints[i];
      const double ratio = options.ratio;
      joint.position = truncated(physics.position(i), options.drive.position_range_rad * ratio, 16);
      joint.velocity =
          truncated(physics.velocity(i), options.drive.velocity_range_rad_s * ratio, 12);
      joint.torque = truncated(drive_torque(i), options.drive.torque_range_nm / ratio, 12);
      joint.stamp_ns = state.tick_ns;
      joint.fresh = true;
    }
  }

  /// One period of mechanics.
  void move() {
    for (int k = 0; k < kSubsteps; ++k) {
      physics.clear_forces();
      for (std::size_t i = 0; i < state.joints; ++i) {
        torque[i] = sign[i] * drive_torque(i);
        physics.set_torque(i, torque[i]);
      }
      if (on_stand) lean();
      if (push) push(physics);
      physics.step();
    }
  }

 private:
  static void obey(control::JointState& joint, control::DriveMode mode) {
    using control::DriveCondition;
    using control::DriveMode;
    const bool configured =
        joint.condition == DriveCondition::kDisabled || joint.condition == DriveCondition::kEnabled;
    if (!configured) {
      joint.condition = DriveCondition::kDisabled;
    } else if (mode == DriveMode::kEnable) {
      joint.condition = DriveCondition::kEnabled;
    } else {
      joint.condition = DriveCondition::kDisabled;
    }
  }

  double drive_torque(std::size_t i) const {
    if (state.joint[i].condition != control::DriveCondition::kEnabled) return 0.0;
    const control::JointCommand& in = command_.joint[i];
    const double range = robot_.arm.joints[i].drive.torque_range_nm / robot_.arm.joints[i].ratio;
    const double sum = in.torque + in.stiffness * (in.position - physics.position(i)) +
                       in.damping * (in.velocity - physics.velocity(i));
    return std::clamp(sum, -range, range);
  }

  /// As Plant's: each joint gets what its drive does not give, up to what the pose needs.
  void lean() {
    const std::vector<double> surplus = physics.unbalanced_torques();
    for (std::size_t i = 0; i < state.joints; ++i) {
      const double needed = torque[i] - surplus[i];
      const double carried = std::clamp(-surplus[i], std::min(needed, 0.0), std::max(needed, 0.0));
      physics.set_torque(i, torque[i] + carried);
    }
  }

  config::Robot robot_;
  std::int64_t period_ns_;
  control::ArmCommand command_;
};

/// Controller and cell, cycle by cycle.
struct WatchLoop {
  WatchLoop(const config::Robot& believed, const config::Robot& real)
      : controller(mechanism_of(believed), believed.controller),
        cell(real),
        period_ns(believed.period_ns) {
    cell.on_stand = true;
  }

  control::Controller controller;
  Cell cell;
  std::int64_t period_ns;
  control::ArmCommand command;
  std::vector<control::FaultEvent> events;

  const control::ControllerReport& report() const { return controller.report(); }

  void cycle() {
    cell.answer(command);
    command = controller.update(cell.state, period_ns);
    for (std::size_t i = 0; i < report().events; ++i) events.push_back(report().event[i]);
    cell.move();
  }
  void run(double seconds) {
    const auto cycles = static_cast<std::int64_t>(std::llround(seconds * 1e9)) / period_ns;
    for (std::int64_t i = 0; i < cycles; ++i) cycle();
  }
  /// Until the state is active with at least `authority`. @return false after 10 s without.
  bool run_until_authority(double authority) {
    for (int i = 0; i < 10'000; ++i) {
      if (report().state == control::SupervisorState::kActive && report().authority >= authority) {
        return true;
      }
      cycle();
    }
    return false;
  }
  /// First event of a fault, or null.
  const control::FaultEvent* first(control::Fault fault) const {
    for (const control::FaultEvent& event : events) {
      if (event.fault == fault) return &event;
    }
    return nullptr;
  }
};

}  // namespace geodesic::tools::test
