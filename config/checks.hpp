// The steps from a robot file as written to a checked Robot, each in a file of its own;
// load_robot() runs them in this order.
#pragma once

#include <map>
#include <string>

#include "config/findings.hpp"
#include "config/robot_file.hpp"
#include "config/urdf.hpp"

namespace geodesic::config {

/// What every step sees.
struct Draft {
  const RobotFile& file;
  const LoadOptions& options;
  UrdfResult& urdf;
  Robot& robot;
  Findings& findings;
};

/// [robot], [realtime], [control], [safety]: copies what stands for itself.
void fill_plain_options(Draft& draft);

/// Fixes the joints that the file locks in the tree. (locks.cpp)
void apply_locks(Draft& draft);

/// [[bus]] and --bus: names, interfaces, bit rates. (buses.cpp)
void fill_buses(Draft& draft);

/// [[joint]] against the URDF and the buses, in the mechanism's order of v; limits against the
/// drive's ranges. (joints.cpp, joint_limits.cpp)
void fill_joints(Draft& draft);
/// Which joints are which arm. After fill_joints().
void fill_arms(Draft& draft);

/// Limits, gains and drive of one joint; `joint` is null if the URDF could not be read.
control::JointTuning check_limits(const JointEntry& entry, const control::JointDescription* joint,
                                  std::int64_t period_ns, Findings& findings);

/// Identifiers: no two drives of a bus may be mistaken for one another. (identifiers.cpp)
void check_identifiers(Draft& draft);

/// The simulated arm's pose and joints. (simulation.cpp)
void fill_simulation(Draft& draft);

/// [[payload]], and which of them is carried. (payloads.cpp)
void fill_payloads(Draft& draft);

/// Whether every bus can carry its drives' frames at the configured rate. (budget.cpp)
void check_budget(Draft& draft);

/// Names of all moving joints with a position of their own: not fixed, no mimics.
std::vector<std::string> independent_joints(const control::TreeDescription& tree);

/// The joint of that name; null if there is none.
const control::JointDescription* find_joint(const control::TreeDescription& tree,
                                            std::string_view name);

}  // namespace geodesic::config
