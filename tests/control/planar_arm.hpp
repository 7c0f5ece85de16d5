// A planar two-link arm and drives that obey, for tests of the controller. Not a simulation: what
// the joints do is up to the test.
#pragma once

#include <string>

#include "control/controller.hpp"

namespace geodesic::control::testing {

inline constexpr std::int64_t kPeriod = 1'000'000;

/// Two links of 0.5 m and 2 kg, centre of mass in the middle, turning about z; gravity along -y.
inline TreeDescription planar_tree() {
  TreeDescription tree;
  tree.name = "planar";
  tree.root_link = "base";
  tree.links.push_back({"base", {}});
  for (int i = 1; i <= 2; ++i) {
    LinkDescription link;
    link.name = "link" + std::to_string(i);
    link.inertia.mass_kg = 2.0;
    link.inertia.com_m = {0.25, 0.0, 0.0};
    link.inertia.inertia_kg_m2 = Eigen::Vector3d(0.001, 0.042, 0.042).asDiagonal();
    tree.links.push_back(link);
    JointDescription joint;
    joint.name = "joint" + std::to_string(i);
    joint.kind = JointKind::kRevolute;
    joint.parent_link = i == 1 ? "base" : "link1";
    joint.child_link = link.name;
    joint.parent_from_joint.translation() = Eigen::Vector3d(i == 1 ? 0.0 : 0.5, 0.0, 0.0);
    joint.axis = Eigen::Vector3d::UnitZ();
    tree.joints.push_back(joint);
  }
  return tree;
}

inline Mechanism planar_mechanism() {
  return {planar_tree(), Eigen::Vector3d(0.0, -9.81, 0.0)};
}

inline ControllerOptions planar_options() {
  ControllerOptions options;
  for (const char* name : {"joint1", "joint2"}) {
    JointTuning joint;
    joint.name = name;
    joint.position_lower = -2.0;
    joint.position_upper = 2.0;
    joint.soft_margin = 0.1;
    joint.wall_stiffness = 100.0;
    joint.wall_damping = 5.0;
    joint.hold_stiffness = 50.0;
    joint.hold_damping = 2.0;
    joint.stop_damping = 3.0;
    joint.drive_damping = 1.5;
    joint.coulomb_friction = 0.2;
    joint.viscous_friction = 0.1;
    joint.velocity_limit = 5.0;
    joint.torque_limit = 40.0;
    joint.torque_rate_limit = 2000.0;
    options.joints.push_back(joint);
  }
  return options;
}

/// Drives that do as they are told within a cycle, and joints that stay where they are put.
struct ObedientArm {
  ArmState state;

  explicit ObedientArm(std::size_t joints = 2) {
    state.joints = joints;
    state.buses = 1;
    state.tick_ns = 1'000'000'000;
    for (std::size_t i = 0; i < joints; ++i) {
      state.joint[i].position = 0.3;
      state.joint[i].temperature_c = 30.0;
    }
  }

  /// One period passes; every drive obeys `command` and answers.
  void obey(const ArmCommand& command) {
    state.tick_ns += kPeriod;
    for (std::size_t i = 0; i < state.joints; ++i) {
      JointState& joint = state.joint[i];
      joint.stamp_ns = state.tick_ns + 100'000 + static_cast<std::int64_t>(i) * 50'000;
      joint.fresh = true;
      if (joint.condition == DriveCondition::kError ||
          joint.condition == DriveCondition::kRefused) {
        continue;
      }
      const DriveMode mode = command.joint[i].mode;
      const bool configured = joint.condition == DriveCondition::kDisabled ||
                              joint.condition == DriveCondition::kEnabled;
      if (mode == DriveMode::kEnable && configured) {
        joint.condition = DriveCondition::kEnabled;
      } else if (mode == DriveMode::kDisable && configured) {
        joint.condition = DriveCondition::kDisabled;
      } else if (mode == DriveMode::kMonitor && !configured) {
        joint.condition = joint.condition == DriveCondition::kUnknown ? DriveCondition::kConfiguring
                                                                      : DriveCondition::kDisabled;
      }
    }
  }
};

/// Controller and obedient arm, cycle by cycle.
struct Bench {
  Controller controller;
  ObedientArm arm;
  ArmCommand command;

  explicit Bench(const ControllerOptions& options = planar_options())
      : controller(planar_mechanism(), options), arm(options.joints.size()) {}

  const ControllerReport& report() const { return controller.report(); }
  SupervisorState state() const { return report().state; }

  /// One cycle; `disturb` may change what was measured before the controller sees it.
  template <class Disturb>
  void cycle(Disturb disturb) {
    arm.obey(command);
    ArmState seen = arm.state;
    disturb(seen);
    command = controller.update(seen, kPeriod);
  }
  void cycle() {
    cycle([](ArmState&) {});
  }

  /// Until `state` is reached. @return false if it is not within `cycles`.
  bool run_until(SupervisorState state, int cycles = 10'000) {
    for (int i = 0; i < cycles && this->state() != state; ++i) {
      cycle();
    }
    return this->state() == state;
  }

  /// Whether `fault` was raised in the last cycle, for `joint` if that is given.
  bool raised(Fault fault, int joint = -2) const {
    for (std::size_t i = 0; i < report().events; ++i) {
      const FaultEvent& event = report().event[i];
      if (event.fault == fault && (joint == -2 || event.joint == joint)) {
        return true;
      }
    }
    return false;
  }
};

}  // namespace geodesic::control::testing
