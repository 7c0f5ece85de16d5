// Implements quantities.hpp: one function a line, each a call into control/mechanism/.
#include "tools/geodesic/quantities.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>

#include "tools/geodesic/command.hpp"

namespace geodesic::tools {
namespace {

using control::Twist;
using Eigen::MatrixXd;
using Eigen::VectorXd;

Answer or_null(const VectorXd* vector) {
  return vector != nullptr ? Answer(MatrixXd(*vector)) : Answer();
}

Answer or_null(double number) {
  return std::isfinite(number) ? Answer(number) : Answer();
}

const VectorXd& first(const Question& c) {
  return c.request.x ? *c.request.x : c.v;
}

const VectorXd& second(const Question& c) {
  if (!c.request.y) throw BadInput("a curvature is that of two directions: give --y (and --x)");
  return *c.request.y;
}

VectorXd covector(const Question& c) {
  return c.request.p ? *c.request.p
                     : control::inverse_dynamics(c.mechanism, c.workspace, c.q, c.v, c.a);
}

Answer inverse(const Question& c) {
  const MatrixXd* found = control::metric_inverse(c.mechanism, c.workspace, c.q);
  return found != nullptr ? Answer(*found) : Answer();
}

/// [i][j][k]
Answer table(const control::Christoffel& symbols, int n) {
  std::vector<MatrixXd> cube;
  for (int i = 0; i < n; ++i) {
    MatrixXd slice(n, n);
    for (int j = 0; j < n; ++j) {
      for (int k = 0; k < n; ++k) slice(j, k) = symbols(i, j, k);
    }
    cube.push_back(std::move(slice));
  }
  return cube;
}

Answer first_kind(const Question& c) {
  control::Christoffel symbols(c.mechanism);
  control::christoffel_symbols(c.mechanism, c.workspace, c.q, symbols);
  return table(symbols, c.mechanism.dof());
}

Answer second_kind(const Question& c) {
  control::Christoffel symbols(c.mechanism);
  if (!control::christoffel_second_kind(c.mechanism, c.workspace, c.q, symbols)) return {};
  return table(symbols, c.mechanism.dof());
}

Answer metric_slope(const Question& c) {
  control::Christoffel slopes(c.mechanism);
  control::metric_derivative(c.mechanism, c.workspace, c.q, slopes);
  return table(slopes, c.mechanism.dof());
}

Answer regressor(const Question& c) {
  MatrixXd y(c.mechanism.dof(), control::parameter_count(c.mechanism));
  control::regressor(c.mechanism, c.workspace, c.q, c.v, c.a, y);
  return y;
}

Answer curvature_table(const Question& c) {
  const int n = c.mechanism.dof();
  MatrixXd k = MatrixXd::Zero(n, n);
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < i; ++j) {
      k(i, j) = control::sectional_curvature(c.mechanism, c.workspace, c.q, VectorXd::Unit(n, i),
                                             VectorXd::Unit(n, j));
      k(j, i) = k(i, j);
    }
  }
  return k.allFinite() ? Answer(k) : Answer();
}

/// Of the motion asked for, or of the six unit ones; not a number where the mechanism cannot move
/// so.
Answer momentum_map(const Question& c) {
  std::vector<Twist> motions;
  for (int axis = 0; axis < 6; ++axis) {
    Twist unit;
    (axis < 3 ? unit.linear : unit.angular)[axis % 3] = 1.0;
    motions.push_back(unit);
  }
  if (c.request.motion) motions = {*c.request.motion};
  VectorXd result(static_cast<Eigen::Index>(motions.size()));
  for (Eigen::Index i = 0; i < result.size(); ++i) {
    VectorXd generator(c.mechanism.dof());
    const bool possible = control::rigid_motion(c.mechanism, c.workspace, c.q,
                                                motions[static_cast<std::size_t>(i)], generator);
    result[i] = possible ? control::momentum_map(c.mechanism, c.workspace, c.q, c.v, generator)
                         : std::nan("");
  }
  return MatrixXd(result);
}

Answer momentum_in_space(const Question& c) {
  const control::Wrench h = control::spatial_momentum(c.mechanism, c.workspace, c.q, c.v);
  return MatrixXd((Eigen::Matrix<double, 6, 1>() << h.force, h.moment).finished());
}

control::CentroidalMomentum centroidal(const Question& c) {
  return control::centroidal_momentum(c.mechanism, c.workspace, c.q, c.v);
}

