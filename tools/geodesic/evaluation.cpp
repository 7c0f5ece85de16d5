// Evaluates by name and turns answers into the layout asked for; see the header.
#include "tools/geodesic/evaluation.hpp"

#include <fmt/format.h>

#include <cmath>

#include "tools/geodesic/command.hpp"
#include "tools/geodesic/quantities.hpp"

namespace geodesic::tools {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using nlohmann::ordered_json;

namespace {

/// Null in place of what is not a number.
ordered_json number(double value) {
  return std::isfinite(value) ? ordered_json(value) : ordered_json(nullptr);
}

ordered_json as_json(const Answer& answer) {
  if (const auto* value = std::get_if<double>(&answer)) return number(*value);
  if (const auto* matrix = std::get_if<MatrixXd>(&answer)) {
    return matrix->cols() == 1 ? to_json(VectorXd(matrix->col(0))) : to_json(*matrix);
  }
  if (const auto* table = std::get_if<std::vector<MatrixXd>>(&answer)) {
    ordered_json list = ordered_json::array();
    for (const MatrixXd& slice : *table) list.push_back(to_json(slice));
    return list;
  }
  return nullptr;
}

/// T, dT/dt along v, and what else the rules of transformation need.
struct Transformation {
  MatrixXd t;
  MatrixXd rate;
  const Question& question;
  const VectorXd& file_v;

  Answer apply(Shape shape, const Answer& answer) const {
    if (const auto* matrix = std::get_if<MatrixXd>(&answer)) return apply(shape, *matrix);
    if (const auto* table = std::get_if<std::vector<MatrixXd>>(&answer)) return apply(*table);
    return answer;
  }

  /// T is orthogonal: its inverse is its transpose.
  Answer apply(Shape shape, const MatrixXd& x) const {
    switch (shape) {
      case Shape::kVector:
      case Shape::kCovector:
      case Shape::kRows:
        return MatrixXd(t.transpose() * x);
      case Shape::kBias:
        return MatrixXd(t.transpose() * (x + metric() * (rate * file_v)));
      case Shape::kAcceleration:
        return MatrixXd(t.transpose() * (x - rate * file_v));
      case Shape::kMetric:
      case Shape::kInverse:
        return MatrixXd(t.transpose() * x * t);
      case Shape::kCoriolis:
        return MatrixXd(t.transpose() * (x * t + metric() * rate));
      case Shape::kMetricRate: {
        const MatrixXd turned = t.transpose() * metric() * rate;
        return MatrixXd(t.transpose() * x * t + turned + turned.transpose());
      }
      case Shape::kColumns:
        return MatrixXd(x * t);
      case Shape::kColumnsRate:
        return MatrixXd(x * t + control::jacobian(question.mechanism, question.workspace,
                                                  question.q, question.request.frame) *
                                    rate);
      default:
        return x;
    }
  }

  /// Only where T is a permutation, which maps every kind of index alike.
  Answer apply(const std::vector<MatrixXd>& table) const {
    std::vector<MatrixXd> result(table.size());
    for (std::size_t own = 0; own < table.size(); ++own) {
      Eigen::Index file = 0;
      t.row(static_cast<Eigen::Index>(own)).maxCoeff(&file);
      result[static_cast<std::size_t>(file)] = t.transpose() * table[own] * t;
    }
    return result;
  }

  MatrixXd metric() const {
    return control::metric(question.mechanism, question.workspace, question.q);
  }
};

/// A direction or covector of the request in the mechanism's own numbers.
void take(std::optional<VectorXd>& vector, const MatrixXd& own_from_file, const char* option) {
  if (!vector) return;
  if (vector->size() != own_from_file.cols()) {
    throw BadInput(fmt::format("{}: expected {} numbers, found {}", option, own_from_file.cols(),
                               vector->size()));
  }
  *vector = own_from_file * *vector;
}

}  // namespace

ordered_json to_json(const VectorXd& vector) {
  ordered_json list = ordered_json::array();
  for (const double value : vector) list.push_back(number(value));
  return list;
}

ordered_json to_json(const MatrixXd& matrix) {
  ordered_json rows = ordered_json::array();
  for (Eigen::Index row = 0; row < matrix.rows(); ++row) {
    rows.push_back(to_json(VectorXd(matrix.row(row))));
  }
  return rows;
}

std::vector<std::string> reference_quantities(bool floating) {
  std::vector<std::string> names{
      "tau",  "g",    "Cv",  "M", "Minv", "C", "Mdot", "kinetic_energy", "potential_energy",
      "J_ee", "ee_R", "ee_p"};
  if (floating) {
    for (const char* name : {"com", "vcom", "hg_linear", "hg_angular"}) names.emplace_back(name);
  }
  return names;
}

ordered_json evaluate(const control::Mechanism& mechanism, control::Workspace& workspace,
                      const EvaluationState& state, const EvaluationState& written,
                      const StatesLayout& layout, const EvaluationRequest& request) {
  EvaluationRequest own = request;
  const Question question{mechanism, workspace, state.q, state.v, state.a, own};
  const Transformation transformation{layout.own_from_file(state.q),
                                      layout.own_from_file_rate(state.q, state.v), question,
                                      written.v};
  take(own.x, transformation.t, "--x");
  take(own.y, transformation.t, "--y");
  take(own.p, transformation.t, "--p");
  ordered_json result{
      {"q", to_json(written.q)}, {"v", to_json(written.v)}, {"a", to_json(written.a)}};
  for (const std::string& name : request.what) {
    const Quantity& quantity = find_quantity(name);
    const bool is_table = quantity.shape == Shape::kTable || quantity.shape == Shape::kMixedTable;
    if (is_table && !layout.reorders_only()) {
      throw BadInput(fmt::format(
          "{}: not in the layout of this file, whose planar joints are written with (cos, sin): "
          "their velocities are no rates of coordinates",
          name));
    }
    Answer answer = quantity.answer(question);
    if (!layout.plain()) answer = transformation.apply(quantity.shape, answer);
    result[name] = as_json(answer);
  }
  return result;
}

ordered_json joints_json(const control::Mechanism& mechanism, const StatesLayout& layout) {
  ordered_json list = ordered_json::array();
  for (std::size_t i = 0; i < mechanism.joint_names().size(); ++i) {
    const control::JointLimits& limits = mechanism.joint_limits()[i];
    const control::Factor& factor = layout.factors()[i + (mechanism.floating() ? 1 : 0)];
    list.push_back({{"name", mechanism.joint_names()[i]},
                    {"type", control::kind_name(factor.kind)},
                    {"idx_q", factor.q},
                    {"idx_v", factor.v},
                    {"nq", factor.nq},
                    {"nv", factor.nv},
                    {"lower", number(limits.lower)},
                    {"upper", number(limits.upper)},
                    {"effort", number(limits.effort)},
                    {"velocity", number(limits.velocity)}});
  }
  return list;
}

}  // namespace geodesic::tools
