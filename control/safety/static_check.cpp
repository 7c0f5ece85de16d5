// Implements static_check.hpp.
#include "control/safety/static_check.hpp"

#include <algorithm>
#include <cmath>

#include "control/mechanism/metric.hpp"

namespace geodesic::control {
namespace {

constexpr double kDampingRatio = 0.7;
constexpr double kFadeSeconds = 0.3;
constexpr double kCarriedSeconds = 0.05;  // on the spring, during the ramp
constexpr double kRestedSeconds = 0.3;    // elsewhere, after it
constexpr double kSmoothSeconds = 0.004;
constexpr double kElsewhere = 0.05;  // [rad or m]

/// Zero inside [low, high], else the distance, signed.
double beyond(double value, double low, double high) noexcept {
  return value < low ? value - low : (value > high ? value - high : 0.0);
}

}  // namespace

const char* to_string(StaticCheckState state) noexcept {
  constexpr std::array<const char*, 4> kNames{"off", "passed", "pending", "failed"};
  const auto index = static_cast<std::size_t>(state);
  return index < kNames.size() ? kNames[index] : "?";
}

StaticCheck::StaticCheck(const std::array<BitSet, kMaxJoints>& coupled) noexcept
    : coupled_(coupled) {}

void StaticCheck::begin(const ControllerOptions& options, const Mechanism& mechanism,
                        Workspace& workspace, const std::array<double, kMaxJoints>& position,
                        BitSet entering) noexcept {
  failed_ &= ~entering;
  reversed_ &= ~entering;
  probed_ &= ~entering;
  const Eigen::MatrixXd& inertia = metric(
      mechanism, workspace, Eigen::Map<const Eigen::VectorXd>(position.data(), mechanism.dof()));
  for (std::size_t i = 0; i < static_cast<std::size_t>(mechanism.dof()); ++i) {
    if (!has(entering, i)) {
      continue;
    }
    Joint& joint = joint_[i];
    joint = Joint{};
    if (options.safety.start_ramp_s > 0.0 &&
        std::isfinite(options.joints[i].static_torque_tolerance)) {
      joint.state = StaticCheckState::kPending;
      joint.fade = 1.0;
    }
    const auto k = static_cast<Eigen::Index>(i);
    joint.reference = position[i];
    joint.stiffness = kStiffness_rad_s * kStiffness_rad_s * inertia(k, k);
    joint.damping = 2.0 * kDampingRatio * kStiffness_rad_s * inertia(k, k);
  }
}

double StaticCheck::spring(const JointTuning& tuning, std::size_t index, double position,
                           double velocity, double model, double authority) const noexcept {
  const Joint& joint = joint_[index];
  if (!(joint.fade > 0.0)) {
    return 0.0;
  }
  const double withheld = (1.0 - authority) * model;
  const double margin = tuning.static_torque_tolerance + joint.held;
  return joint.fade *
         std::clamp(joint.stiffness * (joint.reference - position) - joint.damping * velocity,
                    std::min(withheld, 0.0) - margin, std::max(withheld, 0.0) + margin);
}

void StaticCheck::Mean::add(double one_external, double one_drive) noexcept {
  ++samples;
  external += (one_external - external) / samples;
  drive += (one_drive - drive) / samples;
}

void StaticCheck::update(const ControllerOptions& options, const StaticCheckInput& input) noexcept {
  const std::size_t joints = std::min(options.joints.size(), kMaxJoints);
  for (std::size_t i = 0; i < joints; ++i) {
    Joint& joint = joint_[i];
    const bool ramping = input.authority[i] < 1.0;
    const double weight = std::min(1.0, input.period_s / kSmoothSeconds);
    smooth_external_[i] += weight * (input.external[i] - smooth_external_[i]);
    smooth_drive_[i] += weight * (input.drive[i] - smooth_drive_[i]);
    // What holds an arm that failed goes on holding it while it is stopped.
    if (!ramping && (failed_ & coupled_[i]) == 0) {
      joint.fade = std::max(0.0, joint.fade - input.period_s / kFadeSeconds);
    }
    if (joint.state == StaticCheckState::kOff || !has(input.observed, i)) {
      probed_ &= ~bit(i);  // a stop has come in between: it holds
      continue;
    }
    judge(options, input, i);
  }
}

void StaticCheck::prove(const ControllerOptions& options, const StaticCheckInput& input,
                        std::size_t i, bool outside) noexcept {
  Joint& joint = joint_[i];
  if (has(failed_, i)) {
    return;
  }
  const double external = input.external[i];
  const double drive = input.drive[i];
  // Once it is probed, it is probed to the end.
  joint.outside_s = outside || has(probed_, i) ? joint.outside_s + input.period_s : 0.0;
  if (joint.outside_s == 0.0) {
    joint.before = Mean{};
    joint.after = Mean{};
  } else if (joint.outside_s < kProofSeconds) {
    if (joint.outside_s > 0.5 * kProofSeconds) {
      joint.before.add(external, drive);
    }
  } else if (joint.outside_s < kProofSeconds + kProbeSeconds) {
    if (!has(probed_, i)) {
      proven_external_ = smooth_external_;
      proven_drive_ = smooth_drive_;
    }
    probed_ |= bit(i);
    if (joint.outside_s > kProofSeconds + 0.5 * kProbeSeconds) {
      joint.after.add(external, drive);
    }
  } else {
    probed_ &= ~bit(i);
    fail(options, input, i);
  }
}

void StaticCheck::fail(const ControllerOptions& options, const StaticCheckInput& input,
                       std::size_t i) noexcept {
  Joint& joint = joint_[i];
  failed_ |= bit(i);
  joint.state = StaticCheckState::kFailed;
  joint.excess = -joint.before.external;
  const double less_drive = joint.before.drive - joint.after.drive;
  const double more_external = joint.after.external - joint.before.external;
  // Twice if reversed; a load that falls with it about once, more if others let go as well.
  if (more_external * less_drive > 1.75 * less_drive * less_drive) {
    reversed_ |= bit(i);
    return;
  }
  // Torque acts as told: hold the pose with whatever it takes while the arm is stopped. What was
  // measured of a load that fell says too little of it.
  for (std::size_t k = 0; k < options.joints.size(); ++k) {
    if (has(coupled_[i] & input.observed & ~reversed_, k)) {
      joint_[k].held = options.joints[k].torque_limit;
    }
  }
}

void StaticCheck::judge(const ControllerOptions& options, const StaticCheckInput& input,
                        std::size_t i) noexcept {
  Joint& joint = joint_[i];
  const double tolerance = options.joints[i].static_torque_tolerance;
  const double external = input.external[i];
  if (input.authority[i] < 1.0) {
    const double withheld = (1.0 - input.authority[i]) * input.model[i];
    const double outside =
        beyond(external, std::min(withheld, 0.0) - tolerance, std::max(withheld, 0.0) + tolerance);
    prove(options, input, i, outside != 0.0);
    const bool carries = std::abs(external) < tolerance && std::abs(withheld) > 2.0 * tolerance;
    joint.carried_s = carries ? joint.carried_s + input.period_s : 0.0;
    if (joint.state == StaticCheckState::kPending && joint.carried_s >= kCarriedSeconds) {
      joint.state = StaticCheckState::kPassed;
    }
    return;
  }
  const bool rests = std::abs(input.velocity[i]) < options.safety.stop_rest_velocity &&
                     std::abs(input.position[i] - joint.reference) > kElsewhere &&
                     std::abs(external) < tolerance;
  joint.carried_s = rests ? joint.carried_s + input.period_s : 0.0;
  if (joint.state == StaticCheckState::kPending && joint.carried_s >= kRestedSeconds) {
    joint.state = StaticCheckState::kPassed;
  }
}

StaticCheckState StaticCheck::state() const noexcept {
  StaticCheckState worst = StaticCheckState::kOff;
  for (const Joint& joint : joint_) {
    worst = std::max(worst, joint.state);
  }
  return worst;
}

}  // namespace geodesic::control
