// Comparison of one cycle's measurements with the options; no memory but what is handed in.
#include "control/safety/assess.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "control/safety/limits.hpp"

namespace geodesic::control {
namespace {

BitSet& present(Flags& flags, Fault fault) noexcept {
  return flags.present[static_cast<std::size_t>(fault)];
}

BitSet when(bool condition, std::size_t index) noexcept {
  return condition ? bit(index) : 0;
}

void assess_joint(const ControllerOptions& options, const JointState& joint,
                  const Estimate& estimate, std::size_t i, Flags& flags) noexcept {
  const JointTuning& tuning = options.joints[i];
  const double speed = std::abs(estimate.velocity[i]);
  const bool known = has(estimate.known, i);
  const bool fresh = has(estimate.fresh, i);

  flags.disabled |= when(joint.condition == DriveCondition::kDisabled, i);
  flags.enabled |= when(joint.condition == DriveCondition::kEnabled, i);
  flags.error |= when(joint.condition == DriveCondition::kError, i);
  flags.refused |= when(joint.condition == DriveCondition::kRefused, i);

  flags.moving |= when(known && !(speed < options.safety.start_velocity), i);
  flags.unrested |= when(known && !(speed < options.safety.stop_rest_velocity), i);
  flags.outside |= when(known && outside_limits(tuning, estimate.position[i]), i);

  present(flags, Fault::kPositionLimit) |= flags.outside & bit(i);
  present(flags, Fault::kVelocityLimit) |= when(known && !(speed <= tuning.velocity_limit), i);
  present(flags, Fault::kTemperatureWarn) |=
      when(fresh && !(joint.temperature_c < tuning.temperature_warn_c), i);
  present(flags, Fault::kTemperatureLimit) |=
      when(fresh && !(joint.temperature_c < tuning.temperature_limit_c), i);
}

double finite_or_zero(double value) noexcept {
  return std::isfinite(value) ? value : 0.0;
}

}  // namespace

Flags assess(const ControllerOptions& options, const ArmState& state, const Estimate& estimate,
             const BoundFindings& bounds) noexcept {
  Flags flags;
  flags.overran = state.overran;
  flags.fresh = estimate.fresh;
  const std::size_t joints = std::min(options.joints.size(), kMaxJoints);
  for (std::size_t i = 0; i < joints; ++i) {
    // A state that holds fewer joints than there are says of the others that nothing is known.
    assess_joint(options, i < state.joints ? state.joint[i] : JointState{}, estimate, i, flags);
  }
  present(flags, Fault::kEncoderJump) = estimate.jumped;
  present(flags, Fault::kNotFinite) = estimate.not_finite | bounds.not_finite;
  present(flags, Fault::kTorqueSaturated) = bounds.saturated;
  present(flags, Fault::kForbiddenCall) = when(state.forbidden_call != 0, 0);

  const std::size_t buses = std::min(state.buses, kMaxBuses);
  for (std::size_t i = 0; i < buses; ++i) {
    const BusState& bus = state.bus[i];
    present(flags, Fault::kBusDown) |= when(bus.down, i);
    present(flags, Fault::kBusOff) |= when(bus.bus_off, i);
    present(flags, Fault::kBusErrorPassive) |= when(bus.error_passive, i);
    present(flags, Fault::kBusStalled) |= when(bus.stalled, i);
    present(flags, Fault::kForeignCommander) |= when(bus.foreign_commander, i);
  }
  return flags;
}

void add_evidence(FaultEvent& event, const ControllerOptions& options, const ArmState& state,
                  const Estimate& estimate, const BoundFindings& bounds,
                  const SupervisorMemory& memory) noexcept {
  const SafetyOptions& safety = options.safety;
  const std::size_t joints = std::min(options.joints.size(), kMaxJoints);
  const auto i = static_cast<std::size_t>(std::max(event.joint, 0));
  if (i >= joints) {
    return;
  }
  const JointTuning& tuning = options.joints[i];
  const auto set = [&event](double found, double limit) {
    event.found = finite_or_zero(found);
    event.limit = finite_or_zero(limit);
  };
  switch (event.fault) {
    case Fault::kJointSilent:
      return set(memory.silent[i], safety.silent_cycles);
    case Fault::kDriveError:
      return set(state.joint[i].drive_error, 0.0);
    case Fault::kPositionLimit:
    case Fault::kStartOutsideLimits:
      return set(estimate.position[i], nearest_limit(tuning, estimate.position[i]));
    case Fault::kVelocityLimit:
      return set(estimate.velocity[i], tuning.velocity_limit);
    case Fault::kNotAtRest:
      return set(estimate.velocity[i], safety.start_velocity);
    case Fault::kTemperatureWarn:
      return set(state.joint[i].temperature_c, tuning.temperature_warn_c);
    case Fault::kTemperatureLimit:
      return set(state.joint[i].temperature_c, tuning.temperature_limit_c);
    case Fault::kTorqueSaturated:
      return set(bounds.wanted[i], tuning.torque_limit);
    case Fault::kEncoderJump:
      return set(estimate.step[i], estimate.allowed_step[i]);
    case Fault::kOverrun:
      return set(memory.overruns, safety.overrun_cycles);
    case Fault::kConnectTimeout:
      return set(safety.connect_timeout_s, safety.connect_timeout_s);
    case Fault::kEnableTimeout:
      return set(estimate.velocity[i], safety.start_velocity);
    case Fault::kForbiddenCall:
      return set(state.forbidden_call - 1, 0.0);
    case Fault::kDriveRefused:
    case Fault::kDriveDisabled:
    case Fault::kNotFinite:
    case Fault::kBusDown:
    case Fault::kBusOff:
    case Fault::kBusErrorPassive:
    case Fault::kBusStalled:
    case Fault::kForeignCommander:
    case Fault::kContact:
    case Fault::kVibration:
    case Fault::kVibrationPersists:
    case Fault::kStaticTorque:
    case Fault::kEncoderStuck:
    case Fault::kOtherArm:
    case Fault::kCount:
      break;  // nothing was measured; the fault says it all
  }
}

}  // namespace geodesic::control
