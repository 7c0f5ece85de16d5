// Implements energy.hpp.
#include "control/mechanism/energy.hpp"

#include "control/mechanism/kinematics.hpp"
#include "control/mechanism/momentum.hpp"

namespace geodesic::control {

double kinetic_energy(const Mechanism& mechanism, Workspace& workspace, const VectorIn& q,
                      const VectorIn& v) noexcept {
  update_velocities(mechanism, workspace, q, v);
  double twice = 0.0;
  for (std::size_t i = 0; i < mechanism.bodies().size(); ++i) {
    const Twist& velocity = workspace.body[i].velocity;
    twice += dot(mechanism.bodies()[i].inertia * velocity, velocity);
  }
  for (Eigen::Index i = 0; i < v.size(); ++i) {
    twice += mechanism.rotor_inertia()[i] * v[i] * v[i];
  }
  return 0.5 * twice;
}

double potential_energy(const Mechanism& mechanism, Workspace& workspace,
                        const VectorIn& q) noexcept {
  return -mechanism.gravity().dot(first_moment(mechanism, workspace, q));
}

}  // namespace geodesic::control
