// Implements regressor.hpp.
#include "control/mechanism/regressor.hpp"

#include <Eigen/Geometry>
#include <cassert>

#include "control/mechanism/inertial_parameters.hpp"
#include "control/mechanism/joint_motion.hpp"
#include "control/mechanism/kinematics.hpp"

namespace geodesic::control {
namespace {

constexpr int kParameters = InertialParameters::RowsAtCompileTime;

/// Wrench on a body, about its origin, of a unit of parameter p; the origin accelerates by `linear`
/// (gravity included), turning is alpha, omega.
Wrench of_parameter(int p, const Eigen::Vector3d& linear, const Eigen::Vector3d& alpha,
                    const Eigen::Vector3d& omega) noexcept {
  if (p == 0) {
    return {linear, Eigen::Vector3d::Zero()};
  }
  if (p < 4) {
    const Eigen::Vector3d h = Eigen::Vector3d::Unit(p - 1);
    return {alpha.cross(h) + omega.cross(omega.cross(h)), h.cross(linear)};
  }
  constexpr int kRow[] = {0, 0, 0, 1, 1, 2};
  constexpr int kColumn[] = {0, 1, 2, 1, 2, 2};
  const int row = kRow[p - 4];
  const int column = kColumn[p - 4];
  const auto times = [&](const Eigen::Vector3d& x) {  // the unit inertia
    Eigen::Vector3d y = Eigen::Vector3d::Zero();
    y[row] += x[column];
    if (row != column) {
      y[column] += x[row];
    }
    return y;
  };
  return {Eigen::Vector3d::Zero(), times(alpha) + omega.cross(times(omega))};
}

}  // namespace

int parameter_count(const Mechanism& mechanism) noexcept {
  return kParameters * static_cast<int>(mechanism.bodies().size()) + mechanism.dof();
}

Eigen::VectorXd parameters(const Mechanism& mechanism) {
  Eigen::VectorXd result(parameter_count(mechanism));
  Eigen::Index at = 0;
  for (const Body& body : mechanism.bodies()) {
    result.segment<kParameters>(at) = to_parameters(body.inertia);
    at += kParameters;
  }
  result.tail(mechanism.dof()) = mechanism.rotor_inertia();
  return result;
}

void regressor(const Mechanism& mechanism, Workspace& workspace, const VectorIn& q,
               const VectorIn& v, const VectorIn& a, Eigen::Ref<Eigen::MatrixXd> result) noexcept {
  assert(a.size() == mechanism.dof() && result.rows() == mechanism.dof() &&
         result.cols() == parameter_count(mechanism));
  const auto& bodies = mechanism.bodies();
  update_velocities(mechanism, workspace, q, v);
  result.setZero();
  const Twist upwards{-mechanism.gravity(), Eigen::Vector3d::Zero()};
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const Body& body = bodies[i];
    auto& state = workspace.body[i];
    const Twist& parent = body.parent == kWorld
                              ? upwards
                              : workspace.body[static_cast<std::size_t>(body.parent)].acceleration;
    state.acceleration = to_child(state.parent_from_body, parent) + joint_twist(body, a) +
                         cross(state.velocity, joint_twist(body, v));
    const Eigen::Vector3d& omega = state.velocity.angular;
    const Eigen::Vector3d linear = state.acceleration.linear + omega.cross(state.velocity.linear);
    for (int p = 0; p < kParameters; ++p) {
      Wrench wrench = of_parameter(p, linear, state.acceleration.angular, omega);
      auto column = result.col(kParameters * static_cast<Eigen::Index>(i) + p);
      std::size_t at = i;
      while (true) {
        const Body& above = bodies[at];
        for (int k = 0; k < freedoms(above.motion); ++k) {
          column[above.dof + k] += along_axis(above, wrench, k);
        }
        if (above.parent == kWorld) {
          break;
        }
        wrench = to_parent(workspace.body[at].parent_from_body, wrench);
        at = static_cast<std::size_t>(above.parent);
      }
    }
  }
  const Eigen::Index rotors = kParameters * static_cast<Eigen::Index>(bodies.size());
  for (const Body& body : bodies) {
    if (freedoms(body.motion) == 1) {
      result(body.dof, rotors + body.dof) = a[body.dof];
    }
  }
}

}  // namespace geodesic::control
