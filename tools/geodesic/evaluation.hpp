// Everything the mechanism can say of one state, by name and as JSON. Shared by `geodesic model`
// and its tests; the table of quantities is in quantities.hpp.
#pragma once

#include <Eigen/Core>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "control/mechanism/dynamics.hpp"
#include "tools/geodesic/states_file.hpp"

namespace geodesic::tools {

/// What is asked of a state. Vectors are in the layout of the answer.
struct EvaluationRequest {
  int frame = 0;                  ///< index in links(): the link of J_ee, ee_p, ...
  std::vector<std::string> what;  ///< names of quantities, in order; see quantities.hpp
  std::vector<control::ExternalWrench> wrenches;
  std::optional<Eigen::VectorXd> x;      ///< first direction, default: v
  std::optional<Eigen::VectorXd> y;      ///< second direction
  std::optional<Eigen::VectorXd> p;      ///< covector, default: tau
  std::optional<control::Twist> motion;  ///< of space, whose momentum map is asked for
};

/// The names that the reference files hold: tau, g, Cv, M, Minv, C, Mdot, kinetic_energy,
/// potential_energy, J_ee, ee_R, ee_p; with a floating base also com, vcom, hg_linear, hg_angular.
std::vector<std::string> reference_quantities(bool floating);

/// q, v, a as written, then what was asked for. Null where M is singular, or the quantity has no
/// meaning there. Conventions: as Mechanism, in the layout given.
/// @param state  the mechanism's own numbers    @param written  the same in the layout
/// @throws BadInput for an unknown name (with the list), or a direction that is missing or too
/// long.
nlohmann::ordered_json evaluate(const control::Mechanism& mechanism, control::Workspace& workspace,
                                const EvaluationState& state, const EvaluationState& written,
                                const StatesLayout& layout, const EvaluationRequest& request);

/// Name, kind, indices and limits of every independent joint; an unlimited figure is null.
nlohmann::ordered_json joints_json(const control::Mechanism& mechanism, const StatesLayout& layout);

nlohmann::ordered_json to_json(const Eigen::VectorXd& vector);
nlohmann::ordered_json to_json(const Eigen::MatrixXd& matrix);

}  // namespace geodesic::tools
