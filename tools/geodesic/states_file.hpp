// The file of states that `geodesic model --states` reads: the format of the reference files.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "control/mechanism/mechanism.hpp"
#include "tools/geodesic/evaluation.hpp"

namespace geodesic::tools {

struct StatesFile {
  std::optional<Eigen::Vector3d> gravity;  ///< [m/s²]
  std::optional<std::string> frame;        ///< "ee_frame"
  std::optional<bool> floating;            ///< "floating_base"
  std::vector<std::string> joints;         ///< names, if the file tells them
  bool christoffel = false;                ///< its states hold christoffel_first_kind
  std::vector<EvaluationState> states;     ///< v and a may be empty: not told
};

/// Reads gravity, ee_frame, floating_base, joints and states[].{q,v,a}; everything else is left
/// alone. Pipes will do. @throws BadInput with file, place and what was expected.
StatesFile read_states(const std::string& file);

/// Fills in what was not told (zeros) and checks sizes, numbers, quaternion and joint order.
/// @throws BadInput.
void fit_states(StatesFile& file, const control::Mechanism& mechanism, const std::string& name);

}  // namespace geodesic::tools
