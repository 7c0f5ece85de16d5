// What several tests of the daemon share: a small robot and a folder that vanishes. No test here.
#pragma once

#include <stdlib.h>  // NOLINT(modernize-deprecated-headers): mkdtemp is POSIX, not C++

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "config/robot.hpp"

namespace geodesic::tools {

/// A folder of its own for one test.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "geodesicd-XXXXXX").string();
    path_ = ::mkdtemp(name.data());
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

inline std::string read_text(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

/// A pendulum and a slider on one bus: "swing" turns about y, "slide" moves along x of its link.
inline config::Robot small_robot() {
  using control::JointKind;
  config::Robot robot;
  robot.name = "bench";
  robot.tree.name = "bench";
  robot.tree.root_link = "base";
  robot.tree.links.resize(3);
  robot.tree.links[0].name = "base";
  const auto add = [&robot](std::size_t index, const std::string& joint, JointKind kind,
                            const std::string& parent, const std::string& child,
                            const Eigen::Vector3d& axis) {
    control::LinkDescription& link = robot.tree.links[index];
    link.name = child;
    link.inertia.mass_kg = 1.0;
    link.inertia.com_m = Eigen::Vector3d(0.5, 0.0, 0.0);
    link.inertia.inertia_kg_m2 = Eigen::Matrix3d::Identity() * 0.01;
    control::JointDescription described;
    described.name = joint;
    described.kind = kind;
    described.parent_link = parent;
    described.child_link = child;
    described.axis = axis;
    robot.tree.joints.push_back(described);

    drivers::JointOptions options;
    options.name = joint;
    options.drive.family = "damiao";
    options.drive.id = static_cast<std::uint32_t>(index);
    options.drive.reply_id = static_cast<std::uint32_t>(16 + index);
    options.drive.position_range_rad = 12.5;
    options.drive.velocity_range_rad_s = 30.0;
    options.drive.torque_range_nm = 20.0;
    robot.arm.joints.push_back(options);

    control::JointTuning tuning;
    tuning.name = joint;
    tuning.drive_damping = 0.5;
    tuning.torque_limit = 18.0;
    robot.controller.joints.push_back(tuning);
  };
  add(1, "swing", JointKind::kRevolute, "base", "arm", Eigen::Vector3d::UnitY());
  add(2, "slide", JointKind::kPrismatic, "arm", "carriage", Eigen::Vector3d::UnitX());
  drivers::BusOptions bus;
  bus.name = "arm";
  bus.interface = "vcan0";
  robot.arm.buses.push_back(bus);
  return robot;
}

}  // namespace geodesic::tools
