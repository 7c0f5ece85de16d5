// The quantities that `geodesic model` knows: name, meaning, and how each is computed in the
// mechanism's own numbers. What becomes of them in another layout or as text is elsewhere.
#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "tools/geodesic/evaluation.hpp"

namespace geodesic::tools {

/// How the numbers change with the layout of v (T: own from file).
enum class Shape {
  kNumber,        ///< not at all
  kPlain,         ///< not at all: numbers in space
  kVector,        ///< components of a tangent vector
  kAcceleration,  ///< rates of components of v
  kCovector,      ///< torques and momenta
  kBias,          ///< what of a torque belongs to velocity
  kMetric,        ///< both indices covariant
  kInverse,       ///< both indices contravariant
  kCoriolis,      ///< coefficients of the connection along v
  kMetricRate,    ///< dM/dt
  kColumns,       ///< a column for each of v
  kColumnsRate,   ///< the rate of J_ee
  kRows,          ///< a row for each of v
  kTable,         ///< three covariant indices
  kMixedTable,    ///< the first of three contravariant
};

using Answer = std::variant<std::monostate, double, Eigen::MatrixXd, std::vector<Eigen::MatrixXd>>;

/// One state and what is asked of it, in the mechanism's own numbers.
struct Question {
  const control::Mechanism& mechanism;
  control::Workspace& workspace;
  const Eigen::VectorXd& q;
  const Eigen::VectorXd& v;
  const Eigen::VectorXd& a;
  const EvaluationRequest& request;
};

struct Quantity {
  const char* name;
  const char* meaning;  ///< for people, with units
  Shape shape;
  Answer (*answer)(const Question& question);
};

/// In the order in which they are listed.
std::span<const Quantity> quantities();

/// @throws BadInput with the list of all, if there is none of that name.
const Quantity& find_quantity(const std::string& name);

/// A line for each: name and meaning.
std::string list_quantities();

}  // namespace geodesic::tools
