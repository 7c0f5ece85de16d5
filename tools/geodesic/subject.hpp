// What a command computes on when it takes a URDF or a robot's file alike: the tree of bodies and
// what else the file says of it.
#pragma once

#include <Eigen/Core>
#include <string>

#include "control/mechanism/tree.hpp"

namespace geodesic::tools {

struct Subject {
  control::TreeDescription tree;
  Eigen::Vector3d gravity{0.0, 0.0, -9.81};  ///< [m/s²], world
  std::string frame;                         ///< the tool's link; empty: not told
  Eigen::VectorXd rotor_inertia;             ///< in the order of the joints; empty: not told
};

/// Reads FILE: a robot's file if it ends in .toml, else a URDF. Messages go to stderr.
/// @throws BadInput if it is not whole.
Subject read_subject(const std::string& file);

}  // namespace geodesic::tools