control::Pose pose(const Question& c) {
  return control::link_pose(c.mechanism, c.q, c.request.frame);
}

// clang-format off
constexpr Quantity kQuantities[] = {
    {"tau", "M a + C v + g [N·m, N]", Shape::kCovector,
     [](const Question& c) -> Answer {
       return MatrixXd(control::inverse_dynamics(c.mechanism, c.workspace, c.q, c.v, c.a)); }},
    {"g", "gravity covector dV: holds the arm at rest [N·m, N]", Shape::kCovector,
     [](const Question& c) -> Answer {
       return MatrixXd(control::gravity(c.mechanism, c.workspace, c.q)); }},
    {"Cv", "Coriolis covector C(q, v) v, Christoffel symbols of the first kind [N·m, N]",
     Shape::kBias,
     [](const Question& c) -> Answer {
       return MatrixXd(control::coriolis_matrix(c.mechanism, c.workspace, c.q, c.v) * c.v); }},
    {"M", "the metric: kinetic energy is v' M v / 2 [kg·m², kg·m, kg]", Shape::kMetric,
     [](const Question& c) -> Answer { return control::metric(c.mechanism, c.workspace, c.q); }},
    {"Minv", "inverse of M; null if singular", Shape::kInverse, inverse},
    {"C", "Coriolis matrix of the Levi-Civita connection: dM/dt = C + C'", Shape::kCoriolis,
     [](const Question& c) -> Answer {
       return control::coriolis_matrix(c.mechanism, c.workspace, c.q, c.v); }},
    {"Mdot", "dM/dt along v", Shape::kMetricRate,
     [](const Question& c) -> Answer {
       return control::metric_rate(c.mechanism, c.workspace, c.q, c.v); }},
    {"kinetic_energy", "T [J]", Shape::kNumber,
     [](const Question& c) -> Answer {
       return control::kinetic_energy(c.mechanism, c.workspace, c.q, c.v); }},
    {"potential_energy", "V = -sum of mass * gravity . centre of mass [J]", Shape::kNumber,
     [](const Question& c) -> Answer {
       return control::potential_energy(c.mechanism, c.workspace, c.q); }},
    {"J_ee", "Jacobian of the link --frame: velocity of its origin, angular velocity; world axes",
     Shape::kColumns,
     [](const Question& c) -> Answer {
       return MatrixXd(control::jacobian(c.mechanism, c.workspace, c.q, c.request.frame)); }},
    {"ee_R", "its axes in the world", Shape::kPlain,
     [](const Question& c) -> Answer { return MatrixXd(pose(c).rotation); }},
    {"ee_p", "its origin in the world [m]", Shape::kPlain,
     [](const Question& c) -> Answer { return MatrixXd(pose(c).translation); }},
    {"com", "centre of mass of all that moves [m]", Shape::kPlain,
     [](const Question& c) -> Answer { return MatrixXd(centroidal(c).centre_of_mass); }},
    {"vcom", "its velocity [m/s]", Shape::kPlain,
     [](const Question& c) -> Answer { return MatrixXd(centroidal(c).velocity); }},
    {"hg_linear", "linear momentum, world axes [kg·m/s]", Shape::kPlain,
     [](const Question& c) -> Answer { return MatrixXd(centroidal(c).linear); }},
    {"hg_angular", "angular momentum about the centre of mass [kg·m²/s]", Shape::kPlain,
     [](const Question& c) -> Answer { return MatrixXd(centroidal(c).angular); }},
    {"christoffel_first_kind", "[i][j][k] = (dM_ij/dq_k + dM_ik/dq_j - dM_jk/dq_i) / 2",
     Shape::kTable, first_kind},
    {"christoffel_second_kind", "[i][j][k]: the first kind, first index raised by Minv",
     Shape::kMixedTable, second_kind},
    {"dMdq", "[i][j][k] = dM_ij/dq_k", Shape::kTable, metric_slope},
    {"bias", "C v + g, one pass: what the loop calls [N·m, N]", Shape::kBias,
     [](const Question& c) -> Answer {
       return MatrixXd(control::bias(c.mechanism, c.workspace, c.q, c.v)); }},
    {"momentum", "p = M v: flat of v [N·m·s, N·s]", Shape::kCovector,
     [](const Question& c) -> Answer {
       return MatrixXd(control::flat(c.mechanism, c.workspace, c.q, c.v)); }},
    {"flat", "M x, x by --x (v)", Shape::kCovector,
     [](const Question& c) -> Answer {
       return MatrixXd(control::flat(c.mechanism, c.workspace, c.q, first(c))); }},
    {"sharp", "Minv p, p by --p (tau)", Shape::kVector,
     [](const Question& c) -> Answer {
       return or_null(control::sharp(c.mechanism, c.workspace, c.q, covector(c))); }},
    {"acceleration", "dv/dt that the torque --p (tau) causes", Shape::kAcceleration,
     [](const Question& c) -> Answer {
       return or_null(control::forward_dynamics(c.mechanism, c.workspace, c.q, c.v, covector(c)));
     }},
    {"geodesic_acceleration", "dv/dt of the geodesic: without gravity and torque",
     Shape::kAcceleration,
     [](const Question& c) -> Answer {
       return or_null(control::geodesic_acceleration(c.mechanism, c.workspace, c.q, c.v)); }},
    {"gradV", "gradient of V by the metric: sharp of g", Shape::kVector,
     [](const Question& c) -> Answer {
       return or_null(control::potential_gradient(c.mechanism, c.workspace, c.q)); }},
    {"covariant_acceleration", "Dv/dt = a + nabla_v v: sharp of tau - g", Shape::kVector,
     [](const Question& c) -> Answer {
       return or_null(
           control::covariant_derivative(c.mechanism, c.workspace, c.q, c.v, c.v, c.a)); }},
    {"curvature", "sectional curvature of every two coordinate directions [1/(kg·m²)]",
     Shape::kMetric, curvature_table},
    {"sectional_curvature", "of the directions --x (v) and --y [1/(kg·m²)]", Shape::kNumber,
     [](const Question& c) -> Answer {
       return or_null(control::sectional_curvature(c.mechanism, c.workspace, c.q, first(c),
                                                   second(c))); }},
    {"curvature_covector", "of R(x, y) y, by --x (v) and --y", Shape::kCovector,
     [](const Question& c) -> Answer {
       return or_null(control::curvature_covector(c.mechanism, c.workspace, c.q, first(c),
                                                  second(c), second(c))); }},
    {"Jdot_ee", "dJ/dt of the link --frame along v", Shape::kColumnsRate,
     [](const Question& c) -> Answer {
       return MatrixXd(
           control::jacobian_rate(c.mechanism, c.workspace, c.q, c.v, c.request.frame)); }},
    {"cmm", "centroidal momentum matrix: (hg_linear, hg_angular) = cmm v", Shape::kColumns,
     [](const Question& c) -> Answer {
       return MatrixXd(control::centroidal_momentum_matrix(c.mechanism, c.workspace, c.q)); }},
    {"spatial_momentum", "linear, and angular about the world's origin", Shape::kPlain,
     momentum_in_space},
    {"momentum_map", "of the rigid motion --motion, or of three translations and three rotations; "
     "null where the mechanism cannot move so", Shape::kPlain, momentum_map},
    {"tau_ext", "J' f of the wrenches --wrench [N·m, N]", Shape::kCovector,
     [](const Question& c) -> Answer {
       return MatrixXd(
           control::external_torque(c.mechanism, c.workspace, c.q, c.request.wrenches)); }},
    {"tau_motors", "M a + C v + g - tau_ext: what the motors add [N·m, N]", Shape::kCovector,
     [](const Question& c) -> Answer {
       return MatrixXd(control::inverse_dynamics(c.mechanism, c.workspace, c.q, c.v, c.a,
                                                 c.request.wrenches)); }},
    {"regressor", "Y with tau = Y pi", Shape::kRows, regressor},
    {"pi", "ten parameters a body (m, m c, Ixx, Ixy, Ixz, Iyy, Iyz, Izz at its joint), then rotors",
     Shape::kPlain,
     [](const Question& c) -> Answer { return MatrixXd(control::parameters(c.mechanism)); }},
};
// clang-format on

}  // namespace

std::span<const Quantity> quantities() {
  return kQuantities;
}

std::string list_quantities() {
  std::string text;
  for (const Quantity& quantity : kQuantities) {
    text += fmt::format("  {:<24}{}\n", quantity.name, quantity.meaning);
  }
  return text;
}

const Quantity& find_quantity(const std::string& name) {
  for (const Quantity& quantity : kQuantities) {
    if (name == quantity.name) return quantity;
  }
  throw BadInput(
      fmt::format("--what: there is no quantity '{}'; there are:\n{}", name, list_quantities()));
}

}  // namespace geodesic::tools
