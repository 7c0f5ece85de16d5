// Implements external_torque.hpp.
#include "control/safety/external_torque.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "control/friction.hpp"
#include "control/mechanism/momentum_balance.hpp"

namespace geodesic::control {
namespace {

// After a longer gap the last sample is too old to compare with.
constexpr double kLongestGapPeriods = 10.0;
// Stamps that come closer than this part of a period are taken together.
constexpr double kShortestPeriods = 0.25;

double commanded(const JointCommand& command, double position, double velocity) noexcept {
  if (command.mode != DriveMode::kEnable) {
    return 0.0;
  }
  return command.torque + command.stiffness * (command.position - position) +
         command.damping * (command.velocity - velocity);
}

}  // namespace

std::array<BitSet, kMaxJoints> coupled_joints(const Mechanism& mechanism) {
  std::array<BitSet, kMaxJoints> sets{};
  const auto& bodies = mechanism.bodies();
  std::vector<std::size_t> root(bodies.size());
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    root[i] = bodies[i].parent == kWorld ? i : root[static_cast<std::size_t>(bodies[i].parent)];
  }
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    for (std::size_t k = 0; k < bodies.size(); ++k) {
      if (root[i] == root[k]) {
        sets[static_cast<std::size_t>(bodies[i].dof)] |=
            bit(static_cast<std::size_t>(bodies[k].dof));
      }
    }
  }
  return sets;
}

ExternalTorque::ExternalTorque(const Mechanism& mechanism)
    : joints_(std::min<std::size_t>(static_cast<std::size_t>(mechanism.dof()), kMaxJoints)),
      coupled_(coupled_joints(mechanism)) {}

void ExternalTorque::rebase() noexcept {
  for (Joint& joint : joint_) {
    joint.based = false;
  }
  observed_ = 0;
}

void ExternalTorque::update(const ControllerOptions& options, const Mechanism& mechanism,
                            Workspace& workspace, const ArmState& state, const Estimate& estimate,
                            const ArmCommand& sent, std::int64_t period_ns) noexcept {
  const double period_s = static_cast<double>(period_ns) * 1e-9;
  const double corner_rad_s = 2.0 * std::numbers::pi * options.contact.observer_hz;
  const double dt = static_cast<double>(std::clamp<std::int64_t>(estimate.instant_ns - instant_ns_,
                                                                 0, 1'000'000'000)) *
                    1e-9;
  instant_ns_ = estimate.instant_ns;
  std::array<double, kMaxJoints> velocity{};
  for (std::size_t i = 0; i < joints_; ++i) {
    Joint& joint = joint_[i];
    const JointTuning& tuning = options.joints[i];
    const bool fresh = has(estimate.fresh, i) && i < state.joints;
    const double before = joint.velocity;
    joint.velocity = fresh ? state.joint[i].velocity : joint.velocity;
    const double friction =
        compensate({tuning.coulomb_friction, tuning.viscous_friction, tuning.friction_velocity},
                   0.5 * (before + joint.velocity));
    joint.impulse += (joint.acting - friction) * dt;
    joint.elapsed_s += dt;
    joint.acting = fresh && options.contact.measured_torque
                       ? state.joint[i].torque
                       : commanded(sent.joint[i], estimate.position[i], joint.velocity);
    velocity[i] = joint.velocity;
  }
  if (estimate.known != first(joints_) || !(corner_rad_s > 0.0)) {
    rebase();
    return;
  }
  const auto size = static_cast<Eigen::Index>(joints_);
  momentum_balance(mechanism, workspace,
                   Eigen::Map<const Eigen::VectorXd>(estimate.position.data(), size),
                   Eigen::Map<const Eigen::VectorXd>(velocity.data(), size));
  for (std::size_t i = 0; i < joints_; ++i) {
    // Momentum is made of all velocities that move one another: of one instant, or of none.
    if ((estimate.fresh & coupled_[i]) == coupled_[i]) {
      const auto k = static_cast<Eigen::Index>(i);
      commit(i, workspace.joint_momentum[k], workspace.momentum_drift[k], corner_rad_s, period_s);
    } else if (joint_[i].elapsed_s > kLongestGapPeriods * period_s) {
      observed_ &= ~bit(i);
    }
  }
}

void ExternalTorque::commit(std::size_t index, double momentum, double drift, double corner_rad_s,
                            double period_s) noexcept {
  Joint& joint = joint_[index];
  if (joint.based && joint.elapsed_s < kShortestPeriods * period_s) {
    return;
  }
  if (joint.based && joint.elapsed_s <= kLongestGapPeriods * period_s) {
    const double mean_drive = joint.impulse / joint.elapsed_s;
    const double external =
        (momentum - joint.momentum) / joint.elapsed_s - mean_drive - 0.5 * (drift + joint.drift);
    // The same for all that answer together: one exponential a cycle.
    const double turn = corner_rad_s * joint.elapsed_s;
    weight_ = turn == turn_ ? weight_ : -std::expm1(-turn);
    turn_ = turn;
    const double weight = weight_;
    torque_[index] += weight * (external - torque_[index]);
    drive_torque_[index] += weight * (mean_drive - drive_torque_[index]);
    observed_ |= bit(index);
  } else {
    observed_ &= ~bit(index);
  }
  joint.momentum = momentum;
  joint.drift = drift;
  joint.impulse = 0.0;
  joint.elapsed_s = 0.0;
  joint.based = true;
}

}  // namespace geodesic::control
