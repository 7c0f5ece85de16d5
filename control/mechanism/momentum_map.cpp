// Implements momentum_map.hpp.
#include "control/mechanism/momentum_map.hpp"

#include <Eigen/QR>
#include <array>
#include <cassert>

#include "control/mechanism/configuration.hpp"
#include "control/mechanism/connection.hpp"
#include "control/mechanism/coriolis.hpp"
#include "control/mechanism/gravity.hpp"
#include "control/mechanism/joint_motion.hpp"
#include "control/mechanism/kinematics.hpp"
#include "control/mechanism/metric.hpp"
#include "control/mechanism/musical.hpp"

namespace geodesic::control {
namespace {

Eigen::Matrix<double, 6, 1> six(const Twist& twist) noexcept {
  Eigen::Matrix<double, 6, 1> result;
  result << twist.linear, twist.angular;
  return result;
}

bool massive(const Body& body) noexcept {
  return body.inertia.mass != 0.0 || !body.inertia.rotational.isZero(0.0);
}

/// Whether a body has matter and nothing that carries it does: where the twist has to come from.
bool first_of_matter(const Mechanism& mechanism, const Body& body) noexcept {
  if (!massive(body)) {
    return false;
  }
  for (int at = body.parent; at != kWorld;) {
    const Body& above = mechanism.bodies()[static_cast<std::size_t>(at)];
    if (massive(above)) {
      return false;
    }
    at = above.parent;
  }
  return true;
}

/// Rates of the joints on the way from the world to body `index` that come closest to moving it
/// with the twist (of space). False if there are more than six.
bool follow(const Mechanism& mechanism, const Workspace& workspace, std::size_t index,
            const Twist& twist, Eigen::Ref<Eigen::VectorXd> result) noexcept {
  Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, 6> columns(6, 6);
  std::array<int, 6> dof{};
  int count = 0;
  for (int at = static_cast<int>(index); at != kWorld;) {
    const Body& body = mechanism.bodies()[static_cast<std::size_t>(at)];
    const Pose from_world = inverse(workspace.world_from_body[static_cast<std::size_t>(at)]);
    for (int k = 0; k < freedoms(body.motion); ++k) {
      if (count == 6) {
        return false;
      }
      columns.col(count) = six(to_child(from_world, axis(body, k)));
      dof[static_cast<std::size_t>(count++)] = body.dof + k;
    }
    at = body.parent;
  }
  columns.conservativeResize(6, count);
  const Eigen::Matrix<double, 6, 1> wanted = six(twist);
  const Eigen::ColPivHouseholderQR<Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, 6>> qr(columns);
  const Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 6, 1> rates = qr.solve(wanted);
  for (int i = 0; i < count; ++i) {
    result[dof[static_cast<std::size_t>(i)]] = rates[i];
  }
  return true;
}

}  // namespace

double momentum_map(const Mechanism& mechanism, Workspace& workspace, const VectorIn& q,
                    const VectorIn& v, const VectorIn& xi) noexcept {
  assert(xi.size() == mechanism.dof());
  return flat(mechanism, workspace, q, v).dot(xi);
}

void field_derivative(const Mechanism& mechanism, Workspace& workspace, const VectorIn& q,
                      const VectorField& xi, Eigen::Ref<Eigen::MatrixXd> result) {
  assert(result.rows() == mechanism.dof() && result.cols() == mechanism.dof());
  constexpr double kStep = 0.02;
  constexpr double kWeight[] = {45.0 / 60.0, -9.0 / 60.0, 1.0 / 60.0};
  result.setZero();
  Eigen::VectorXd& along = workspace.unit_velocity;
  along.setZero();
  for (Eigen::Index i = 0; i < result.cols(); ++i) {
    along[i] = 1.0;
    for (int point = 1; point <= 3; ++point) {
      for (const double sign : {1.0, -1.0}) {
        integrate(mechanism, q, along, sign * point * kStep, workspace.configuration);
        xi(workspace.configuration, workspace.generator);
        result.col(i) += (sign * kWeight[point - 1] / kStep) * workspace.generator;
      }
    }
    along[i] = 0.0;
  }
}

const Eigen::MatrixXd& lie_derivative_of_metric(
    const Mechanism& mechanism, Workspace& workspace, const VectorIn& q, const VectorIn& xi,
    const Eigen::Ref<const Eigen::MatrixXd>& xi_derivative) noexcept {
  assert(xi.size() == mechanism.dof() && xi_derivative.cols() == xi.size());
  // [xi, E_i] = xi_k [E_k, E_i] - E_i(xi_k) E_k, column i; here with the sign changed.
  Eigen::MatrixXd& bracket = workspace.field_bracket;
  Eigen::VectorXd& unit = workspace.unit_velocity;
  unit.setZero();
  for (Eigen::Index i = 0; i < xi.size(); ++i) {
    unit[i] = 1.0;
    frame_bracket(mechanism, xi, unit, bracket.col(i));
    unit[i] = 0.0;
  }
  bracket = xi_derivative - bracket;
  Eigen::MatrixXd& result = workspace.lie_derivative;
  result = metric_rate(mechanism, workspace, q, xi);
  const Eigen::MatrixXd& m = metric(mechanism, workspace, q);
  result += m.lazyProduct(bracket);
  result += bracket.transpose().lazyProduct(m);
  return result;
}

double momentum_map_rate(const Mechanism& mechanism, Workspace& workspace, const VectorIn& q,
                         const VectorIn& v, const VectorIn& tau, const VectorIn& xi,
                         const Eigen::Ref<const Eigen::MatrixXd>& xi_derivative) noexcept {
  const Eigen::MatrixXd& lie = lie_derivative_of_metric(mechanism, workspace, q, xi, xi_derivative);
  double twice = 0.0;
  for (Eigen::Index j = 0; j < v.size(); ++j) {
    twice += v[j] * lie.col(j).dot(v);
  }
  return 0.5 * twice + tau.dot(xi) - gravity(mechanism, workspace, q).dot(xi);
}

bool rigid_motion(const Mechanism& mechanism, Workspace& workspace, const VectorIn& q,
                  const Twist& twist, Eigen::Ref<Eigen::VectorXd> result) noexcept {
  assert(result.size() == mechanism.dof());
  const auto& bodies = mechanism.bodies();
  update_poses(mechanism, workspace, q);
  result.setZero();
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (first_of_matter(mechanism, bodies[i]) && !follow(mechanism, workspace, i, twist, result)) {
      return false;
    }
  }
  // Whether all matter really moves so.
  const double scale = 1.0 + twist.linear.norm() + twist.angular.norm();
  update_velocities(mechanism, workspace, q, result);
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const Twist wanted = to_child(workspace.world_from_body[i], twist);
    const Twist missing = wanted + (-1.0) * workspace.body[i].velocity;
    constexpr double kRounding = 1e-9;
    if (massive(bodies[i]) && !(six(missing).norm() <= kRounding * scale)) {
      return false;
    }
  }
  return true;
}

}  // namespace geodesic::control
