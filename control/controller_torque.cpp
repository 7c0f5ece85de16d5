// What leaves for each joint: the law's torque or the stop's, its share where replies are missing,
// walls, fading of an exchanged setup, bounds, and the drive's mode and damping.
#include <cmath>

#include "control/controller_impl.hpp"
#include "control/law/law.hpp"
#include "control/safety/limits.hpp"

namespace geodesic::control {

double Controller::Impl::wanted_torque(std::size_t joint, double model_torque) const noexcept {
  const JointTuning& tuning = options().joints[joint];
  const SupervisorMemory& own = memory_of(joint);
  const LawInput input{report.position[joint], report.velocity[joint], model_torque,
                       reference[joint]};
  const StaticCheck& check = watch.static_check();
  if (has(check.limp(), joint)) {
    return 0.0;  // whatever is asked of it, it does the opposite; or that is being found out
  }
  const double gain = watch.gain(joint);
  const double wall = gain * wall_torque(tuning, input.position, input.velocity);
  const double spring = check.spring(tuning, joint, input.position, input.velocity,
                                     input.model_torque, own.authority);
  switch (own.state) {
    case SupervisorState::kActive: {
      const LawKind runs = damps[arm_of(joint)] ? LawKind::kDamp : law[arm_of(joint)];
      double torque = law_torque(runs, tuning, input);
      const double share = gain * law_share(supervisor_of(joint), own, joint);
      if (share < 1.0 && runs != LawKind::kZero) {
        torque = input.model_torque + share * (torque - input.model_torque);
      }
      return own.authority * (torque + wall) + (runs != LawKind::kZero ? spring : 0.0);
    }
    case SupervisorState::kStopping: {
      // Compensation as far as it had come; the damping whole, since it only ever brakes.
      const double damping = gain * (damp_torque(tuning, input) - input.model_torque);
      return own.authority * (input.model_torque + wall) + damping + spring;
    }
    case SupervisorState::kLowering:
      return own.authority * (input.model_torque + wall) + lowering_scale(joint) * spring;
    default:
      return 0.0;
  }
}

/// What lowering has left of the torque; only ever falls, and is 1 before it.
double Controller::Impl::lowering_scale(std::size_t joint) const noexcept {
  const SupervisorMemory& own = memory_of(joint);
  if (own.state != SupervisorState::kLowering) {
    return 1.0;
  }
  return own.lower_from > 0.0 ? own.authority / own.lower_from : 0.0;
}

void Controller::Impl::write_torque(std::size_t joint, double wanted, double period_s) noexcept {
  const JointTuning& tuning = options().joints[joint];
  const Retune& fading = retune[joint];
  const double blended = fading.torque(wanted, tuning.torque_limit, lowering_scale(joint));
  const BoundedTorque bounded = bound_torque(tuning, fading.limit(tuning.torque_limit), blended,
                                             last_torque[joint], period_s);
  JointCommand& out = command.joint[joint];
  out.torque = bounded.torque;
  bounds.wanted[joint] = wanted;
  bounds.saturated |= std::abs(wanted) > tuning.torque_limit ? bit(joint) : 0;
  if (!bounded.finite) {
    bounds.not_finite |= bit(joint);
    out.damping = tuning.drive_damping;
  }
}

void Controller::Impl::write_command(const ArmState& state, double period_s) noexcept {
  bounds.saturated = 0;
  bounds.not_finite = 0;
  report.retuning = false;
  for (std::size_t i = 0; i < joints; ++i) {
    const SupervisorMemory& own = memory_of(i);
    const bool torque_flows = makes_torque(own.state) && !own.drives_only;
    const bool failed = has(failed_drives(own), i);
    const DriveCondition condition =
        i < state.joints ? state.joint[i].condition : DriveCondition::kUnknown;
    JointCommand& out = command.joint[i];
    out.mode = drive_mode(own, i, condition);
    out.torque = 0.0;
    out.position = report.position[i];
    out.velocity = 0.0;
    out.stiffness = 0.0;
    retune[i].advance(period_s);
    if (!makes_torque(own.state) || failed) {
      retune[i] = Retune{};
    }
    report.retuning |= retune[i].under_way();
    // A joint that is not seen cannot be damped from here; its drive may still hear us.
    const bool drive_damps = own.state == SupervisorState::kLowering ||
                             (makes_torque(own.state) && is_late(supervisor_of(i), own, i));
    const bool reversed = has(watch.static_check().reversed(), i);
    out.damping = drive_damps && !failed && !reversed
                      ? retune[i].damping(options().joints[i].drive_damping)
                      : 0.0;
    if (torque_flows && !failed) {
      write_torque(i, wanted_torque(i, report.model_torque[i]), period_s);
    }
    last_torque[i] = out.torque;
  }
}

}  // namespace geodesic::control
