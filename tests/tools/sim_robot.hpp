// Robots made in code for the simulator's tests: chains of links with drives on one bus. No files.
#pragma once

#include <fmt/format.h>

#include <string>

#include "config/robot.hpp"

namespace geodesic::tools::test {

/// `joints` links of 0.2 m, the masses falling off; axes in turn z and y; Damiao drives 1, 2, ...
/// on one bus. `friction` is dry [N·m], `rotor` reflected [kg·m²].
inline config::Robot chain(int joints, double friction = 0.0, double rotor = 0.0) {
  config::Robot robot;
  robot.name = "chain";
  robot.tree.name = "chain";
  robot.tree.root_link = "base";
  robot.tree.links.push_back({"base", {}});
  drivers::BusOptions bus;
  bus.name = "main";
  bus.interface = "unix:/nonexistent";
  robot.arm.buses.push_back(bus);
  std::string parent = "base";
  for (int i = 0; i < joints; ++i) {
    control::LinkDescription link;
    link.name = fmt::format("link{}", i + 1);
    link.inertia.mass_kg = 0.9 / (i + 1);
    link.inertia.com_m = {0.1, 0.01, -0.02};
    const double across = link.inertia.mass_kg * 0.04 / 12.0;
    link.inertia.inertia_kg_m2 = Eigen::Vector3d(1e-4, across, across).asDiagonal();
    robot.tree.links.push_back(link);

    control::JointDescription joint;
    joint.name = fmt::format("joint{}", i + 1);
    joint.kind = control::JointKind::kRevolute;
    joint.parent_link = parent;
    joint.child_link = link.name;
    joint.lower = -3.0;
    joint.upper = 3.0;
    joint.axis = i % 2 == 0 ? Eigen::Vector3d::UnitZ() : Eigen::Vector3d::UnitY();
    if (i > 0) joint.parent_from_joint.translation() = Eigen::Vector3d(0.2, 0.0, 0.0);
    robot.tree.joints.push_back(joint);
    parent = link.name;

    drivers::JointOptions drive;
    drive.name = joint.name;
    drive.drive.family = "damiao";
    drive.drive.id = static_cast<std::uint32_t>(i + 1);
    drive.drive.reply_id = static_cast<std::uint32_t>(i + 0x11);
    drive.drive.position_range_rad = 12.5;
    drive.drive.velocity_range_rad_s = 30.0;
    drive.drive.torque_range_nm = 10.0;
    robot.arm.joints.push_back(drive);
    robot.simulation.joints.push_back({friction, 0.0, rotor});
    robot.simulation.pose.push_back(0.3);
  }
  return robot;
}

}  // namespace geodesic::tools::test
