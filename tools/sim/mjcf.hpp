// Writes a robot as a MuJoCo model text: every link, joint, stop, friction, and the floor. Only
// text; compiling and stepping it is physics.hpp's.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "config/robot.hpp"
#include "control/mechanism/tree.hpp"

namespace geodesic::tools {

/// What a model is written from.
struct MjcfInput {
  const control::TreeDescription& tree;
  const std::vector<std::string>& joints;  ///< names in order of v; simulation.joints matches
  const config::SimulationOptions& simulation;
  Eigen::Vector3d gravity;  ///< [m/s²], world
  double timestep_s;
};

struct Mjcf {
  std::string xml;
  std::vector<std::string> warnings;  ///< where the model had to differ from the URDF, and how
};

/// Body i of the tree's links is named "b<i>", joint i of its joints "j<i>", the geometry of link i
/// "g<i>": names of files never reach the XML. @throws std::invalid_argument for no proper tree.
Mjcf write_mjcf(const MjcfInput& input);

}  // namespace geodesic::tools
