// Reads a URDF into a TreeDescription. Shapes (visual, collision) are not looked at; what a robot
// file does with the tree (locks, drives) is in robot.hpp.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "config/robot.hpp"
#include "control/mechanism/tree.hpp"

namespace geodesic::config {

struct UrdfResult {
  control::TreeDescription tree;        ///< whole only if ok
  std::vector<Message> messages;        ///< in order of place
  std::map<std::string, Place> links;   ///< where each is declared
  std::map<std::string, Place> joints;  ///< where each is declared
  std::string text;                     ///< what was read
  bool ok = false;
};

/// Reads and checks a URDF: its structure, every number, and whether a body can have such inertia.
/// Numbers and rotations arrive exactly as written. Never throws for what the file says.
/// @param strict  what is odd but usable (the model lint's warnings) is an error.
/// @param text  is read in place of the file.
UrdfResult load_urdf(const std::filesystem::path& file, bool strict,
                     std::optional<std::string> text = std::nullopt);

}  // namespace geodesic::config
