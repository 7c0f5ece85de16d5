// The supervisor's mechanism: counting, latching and the steps from state to state. What a fault
// leads to is not here but in policy.cpp.
#include "control/safety/supervisor.hpp"

#include <algorithm>
#include <limits>

namespace geodesic::control {
namespace {

// Answers a joint must have given before it counts as connected: one may be left over from before.
constexpr std::uint16_t kAnswersToConnect = 3;
// A warning is told again only after the condition has been away for this long.
constexpr double kRearmSeconds = 1.0;

double seconds_between(std::int64_t from_ns, std::int64_t to_ns) noexcept {
  return (static_cast<double>(to_ns) - static_cast<double>(from_ns)) * 1e-9;
}

BitSet& set_of(std::array<BitSet, kFaults>& sets, Fault fault) noexcept {
  return sets[static_cast<std::size_t>(fault)];
}

std::uint16_t increment(std::uint16_t count) noexcept {
  return count == std::numeric_limits<std::uint16_t>::max() ? count
                                                            : static_cast<std::uint16_t>(count + 1);
}

void enter(SupervisorMemory& memory, SupervisorState state, std::int64_t now_ns) noexcept {
  memory.state = state;
  memory.since_ns = now_ns;
  memory.rest_since_ns = now_ns;
}

/// Off or fault -> connecting, everything forgotten.
void begin(SupervisorDecision& decision, std::int64_t now_ns) noexcept {
  decision.memory = SupervisorMemory{};
  decision.memory.start_done = true;
  decision.restart_drives = true;
  enter(decision.memory, SupervisorState::kConnecting, now_ns);
}

void count(const SupervisorOptions& options, SupervisorMemory& memory, const Flags& flags,
           std::int64_t now_ns) noexcept {
  for (std::size_t i = 0; i < options.joints; ++i) {
    const bool answered = has(flags.fresh, i);
    memory.silent[i] = answered ? std::uint16_t{0} : increment(memory.silent[i]);
    memory.answers[i] = answered ? increment(memory.answers[i]) : memory.answers[i];
  }
  memory.overruns = flags.overran ? std::min(memory.overruns, 1'000'000) + 1 : 0;

  // A silent joint cannot be watched; what is left is to take it as it was predicted: at rest.
  const BitSet watched = first(options.joints) & ~silent_joints(options, memory);
  const BitSet moving = memory.state == SupervisorState::kStopping ? flags.unrested : flags.moving;
  if ((moving & watched) != 0) {
    memory.rest_since_ns = now_ns;
  }
}

/// Joints that are configured, without torque, and answering.
BitSet connected(const SupervisorOptions& options, const SupervisorMemory& memory,
                 const Flags& flags) noexcept {
  BitSet set = flags.disabled & ~silent_joints(options, memory);
  for (std::size_t i = 0; i < options.joints; ++i) {
    if (memory.answers[i] < kAnswersToConnect) {
      set &= ~bit(i);
    }
  }
  return set;
}

/// Joints that may be given torque: enabled, answering, at rest, inside their limits.
BitSet startable(const Flags& flags) noexcept {
  return flags.enabled & flags.fresh & ~flags.moving & ~flags.outside;
}

/// All conditions present in this cycle, of those the table looks for in this state.
std::array<BitSet, kFaults> detect(const SupervisorOptions& options, const SupervisorMemory& memory,
                                   const Flags& flags, std::int64_t now_ns) noexcept {
  const SafetyOptions& safety = options.safety;
  const BitSet all = first(options.joints);
  const double elapsed = seconds_between(memory.since_ns, now_ns);
  std::array<BitSet, kFaults> present = flags.present;

  set_of(present, Fault::kJointSilent) = silent_joints(options, memory);
  set_of(present, Fault::kDriveRefused) = flags.refused;
  set_of(present, Fault::kDriveError) = flags.error;
  set_of(present, Fault::kDriveDisabled) = ~flags.enabled & ~flags.error & ~failed_drives(memory);
  set_of(present, Fault::kOverrun) = memory.overruns >= safety.overrun_cycles ? bit(0) : 0;
  set_of(present, Fault::kNotAtRest) = flags.moving;
  set_of(present, Fault::kStartOutsideLimits) = flags.outside;
  set_of(present, Fault::kConnectTimeout) = 0;
  if (memory.state == SupervisorState::kConnecting) {
    // An error may be cleared by the dialogue; what still has one in the end is told so.
    const bool late = elapsed >= safety.connect_timeout_s;
    const BitSet missing = late ? ~connected(options, memory, flags) & ~flags.refused : 0;
    set_of(present, Fault::kDriveError) = missing & flags.error;
    set_of(present, Fault::kConnectTimeout) = missing & ~flags.error;
  }
  set_of(present, Fault::kEnableTimeout) =
      elapsed >= safety.enable_timeout_s ? ~startable(flags) & ~flags.error : 0;

  for (std::size_t i = 0; i < kFaults; ++i) {
    const FaultPolicy& line = policy(static_cast<Fault>(i));
    const bool looked_for = has(line.states, static_cast<std::size_t>(memory.state));
    const BitSet subjects = line.subject == Subject::kJoint ? all
                            : line.subject == Subject::kBus ? first(kMaxBuses)
                                                            : bit(0);
    present[i] = looked_for ? present[i] & subjects : 0;
  }
  return present;
}

/// Adds to what is latched. Warnings and refusals go again after a while; faults never do.
void latch(SupervisorMemory& memory, const std::array<BitSet, kFaults>& present,
           std::int64_t now_ns) noexcept {
  for (std::size_t i = 0; i < kFaults; ++i) {
    memory.latched[i] |= present[i];
    if (present[i] != 0) {
      memory.seen_ns[i] = now_ns;
    } else if (policy(static_cast<Fault>(i)).action < Action::kControlledStop &&
               seconds_between(memory.seen_ns[i], now_ns) > kRearmSeconds) {
      memory.latched[i] = 0;
      memory.reported[i] = 0;
    }
  }
}

void tell(SupervisorDecision& decision, std::int64_t now_ns) noexcept {
  SupervisorMemory& memory = decision.memory;
  for (std::size_t i = 0; i < kFaults; ++i) {
    const BitSet fresh = memory.latched[i] & ~memory.reported[i];
    for (std::size_t k = 0; fresh != 0 && k < 32 && decision.events < kMaxEventsPerCycle; ++k) {
      if (!has(fresh, k)) {
        continue;
      }
      FaultEvent& event = decision.event[decision.events++];
      event.time_ns = now_ns;
      event.fault = static_cast<Fault>(i);
      const Subject subject = policy(event.fault).subject;
      event.joint = subject == Subject::kJoint ? static_cast<int>(k) : kNoJoint;
      event.bus = subject == Subject::kBus ? static_cast<int>(k) : -1;
      memory.reported[i] |= bit(k);
    }
  }
}

void lower(SupervisorMemory& memory, bool drives_only, std::int64_t now_ns) noexcept {
  memory.lower_from = memory.authority;
  memory.drives_only = drives_only;
  enter(memory, SupervisorState::kLowering, now_ns);
}

/// Connecting, ready and enabling: on to the next, back to off, or to fault. No torque flows yet,
/// so that there is nothing to stop or to lower.
void step_before_torque(const SupervisorOptions& options, SupervisorMemory& memory,
                        const Flags& flags, std::int64_t now_ns) noexcept {
  const BitSet all = first(options.joints);
  if (worst_action(memory) >= Action::kControlledStop) {
    enter(memory, SupervisorState::kFault, now_ns);
    return;
  }
  if (flags.stop_requested) {
    enter(memory, SupervisorState::kOff, now_ns);
    return;
  }
  if (memory.state == SupervisorState::kConnecting) {
    if (connected(options, memory, flags) == all) {
      enter(memory, SupervisorState::kReady, now_ns);
    }
  } else if (memory.state == SupervisorState::kReady) {
    const bool rested =
        seconds_between(memory.rest_since_ns, now_ns) >= options.safety.stop_rest_s &&
        (flags.moving & all) == 0;
    const bool reporting = (flags.fresh & flags.disabled & all) == all;
    if (rested && reporting && (flags.outside & all) == 0) {
      enter(memory, SupervisorState::kEnabling, now_ns);
    }
  } else if ((startable(flags) & all) == all) {
    enter(memory, SupervisorState::kActive, now_ns);
  }
}

/// Active, stopping and lowering: down, as fast as the worst fault says.
void step_with_torque(const SupervisorOptions& options, SupervisorMemory& memory,
                      const Flags& flags, std::int64_t now_ns) noexcept {
  const SafetyOptions& safety = options.safety;
  const Action worst = worst_action(memory);
  const double elapsed = seconds_between(memory.since_ns, now_ns);
  // Nothing that is looked for here may cut torque at once: policy.cpp does not compile if it does.
  if (worst == Action::kDriveDamping && !memory.drives_only) {
    lower(memory, true, now_ns);
  } else if (memory.state == SupervisorState::kActive) {
    if (worst == Action::kControlledStop || flags.stop_requested) {
      enter(memory, SupervisorState::kStopping, now_ns);
    }
  } else if (memory.state == SupervisorState::kStopping) {
    const bool rested = seconds_between(memory.rest_since_ns, now_ns) >= safety.stop_rest_s;
    if (rested || elapsed >= safety.stop_timeout_s) {
      lower(memory, false, now_ns);
    }
  } else if (elapsed >= safety.lower_s) {
    const bool faulted = worst >= Action::kControlledStop;
    enter(memory, faulted ? SupervisorState::kFault : SupervisorState::kOff, now_ns);
  }
}

/// The ramps. Once active has been left, authority never rises again.
double authority(const SupervisorOptions& options, const SupervisorMemory& memory,
                 std::int64_t now_ns) noexcept {
  const double elapsed = seconds_between(memory.since_ns, now_ns);
  const auto part = [elapsed](double whole_s) {
    return elapsed >= whole_s ? 1.0 : std::max(0.0, elapsed / whole_s);
  };
  switch (memory.state) {
    case SupervisorState::kActive:
      return part(options.safety.start_ramp_s);
    case SupervisorState::kStopping:
      return memory.authority;
    case SupervisorState::kLowering:
      return memory.drives_only ? 0.0 : memory.lower_from * (1.0 - part(options.safety.lower_s));
    default:
      return 0.0;
  }
}

}  // namespace

BitSet silent_joints(const SupervisorOptions& options, const SupervisorMemory& memory) noexcept {
  BitSet set = 0;
  for (std::size_t i = 0; i < options.joints; ++i) {
    set |= memory.silent[i] >= options.safety.silent_cycles ? bit(i) : 0;
  }
  return set;
}

BitSet failed_drives(const SupervisorMemory& memory) noexcept {
  return memory.latched[static_cast<std::size_t>(Fault::kDriveError)] |
         memory.latched[static_cast<std::size_t>(Fault::kDriveDisabled)];
}

Action worst_action(const SupervisorMemory& memory) noexcept {
  Action worst = Action::kNone;
  for (std::size_t i = 0; i < kFaults; ++i) {
    if (memory.latched[i] != 0) {
      worst = std::max(worst, policy(static_cast<Fault>(i)).action);
    }
  }
  return worst;
}

DriveMode drive_mode(const SupervisorMemory& memory, std::size_t joint,
                     DriveCondition condition) noexcept {
  switch (memory.state) {
    case SupervisorState::kConnecting:
    case SupervisorState::kReady:
      // A drive left enabled by somebody before us is disabled first.
      return condition == DriveCondition::kEnabled ? DriveMode::kDisable : DriveMode::kMonitor;
    case SupervisorState::kEnabling:
      return DriveMode::kEnable;
    case SupervisorState::kActive:
    case SupervisorState::kStopping:
    case SupervisorState::kLowering:
      return has(failed_drives(memory), joint) ? DriveMode::kDisable : DriveMode::kEnable;
    case SupervisorState::kOff:
    case SupervisorState::kFault:
      break;
  }
  return condition == DriveCondition::kDisabled ? DriveMode::kMonitor : DriveMode::kDisable;
}

SupervisorDecision supervise(const SupervisorOptions& options, const SupervisorMemory& memory,
                             const Flags& flags, std::int64_t now_ns) noexcept {
  SupervisorDecision decision;
  decision.memory = memory;
  SupervisorMemory& next = decision.memory;
  if (memory.state == SupervisorState::kOff || memory.state == SupervisorState::kFault) {
    const bool first_start = options.start_active && !memory.start_done;
    if (!flags.stop_requested && (flags.law_requested || first_start)) {
      begin(decision, now_ns);
    } else {
      tell(decision, now_ns);  // what did not fit into the cycle of the fault
      next.start_done = memory.start_done || flags.stop_requested;
    }
    return decision;
  }
  count(options, next, flags, now_ns);
  latch(next, detect(options, next, flags, now_ns), now_ns);
  if (makes_torque(next.state)) {
    step_with_torque(options, next, flags, now_ns);
  } else {
    step_before_torque(options, next, flags, now_ns);
  }
  next.authority = authority(options, next, now_ns);
  tell(decision, now_ns);
  return decision;
}

}  // namespace geodesic::control
