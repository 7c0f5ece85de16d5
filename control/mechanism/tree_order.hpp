// Is a TreeDescription a tree of rigid bodies, and in which order are its joints? Refusals for
// people; no mechanics.
#pragma once

#include <vector>

#include "control/mechanism/tree.hpp"

namespace geodesic::control {

/// Checks every number, name and connection of the description.
/// @throws std::invalid_argument naming the link or joint. Not real-time.
void check_tree(const TreeDescription& tree);

/// The joints of a checked tree, depth first from the root, siblings by joint name; they point into
/// `tree`.
std::vector<const JointDescription*> depth_first(const TreeDescription& tree);

}  // namespace geodesic::control
