// Everything the mechanism can say of one state, as JSON; see the header.
#include "tools/geodesic/evaluation.hpp"

#include <cmath>

namespace geodesic::tools {

using nlohmann::ordered_json;

ordered_json to_json(const Eigen::VectorXd& vector) {
  ordered_json list = ordered_json::array();
  for (const double value : vector) list.push_back(value);
  return list;
}

ordered_json to_json(const Eigen::MatrixXd& matrix) {
  ordered_json rows = ordered_json::array();
  for (Eigen::Index row = 0; row < matrix.rows(); ++row) {
    rows.push_back(to_json(Eigen::VectorXd(matrix.row(row))));
  }
  return rows;
}

ordered_json evaluate(const control::Mechanism& mechanism, control::Workspace& workspace,
                      const EvaluationState& state, int frame, bool christoffel) {
  const Eigen::VectorXd& q = state.q;
  const Eigen::VectorXd& v = state.v;
  ordered_json result{{"q", to_json(q)}, {"v", to_json(v)}, {"a", to_json(state.a)}};
  result["tau"] = to_json(control::inverse_dynamics(mechanism, workspace, q, v, state.a));
  result["g"] = to_json(control::gravity(mechanism, workspace, q));
  const Eigen::MatrixXd coriolis = control::coriolis_matrix(mechanism, workspace, q, v);
  result["Cv"] = to_json(Eigen::VectorXd(coriolis * v));
  result["M"] = to_json(control::metric(mechanism, workspace, q));
  const Eigen::MatrixXd* inverse = control::metric_inverse(mechanism, workspace, q);
  result["Minv"] = inverse != nullptr ? to_json(*inverse) : ordered_json(nullptr);
  result["C"] = to_json(coriolis);
  result["Mdot"] = to_json(control::metric_rate(mechanism, workspace, q, v));
  result["kinetic_energy"] = control::kinetic_energy(mechanism, workspace, q, v);
  result["potential_energy"] = control::potential_energy(mechanism, workspace, q);
  result["J_ee"] = to_json(Eigen::MatrixXd(control::jacobian(mechanism, workspace, q, frame)));
  const control::Pose pose = control::link_pose(mechanism, q, frame);
  result["ee_R"] = to_json(Eigen::MatrixXd(pose.rotation));
  result["ee_p"] = to_json(Eigen::VectorXd(pose.translation));
  if (mechanism.floating()) {
    const auto momentum = control::centroidal_momentum(mechanism, workspace, q, v);
    result["com"] = to_json(Eigen::VectorXd(momentum.centre_of_mass));
    result["vcom"] = to_json(Eigen::VectorXd(momentum.velocity));
    result["hg_linear"] = to_json(Eigen::VectorXd(momentum.linear));
    result["hg_angular"] = to_json(Eigen::VectorXd(momentum.angular));
  }
  if (christoffel) {
    control::Christoffel symbols(mechanism);
    control::christoffel_symbols(mechanism, workspace, q, symbols);
    ordered_json cube = ordered_json::array();
    for (int i = 0; i < mechanism.dof(); ++i) {
      Eigen::MatrixXd slice(mechanism.dof(), mechanism.dof());
      for (int j = 0; j < mechanism.dof(); ++j) {
        for (int k = 0; k < mechanism.dof(); ++k) slice(j, k) = symbols(i, j, k);
      }
      cube.push_back(to_json(slice));
    }
    result["christoffel_first_kind"] = std::move(cube);
  }
  return result;
}

ordered_json joints_json(const control::Mechanism& mechanism) {
  const auto figure = [](double value) {
    return std::isfinite(value) ? ordered_json(value) : ordered_json(nullptr);
  };
  const auto kind_name = [](control::JointKind kind) {
    switch (kind) {
      case control::JointKind::kRevolute:
        return "revolute";
      case control::JointKind::kContinuous:
        return "continuous";
      case control::JointKind::kPrismatic:
        return "prismatic";
      case control::JointKind::kFixed:
        break;
    }
    return "fixed";
  };
  ordered_json list = ordered_json::array();
  for (std::size_t i = 0; i < mechanism.joint_names().size(); ++i) {
    const control::JointLimits& limits = mechanism.joint_limits()[i];
    list.push_back({{"name", mechanism.joint_names()[i]},
                    {"type", kind_name(mechanism.joint_kinds()[i])},
                    {"idx_q", mechanism.first_joint_q() + static_cast<int>(i)},
                    {"idx_v", mechanism.first_joint_v() + static_cast<int>(i)},
                    {"lower", figure(limits.lower)},
                    {"upper", figure(limits.upper)},
                    {"effort", figure(limits.effort)},
                    {"velocity", figure(limits.velocity)}});
  }
  return list;
}

}  // namespace geodesic::tools
