// What must hold on every transition, by counters that know nothing of the supervisor's own.
#include "tests/control/safety/explorer_node.hpp"

namespace geodesic::control::testing {
namespace {

using enum SupervisorState;

bool awake(SupervisorState state) {
  return state != kOff && state != kFault;
}

/// What must have been found in this cycle, by the checker's own counters.
Action must_find(const SupervisorOptions& options, const Node& before, const Node& after,
                 const Flags& flags) {
  const auto state = static_cast<SupervisorState>(before.state);
  const SafetyOptions& safety = options.safety;
  Action worst = Action::kNone;
  const auto find = [&](Fault fault, BitSet set) {
    const FaultPolicy& line = policy(fault);
    const BitSet of = line.subject == Subject::kJoint ? options.joints
                      : line.subject == Subject::kBus ? options.buses
                                                      : bit(0);
    if ((set & of) != 0 && has(line.states, before.state)) {
      worst = std::max(worst, action_of(fault, safety));
    }
  };
  BitSet silent = 0;
  BitSet answered = 0;
  for (std::size_t i = 0; i < 2; ++i) {
    silent |= after.g_silent[i] >= safety.silent_cycles ? bit(i) : 0;
    answered |= after.g_answers[i] >= 3 ? bit(i) : 0;
  }
  const BitSet good = flags.enabled & flags.fresh & ~flags.moving & ~flags.outside;
  const double age_s = (before.g_age + 1) * kStepS;
  for (std::size_t i = 0; i < kFaults; ++i) {
    const auto fault = static_cast<Fault>(i);
    switch (fault) {
      case Fault::kJointSilent:
        find(fault, silent);
        break;
      case Fault::kDriveError:
        find(fault, state == kConnecting && age_s < safety.connect_timeout_s ? 0 : flags.error);
        break;
      case Fault::kDriveRefused:
        find(fault, flags.refused);
        break;
      case Fault::kDriveDisabled:
        find(fault, ~flags.enabled & ~flags.error & ~BitSet{before.failed});
        break;
      case Fault::kOverrun:
        find(fault, after.g_overruns >= safety.overrun_cycles ? 1 : 0);
        break;
      case Fault::kConnectTimeout:
        find(fault, age_s >= safety.connect_timeout_s
                        ? ~(flags.disabled & answered & ~silent) & ~flags.error
                        : 0);
        break;
      case Fault::kEnableTimeout:
        find(fault, age_s >= safety.enable_timeout_s ? ~good & ~flags.error : 0);
        break;
      case Fault::kNotAtRest:
        find(fault, flags.moving);
        break;
      case Fault::kStartOutsideLimits:
        find(fault, flags.outside);
        break;
      default:
        find(fault, flags.present[i]);
    }
  }
  return worst;
}

}  // namespace

/// The checker's counters after a step.
void count(const SupervisorOptions& options, const Node& before, Node& after, const Flags& flags) {
  const auto from = static_cast<SupervisorState>(before.state);
  const auto to = static_cast<SupervisorState>(after.state);
  if (!awake(from)) {
    return;  // all zero: a start begins anew
  }
  for (std::size_t i = 0; i < 2; ++i) {
    const bool is = has(options.joints, i);
    after.g_silent[i] = is && !has(flags.fresh, i) ? capped(before.g_silent[i] + 1, 2) : 0;
    after.g_answers[i] = is && (from == kConnecting)
                             ? capped(before.g_answers[i] + (has(flags.fresh, i) ? 1 : 0), 3)
                             : 0;
  }
  after.g_overruns = flags.overran && to != kLowering ? capped(before.g_overruns + 1, 2) : 0;
  const bool timed = to == kConnecting || to == kEnabling;
  after.g_age = timed && from == to ? capped(before.g_age + 1, 4) : 0;
  const bool rests = to == kReady || from == kReady;
  const bool moves = (flags.moving & options.joints) != 0;
  after.g_rest = !rests || moves ? 0 : capped(before.g_rest + 1, kMostRest);
  const bool down = to == kStopping || to == kLowering;
  after.g_down = down ? capped(before.g_down + 1, kMostDown) : 0;
}

/// What a transition breaks; null: nothing.
const char* broken(const SupervisorOptions& options, const Node& before, Node& after,
                   const Flags& flags, const SupervisorDecision& decision) {
  const auto from = static_cast<SupervisorState>(before.state);
  const auto to = static_cast<SupervisorState>(after.state);
  const SafetyOptions& safety = options.safety;
  const double authority = decision.memory.authority;
  if (authority != 0.0 && !makes_torque(to)) return "torque in a state without torque";
  if (authority < 0.0 || authority > 1.0) return "authority outside 0..1";
  if (decision.memory.drives_only && makes_torque(to) && authority != 0.0) {
    return "compensation on encoders that are not trusted";
  }
  if (from == kActive && to == kActive) {
    if (authority > before.authority / 8.0 + kStepS / safety.start_ramp_s + 1e-9) {
      return "authority rises faster than start_ramp_s";
    }
  } else if (to == kActive) {
    if (authority != 0.0) return "active does not begin with authority 0";
  } else if (authority > before.authority / 8.0) {
    return "authority rises outside active";
  }
  for (std::size_t i = 0; i < 2; ++i) {
    for (const DriveCondition is : {DriveCondition::kDisabled, DriveCondition::kEnabled}) {
      const bool enable = drive_mode(decision.memory, i, is) == DriveMode::kEnable;
      if (enable && !makes_torque(to) && to != kEnabling) return "a drive is enabled too early";
      if (enable && makes_torque(to) && has(failed_drives(decision.memory), i)) {
        return "a failed drive is enabled";
      }
    }
  }
  if (!awake(from)) {
    if (to != from && to != kConnecting) return "off or fault leads elsewhere than connecting";
    if (to == kConnecting && flags.stop_requested) return "a start in spite of a stop";
    if (to == kConnecting && !flags.law_requested &&
        (from == kFault || before.start_done != 0 || !options.start_active)) {
      return "a start that nobody asked for";
    }
    return nullptr;
  }
  const Action worst = must_find(options, before, after, flags);
  after.g_fault = before.g_fault != 0 || worst >= Action::kControlledStop ? 1 : 0;
  if (worst >= Action::kControlledStop) {
    if (!makes_torque(from) && to != kFault) return "a fault before torque does not end in fault";
    if (worst == Action::kDriveDamping && makes_torque(from) &&
        !(to == kLowering && decision.memory.drives_only) && to != kFault) {
      return "encoders are trusted in spite of a fault";
    }
    if (from == kActive && to == kActive) return "a fault does not end active in its cycles";
    if (worst_action(options, decision.memory) < worst) return "a fault is not latched";
  }
  if (after.g_fault != 0 && to == kOff) return "a fault has cleared by itself: off";
  if (after.g_fault != 0 && to != kFault &&
      worst_action(options, decision.memory) < Action::kControlledStop) {
    return "a fault has cleared by itself";
  }
  if (flags.stop_requested) {
    if (!makes_torque(from) && to != kOff && to != kFault) return "a stop is not followed";
    if (to == kActive) return "a stop does not end active";
  }
  const BitSet all = options.joints;
  if (to == kEnabling && from != kEnabling) {
    if (from != kReady) return "enabling not from ready";
    if (after.g_rest * kStepS < safety.stop_rest_s) return "enabling without rest";
    if ((flags.outside & all) != 0) return "enabling outside limits";
    if ((flags.fresh & flags.disabled & all) != all) return "enabling without fresh replies";
  }
  if (to == kReady && from != kReady) {
    if (from != kConnecting) return "ready not from connecting";
    for (std::size_t i = 0; i < 2; ++i) {
      if (has(all, i) && after.g_answers[i] < 3) return "ready without replies";
    }
  }
  if (to == kActive && from != kActive) {
    if (from != kEnabling) return "active not from enabling";
    const BitSet good = flags.enabled & flags.fresh & ~flags.moving & ~flags.outside;
    if ((good & all) != all) return "active without rest, limits, freshness or enabled drives";
  }
  if (makes_torque(from) && !makes_torque(to) && from != kLowering) {
    return "torque is cut without lowering";
  }
  const double bound_s = safety.stop_timeout_s + safety.lower_s + safety.settle_timeout_s;
  if (after.g_down * kStepS > bound_s + 2 * kStepS) return "a stop does not end within its bound";
  return nullptr;
}

}  // namespace geodesic::control::testing
