// The supervisor's mechanism: counting, latching and the steps from state to state. What a fault
// leads to is not here but in policy.cpp.
#include "control/safety/supervisor.hpp"

#include <algorithm>
#include <bit>
#include <limits>

namespace geodesic::control {
namespace {

// Answers a joint must have given before it counts as connected: one may be left over from before.
constexpr std::uint16_t kAnswersToConnect = 3;

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
  for (std::size_t i = 0; i < kMaxJoints; ++i) {
    if (!has(options.joints, i)) {
      continue;
    }
    const bool answered = has(flags.fresh, i);
    memory.silent[i] = answered ? std::uint16_t{0} : increment(memory.silent[i]);
    memory.answers[i] = answered ? increment(memory.answers[i]) : memory.answers[i];
  }
  memory.overruns = flags.overran ? std::min(memory.overruns, 1'000'000) + 1 : 0;

  // A silent joint cannot be watched; what is left is to take it as it was predicted: at rest.
  const BitSet watched = options.joints & ~silent_joints(options, memory);
  const BitSet moving = makes_torque(memory.state) ? flags.unrested : flags.moving;
  if ((moving & watched) != 0) {
    memory.rest_since_ns = now_ns;
  }
}

/// Joints that are configured, without torque, and answering.
BitSet connected(const SupervisorOptions& options, const SupervisorMemory& memory,
                 const Flags& flags) noexcept {
  BitSet set = flags.disabled & ~silent_joints(options, memory);
  for (std::size_t i = 0; i < kMaxJoints; ++i) {
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
  const double elapsed = seconds_between(memory.since_ns, now_ns);
  std::array<BitSet, kFaults> present = flags.present;

  set_of(present, Fault::kJointSilent) = silent_joints(options, memory);
  set_of(present, Fault::kDriveRefused) = flags.refused;
  set_of(present, Fault::kDriveError) = flags.error;
  set_of(present, Fault::kDriveDisabled) = ~flags.enabled & ~flags.error & ~failed_drives(memory);
  set_of(present, Fault::kOverrun) =
      memory.overruns >= cycles_to_detect(Fault::kOverrun, safety) ? bit(0) : 0;
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
    const BitSet subjects = line.subject == Subject::kJoint ? options.joints
                            : line.subject == Subject::kBus ? options.buses
                                                            : bit(0);
    present[i] = looked_for ? present[i] & subjects : 0;
  }
  return present;
}

/// Adds to what is latched. Warnings and refusals go again after a while; faults never do.
void latch(const SupervisorOptions& options, SupervisorMemory& memory,
           const std::array<BitSet, kFaults>& present, std::int64_t now_ns) noexcept {
  for (std::size_t i = 0; i < kFaults; ++i) {
    memory.latched[i] |= present[i];
    if (present[i] != 0) {
      memory.seen_ns[i] = now_ns;
    } else if (memory.latched[i] != 0 &&
               clears_of(static_cast<Fault>(i), options.safety) == Clears::kItself &&
               seconds_between(memory.seen_ns[i], now_ns) > kRearmSeconds) {
      memory.latched[i] = 0;
      memory.reported[i] = 0;
    }
  }
}

void tell(const SupervisorOptions& options, SupervisorDecision& decision, std::int64_t now_ns,
          std::size_t room) noexcept {
  SupervisorMemory& memory = decision.memory;
  for (std::size_t i = 0; i < kFaults; ++i) {
    const BitSet fresh = memory.latched[i] & ~memory.reported[i];
    for (std::size_t k = 0;
         fresh != 0 && k < 32 && decision.events < std::min(room, kMaxEventsPerCycle); ++k) {
      if (!has(fresh, k)) {
        continue;
      }
      FaultEvent& event = decision.event[decision.events++];
      event.time_ns = now_ns;
      event.fault = static_cast<Fault>(i);
      event.action = action_of(event.fault, options.safety);
      const Subject subject = policy(event.fault).subject;
      event.joint = subject == Subject::kJoint ? static_cast<int>(k) : kNoJoint;
      event.bus = subject == Subject::kBus ? static_cast<int>(k) : -1;
      memory.reported[i] |= bit(k);
    }
  }
}

void lower(const SupervisorOptions& options, SupervisorMemory& memory, bool drives_only,
           std::int64_t now_ns) noexcept {
  memory.lower_from = memory.authority;
  memory.ramp_s = options.safety.lower_s;
  memory.drives_only = drives_only;
  enter(memory, SupervisorState::kLowering, now_ns);
}

/// Connecting, ready and enabling: on to the next, back to off, or to fault. No torque flows yet,
/// so that there is nothing to stop or to lower.
void step_before_torque(const SupervisorOptions& options, SupervisorMemory& memory,
                        const Flags& flags, std::int64_t now_ns) noexcept {
  const BitSet all = options.joints;
  if (worst_action(options, memory) >= Action::kControlledStop) {
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
    memory.ramp_s = options.safety.start_ramp_s;
  }
}

/// Active, stopping and lowering: down, as fast as the worst fault says.
void step_with_torque(const SupervisorOptions& options, SupervisorMemory& memory,
                      const Flags& flags, std::int64_t now_ns) noexcept {
  const SafetyOptions& safety = options.safety;
  const Action worst = worst_action(options, memory);
  const double elapsed = seconds_between(memory.since_ns, now_ns);
  // Nothing that is looked for here may cut torque at once: policy.cpp does not compile if it does.
  if (worst == Action::kDriveDamping && memory.state != SupervisorState::kLowering) {
    lower(options, memory, true, now_ns);
    return;
  }
  memory.drives_only = worst == Action::kDriveDamping;  // lowering goes on, in the time it has left
  if (memory.state == SupervisorState::kActive) {
    if (worst == Action::kControlledStop || flags.stop_requested) {
      enter(memory, SupervisorState::kStopping, now_ns);
    }
  } else if (memory.state == SupervisorState::kStopping) {
    const bool rested = seconds_between(memory.rest_since_ns, now_ns) >= safety.stop_rest_s;
    if (rested || elapsed >= safety.stop_timeout_s) {
      lower(options, memory, false, now_ns);
    }
  } else if (elapsed >= memory.ramp_s) {
    // Torque is gone; drives damp until the arm has come down, as far as encoders can tell.
    const bool rested =
        !memory.drives_only && seconds_between(memory.rest_since_ns, now_ns) >= safety.stop_rest_s;
    if (rested || elapsed >= memory.ramp_s + safety.settle_timeout_s) {
      const bool faulted = worst >= Action::kControlledStop;
      enter(memory, faulted ? SupervisorState::kFault : SupervisorState::kOff, now_ns);
    }
  }
}

/// The ramps. Once active has been left, authority never rises again.
double authority(const SupervisorMemory& memory, std::int64_t now_ns) noexcept {
  const double elapsed = seconds_between(memory.since_ns, now_ns);
  const double part = elapsed >= memory.ramp_s ? 1.0 : std::max(0.0, elapsed / memory.ramp_s);
  switch (memory.state) {
    case SupervisorState::kActive:
      return part;
    case SupervisorState::kStopping:
      return memory.authority;
    case SupervisorState::kLowering:
      return memory.drives_only ? 0.0 : memory.lower_from * (1.0 - part);
    default:
      return 0.0;
  }
}

}  // namespace

