// Everything the mechanism can say of one state, as the reference files hold it (JSON). Shared by
// `geodesic model` and its tests.
#pragma once

#include <Eigen/Core>
#include <nlohmann/json.hpp>
#include <string>

#include "control/mechanism/dynamics.hpp"

namespace geodesic::tools {

struct EvaluationState {
  Eigen::VectorXd q;  ///< size nq
  Eigen::VectorXd v;  ///< size nv
  Eigen::VectorXd a;  ///< size nv
};

/// q, v, a -> tau, g, Cv, M, Minv, C, Mdot, kinetic_energy, potential_energy, J_ee, ee_R, ee_p;
/// with a floating base also com, vcom, hg_linear, hg_angular; if asked, christoffel_first_kind.
/// Minv is null where M is singular. Conventions: as Mechanism. @param frame  index in links()
nlohmann::ordered_json evaluate(const control::Mechanism& mechanism, control::Workspace& workspace,
                                const EvaluationState& state, int frame, bool christoffel);

/// Name, kind, indices and limits of every independent joint; an unlimited figure is null.
nlohmann::ordered_json joints_json(const control::Mechanism& mechanism);

nlohmann::ordered_json to_json(const Eigen::VectorXd& vector);
nlohmann::ordered_json to_json(const Eigen::MatrixXd& matrix);

}  // namespace geodesic::tools
