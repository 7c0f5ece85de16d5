// Implements articulated_body.hpp.
//
// An articulated inertia is kept as three 3 x 3 blocks: force = L a + H b, moment = H' a + J b for
// the accelerations a (linear) and b (angular). A rigid body has L = m 1, H = -hat(first moment).
#include "control/mechanism/articulated_body.hpp"

#include <cassert>

#include "control/mechanism/joint_motion.hpp"
#include "control/mechanism/kinematics.hpp"

namespace geodesic::control {
namespace {

using State = Workspace::ArticulatedState;

Wrench times(const State& state, const Twist& a) noexcept {
  return {state.linear * a.linear + state.coupling * a.angular,
          state.coupling.transpose() * a.linear + state.angular * a.angular};
}

/// Factors the pivot block L D L' in place. False where the joint meets no inertia.
bool factor(std::array<std::array<double, 6>, 6>& a, int size) noexcept {
  constexpr double kSingular = 1e-14;  // as in TreeCholesky
  for (std::size_t k = 0; k < static_cast<std::size_t>(size); ++k) {
    const double diagonal = a[k][k];
    for (std::size_t j = 0; j < k; ++j) {
      a[k][k] -= a[k][j] * a[k][j] * a[j][j];
    }
    if (!(a[k][k] > kSingular * diagonal)) {
      return false;
    }
    for (std::size_t i = k + 1; i < static_cast<std::size_t>(size); ++i) {
      for (std::size_t j = 0; j < k; ++j) {
        a[i][k] -= a[i][j] * a[k][j] * a[j][j];
      }
      a[i][k] /= a[k][k];
    }
  }
  return true;
}

/// What the joint lets its parent feel: the inertia less what accelerates the joint instead, and
/// the wrench at zero acceleration of the parent.
void yield(State& state, int freedom) noexcept {
  const auto n = static_cast<std::size_t>(freedom);
  for (std::size_t k = 0; k < n; ++k) {  // columns L^-1 U', one after the other
    for (std::size_t j = 0; j < k; ++j) {
      state.column[k] += -state.pivot[k][j] * state.column[j];
      state.torque[k] -= state.pivot[k][j] * state.torque[j];
    }
  }
  for (std::size_t k = 0; k < n; ++k) {
    const Wrench& u = state.column[k];
    const double share = 1.0 / state.pivot[k][k];
    state.linear -= (share * u.force) * u.force.transpose();
    state.coupling -= (share * u.force) * u.moment.transpose();
    state.angular -= (share * u.moment) * u.moment.transpose();
    state.rest += (share * state.torque[k]) * u;
  }
  state.rest += times(state, state.drift);
}

void add_to_parent(const Pose& pose, const State& child, State& parent) noexcept {
  const Eigen::Matrix3d& r = pose.rotation;
  const Eigen::Matrix3d shift = hat(pose.translation);
  const Eigen::Matrix3d linear = r * child.linear * r.transpose();
  const Eigen::Matrix3d turned = r * child.coupling * r.transpose();
  const Eigen::Matrix3d coupling = turned - linear * shift;
  parent.linear += linear;
  parent.coupling += coupling;
  parent.angular +=
      r * child.angular * r.transpose() + shift * coupling - turned.transpose() * shift;
  parent.rest += to_parent(pose, child.rest);
}

/// Inwards over one body; false where its joint meets no inertia.
bool eliminate(const Mechanism& mechanism, Workspace& workspace, std::size_t i,
               const VectorIn& tau) noexcept {
  const Body& body = mechanism.bodies()[i];
  State& state = workspace.articulated[i];
  const int freedom = freedoms(body.motion);
  for (int k = 0; k < freedom; ++k) {
    const auto at = static_cast<std::size_t>(k);
    state.column[at] = times(state, axis(body, k));
    for (int j = 0; j < freedom; ++j) {
      state.pivot[static_cast<std::size_t>(j)][at] = along_axis(body, state.column[at], j);
    }
    state.pivot[at][at] += mechanism.rotor_inertia()[body.dof + k];
    state.torque[at] = tau[body.dof + k] - along_axis(body, state.rest, k);
  }
  if (!factor(state.pivot, freedom)) {
    return false;
  }
  yield(state, freedom);
  if (body.parent != kWorld) {
    add_to_parent(workspace.body[i].parent_from_body, state,
                  workspace.articulated[static_cast<std::size_t>(body.parent)]);
  }
  return true;
}

}  // namespace

const Eigen::VectorXd* articulated_body_acceleration(const Mechanism& mechanism,
                                                     Workspace& workspace, const VectorIn& q,
                                                     const VectorIn& v,
                                                     const VectorIn& tau) noexcept {
  assert(tau.size() == mechanism.dof());
  const auto& bodies = mechanism.bodies();
  int freedom = 0;
  for (const Body& body : bodies) {
    freedom += freedoms(body.motion);
  }
  if (freedom != mechanism.dof()) {
    return nullptr;
  }
  update_velocities(mechanism, workspace, q, v);
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const RigidInertia& inertia = bodies[i].inertia;
    const Twist& velocity = workspace.body[i].velocity;
    State& state = workspace.articulated[i];
    state.linear = inertia.mass * Eigen::Matrix3d::Identity();
    state.coupling = -hat(inertia.first_moment);
    state.angular = inertia.rotational;
    state.rest = cross(velocity, inertia * velocity);
    state.drift = cross(velocity, joint_twist(bodies[i], v));
  }
  for (std::size_t i = bodies.size(); i-- > 0;) {
    if (!eliminate(mechanism, workspace, i, tau)) {
      return nullptr;
    }
  }
  // Outwards; gravity is an upward acceleration of the world.
  Eigen::VectorXd& result = workspace.forward_dynamics;
  const Twist world{-mechanism.gravity(), Eigen::Vector3d::Zero()};
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const Body& body = bodies[i];
    State& state = workspace.articulated[i];
    const Twist& parent = body.parent == kWorld
                              ? world
                              : workspace.body[static_cast<std::size_t>(body.parent)].acceleration;
    const Twist handed_on = to_child(workspace.body[i].parent_from_body, parent) + state.drift;
    const int n = freedoms(body.motion);
    // The columns were reduced by the pivot's L, so its transpose is left to solve.
    std::array<double, 6>& rate = state.torque;
    for (int k = n; k-- > 0;) {
      const auto at = static_cast<std::size_t>(k);
      rate[at] = (rate[at] - dot(state.column[at], handed_on)) / state.pivot[at][at];
      for (std::size_t j = at + 1; j < static_cast<std::size_t>(n); ++j) {
        rate[at] -= state.pivot[j][at] * rate[j];
      }
      result[body.dof + k] = rate[at];
    }
    workspace.body[i].acceleration = handed_on + joint_twist(body, result);
  }
  return &result;
}

}  // namespace geodesic::control
