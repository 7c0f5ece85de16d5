// The answer of `geodesic model` for people: names, units, columns. What is computed is in
// evaluation.hpp.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "control/mechanism/mechanism.hpp"
#include "control/mechanism/tree.hpp"

namespace geodesic::tools {

/// The robot's links with mass, and its joints.
void print_robot(const control::TreeDescription& tree, const control::Mechanism& mechanism);

/// One state of evaluate()'s answer. @param what  names in the order to print
/// @param frame  the link of J_ee, ee_p, ee_R, Jdot_ee
void print_state(const nlohmann::ordered_json& state, const std::vector<std::string>& what,
                 const std::string& frame);

}  // namespace geodesic::tools
