// What a robot's model asks of its drives: reach, and the largest gravity torque of each joint over
// all poses. Searches; nothing here is exact beyond what the search found.
#pragma once

#include <vector>

#include "config/robot.hpp"
#include "control/mechanism/dynamics.hpp"

namespace geodesic::tools {

struct JointWorkload {
  double gravity_max = 0.0;        ///< largest |gravity torque| found [N·m or N]
  std::vector<double> worst_pose;  ///< where, in order of v
  double available = 0.0;          ///< smallest of the limits below
  double torque_limit = 0.0;       ///< configured
  double drive_range = 0.0;        ///< of the drive, at the joint
  double effort = 0.0;             ///< of the URDF
};

struct Workload {
  std::vector<JointWorkload> joints;
  double reach_m = 0.0;  ///< farthest that the tool's origin gets from the first joint's origin
};

/// Not real-time; the same robot gives the same answer.
Workload find_workload(const config::Robot& robot, const control::Mechanism& mechanism,
                       int tool_link);

}  // namespace geodesic::tools