BitSet silent_joints(const SupervisorOptions& options, const SupervisorMemory& memory) noexcept {
  const int cycles = cycles_to_detect(Fault::kJointSilent, options.safety);
  BitSet set = 0;
  for (BitSet left = options.joints; left != 0; left &= left - 1) {  // not all 32: it is hot
    const auto i = static_cast<std::size_t>(std::countr_zero(left));
    set |= memory.silent[i] >= cycles ? bit(i) : 0;
  }
  return set;
}

bool is_late(const SupervisorOptions& options, const SupervisorMemory& memory,
             std::size_t joint) noexcept {
  return memory.silent[joint] >= options.safety.damp_cycles;
}

double law_share(const SupervisorOptions& options, const SupervisorMemory& memory,
                 std::size_t joint) noexcept {
  const SafetyOptions& safety = options.safety;
  const int missed = memory.silent[joint];
  if (missed < safety.damp_cycles) {
    return 1.0;
  }
  return std::max(0.0, static_cast<double>(safety.silent_cycles - missed) /
                           static_cast<double>(safety.silent_cycles - safety.damp_cycles + 1));
}

SupervisorState overall(SupervisorState one, SupervisorState other) noexcept {
  constexpr std::array<int, kSupervisorStates> kRank{0, 2, 3, 4, 7, 6, 5, 1};
  return kRank[static_cast<std::size_t>(one)] >= kRank[static_cast<std::size_t>(other)] ? one
                                                                                        : other;
}

bool has_own_fault(const SupervisorOptions& options, const SupervisorMemory& memory) noexcept {
  for (std::size_t i = 0; i < kFaults; ++i) {
    const auto fault = static_cast<Fault>(i);
    if (memory.latched[i] != 0 && fault != Fault::kOtherArm &&
        action_of(fault, options.safety) >= Action::kControlledStop) {
      return true;
    }
  }
  return false;
}

BitSet failed_drives(const SupervisorMemory& memory) noexcept {
  return memory.latched[static_cast<std::size_t>(Fault::kDriveError)] |
         memory.latched[static_cast<std::size_t>(Fault::kDriveDisabled)];
}

Action worst_action(const SupervisorOptions& options, const SupervisorMemory& memory) noexcept {
  Action worst = Action::kNone;
  for (std::size_t i = 0; i < kFaults; ++i) {
    if (memory.latched[i] != 0) {
      worst = std::max(worst, action_of(static_cast<Fault>(i), options.safety));
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
                             const Flags& flags, std::int64_t now_ns, std::size_t room) noexcept {
  SupervisorDecision decision;
  decision.memory = memory;
  SupervisorMemory& next = decision.memory;
  if (memory.state == SupervisorState::kOff || memory.state == SupervisorState::kFault) {
    const bool first_start = options.start_active && !memory.start_done;
    if (!flags.stop_requested && (flags.law_requested || first_start)) {
      begin(decision, now_ns);
    } else {
      tell(options, decision, now_ns, room);  // what did not fit into the cycle of the fault
      next.start_done = memory.start_done || flags.stop_requested;
    }
    return decision;
  }
  count(options, next, flags, now_ns);
  latch(options, next, detect(options, next, flags, now_ns), now_ns);
  if (makes_torque(next.state)) {
    step_with_torque(options, next, flags, now_ns);
  } else {
    step_before_torque(options, next, flags, now_ns);
  }
  next.authority = authority(next, now_ns);
  tell(options, decision, now_ns, room);
  return decision;
}

}  // namespace geodesic::control
