// Implements suspect.hpp.
#include "control/safety/suspect.hpp"

#include <limits>

#include "control/mechanism/forward_dynamics.hpp"
#include "control/mechanism/kinematics.hpp"

namespace geodesic::control {

Suspicion suspect_load(const Mechanism& mechanism, Workspace& workspace,
                       const LoadEvidence& evidence, std::uint32_t group, int link) noexcept {
  const auto joints = static_cast<std::size_t>(mechanism.dof());
  const auto size = static_cast<Eigen::Index>(joints);
  const std::array<double, kMaxJoints>& external = evidence.external;
  const Eigen::Map<const Eigen::VectorXd> position(evidence.position.data(), size);
  const Eigen::Map<const Eigen::VectorXd> velocity(evidence.velocity.data(), size);
  std::array<double, kMaxJoints> all{};
  for (std::size_t i = 0; i < joints; ++i) {
    all[i] = evidence.drive[i] + external[i];
  }
  const Eigen::VectorXd* acceleration =
      forward_dynamics(mechanism, workspace, position, velocity,
                       Eigen::Map<const Eigen::VectorXd>(all.data(), size));
  const Jacobian& columns = jacobian(mechanism, workspace, position, link);
  Eigen::Vector3d rise = -mechanism.gravity();
  for (Eigen::Index i = 0; acceleration != nullptr && i < size; ++i) {
    rise += (*acceleration)[i] * columns.col(i).head<3>();
  }
  std::array<double, kMaxJoints> unit_load{};
  for (std::size_t i = 0; i < joints; ++i) {
    unit_load[i] = columns.col(static_cast<Eigen::Index>(i)).head<3>().dot(rise);
  }
  double squares = 0.0;
  const auto fit = [&](const std::array<double, kMaxJoints>& shape, double& factor) {
    double along = 0.0;
    double length = 0.0;
    squares = 0.0;
    for (std::size_t i = 0; i < joints; ++i) {
      if ((group >> i & 1U) != 0) {
        along -= shape[i] * external[i];
        length += shape[i] * shape[i];
        squares += external[i] * external[i];
      }
    }
    factor = length > 0.0 ? along / length : 0.0;
    return length > 0.0 ? squares - factor * along : std::numeric_limits<double>::infinity();
  };
  double scale = 0.0;
  double load_kg = 0.0;
  const double left_by_mass = fit(all, scale);
  const double left_by_load = fit(unit_load, load_kg);
  if (left_by_load < left_by_mass && left_by_load <= 0.5 * squares) {
    return {Suspect::kPayload, load_kg};
  }
  if (left_by_mass <= 0.5 * squares) {
    return {Suspect::kWrongMass, scale};
  }
  return {};
}

}  // namespace geodesic::control
