// The file of states that `geodesic model --states` reads: the format of the reference files, in
// the layouts that are met with. What is computed of a state is in evaluation.hpp.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "control/mechanism/mechanism.hpp"
#include "control/mechanism/tree.hpp"
#include "tools/geodesic/states_layout.hpp"

namespace geodesic::tools {

struct EvaluationState {
  Eigen::VectorXd q;  ///< size nq
  Eigen::VectorXd v;  ///< size nv
  Eigen::VectorXd a;  ///< size nv
};

struct StatesFile {
  std::optional<Eigen::Vector3d> gravity;   ///< [m/s²]
  std::optional<std::string> frame;         ///< "ee_frame"
  std::optional<bool> floating;             ///< "floating_base"
  std::vector<FileJoint> joints;            ///< if the file lists them
  bool christoffel = false;                 ///< its states hold christoffel_first_kind
  std::vector<EvaluationState> states;      ///< v and a may be empty: not told
  std::vector<EvaluationState> as_written;  ///< in the file's layout, whole; by fit_states()
  std::optional<StatesLayout> layout;       ///< by fit_states()
};

/// Reads gravity, ee_frame, floating_base, joints and states[].{q,v,a}; everything else is left
/// alone. Pipes will do. @throws BadInput with file, place and what was expected.
StatesFile read_states(const std::string& file);

/// Frees the mimic joints of `tree` that the file lists among its independent ones: some engines
/// read a URDF so. @return their names
std::vector<std::string> free_listed_mimics(const StatesFile& file, control::TreeDescription& tree);

/// Whether the file lists a joint of six degrees of freedom that the tree does not have: a floating
/// base, whatever its name.
bool lists_base(const StatesFile& file, const control::TreeDescription& tree);

/// Fills in what was not told (zeros), finds the file's layout, checks sizes, numbers and unit
/// lengths, and turns the states into the mechanism's own q, v, a. @throws BadInput.
void fit_states(StatesFile& file, const control::Mechanism& mechanism, const std::string& name);

}  // namespace geodesic::tools
