// The policy table: every fault with its meaning, where it is looked for, what is done, and how it
// clears. Only the policy; the mechanism that applies it is in supervisor.cpp.
#include <initializer_list>

#include "control/safety/supervisor.hpp"

namespace geodesic::control {
namespace {

using enum SupervisorState;

constexpr BitSet states(std::initializer_list<SupervisorState> list) {
  BitSet set = 0;
  for (const SupervisorState state : list) {
    set |= bit(static_cast<std::size_t>(state));
  }
  return set;
}

// Off and fault look for nothing: the drives are disabled, and a person has to ask for a start.
constexpr BitSet kAwake = states({kConnecting, kReady, kEnabling, kActive, kStopping, kLowering});
constexpr BitSet kConnected = states({kReady, kEnabling, kActive, kStopping, kLowering});
constexpr BitSet kBeforeTorque = states({kConnecting, kReady, kEnabling});
constexpr BitSet kTorque = states({kActive, kStopping, kLowering});
// Lowering is left out where the answer would be to lower: sagging onto a stop is no new fault.
constexpr BitSet kHolding = states({kActive, kStopping});
constexpr BitSet kWarm = states({kReady, kEnabling, kActive, kStopping});

using enum Subject;
using enum Clears;
using Action::kControlledStop, Action::kDriveDamping, Action::kRefuse, Action::kTorqueOff,
    Action::kWarn;
using Within::kEncoderWay, Within::kHalfCycles, Within::kNextCycle, Within::kOverrunCycles,
    Within::kSilentCycles, Within::kStartRamp, Within::kThisCycle;

constexpr std::array<FaultPolicy, kFaults> kTable{{
    {Fault::kJointSilent, "joint_silent", "no reply from the drive",
     "replies counted, silent_cycles in a row missing", kJoint, kConnected, kSilentCycles,
     kControlledStop, kOperator},
    {Fault::kDriveError, "drive_error",
     "the drive reports an error; it is disabled while the others stop",
     "error code in its reply; at connecting, if the dialogue has not cleared it in time", kJoint,
     kAwake, kThisCycle, kControlledStop, kOperator},
    {Fault::kDriveRefused, "drive_refused",
     "what the drive reports of itself contradicts the configuration",
     "its registers read back and compared", kJoint, kBeforeTorque, kThisCycle, kTorqueOff,
     kOperator},
    {Fault::kDriveDisabled, "drive_disabled",
     "the drive left the enabled state without being told; it stays disabled while the others stop",
     "state in its reply", kJoint, kTorque, kThisCycle, kControlledStop, kOperator},
    {Fault::kPositionLimit, "position_limit", "position beyond the hard limit and its tolerance",
     "position against position_lower, position_upper", kJoint, kHolding, kThisCycle,
     kControlledStop, kOperator},
    {Fault::kVelocityLimit, "velocity_limit", "velocity beyond the limit",
     "filtered velocity against velocity_limit", kJoint, kHolding, kThisCycle, kControlledStop,
     kOperator},
    {Fault::kTemperatureWarn, "temperature_warn", "the drive is warm",
     "reported temperature against temperature_warn_c", kJoint, kWarm, kThisCycle, kWarn, kItself},
    {Fault::kTemperatureLimit, "temperature_limit", "the drive is too hot",
     "reported temperature against temperature_limit_c", kJoint, kWarm, kThisCycle, kControlledStop,
     kOperator},
    {Fault::kTorqueSaturated, "torque_saturated", "more torque wanted than the limit allows",
     "wanted torque against torque_limit", kJoint, kHolding, kNextCycle, kWarn, kItself},
    {Fault::kEncoderJump, "encoder_jump", "position stepped further than velocity allows",
     "step of position against velocity and encoder_jump", kJoint, kAwake, kThisCycle,
     kDriveDamping, kOperator},
    {Fault::kNotFinite, "not_finite", "a measured or computed value is not a number, or beyond 1e6",
     "every value measured; every torque computed, a cycle later", kJoint, kAwake, kNextCycle,
     kDriveDamping, kOperator},
    {Fault::kBusDown, "bus_down", "the interface is down or the adapter is gone",
     "errors of the socket", kBus, kAwake, kThisCycle, kControlledStop, kOperator},
    {Fault::kBusOff, "bus_off", "the CAN controller left the bus", "error frames", kBus, kAwake,
     kThisCycle, kControlledStop, kOperator},
    {Fault::kBusErrorPassive, "bus_error_passive", "the bus is error-passive: errors pile up",
     "error frames", kBus, kAwake, kThisCycle, kWarn, kItself},
    {Fault::kBusStalled, "bus_stalled",
     "frames of the last cycle had not left; this cycle's were skipped",
     "own frames not seen to have left", kBus, kAwake, kThisCycle, kWarn, kItself},
    {Fault::kForeignCommander, "foreign_commander", "somebody else commands our drives",
     "frames with our commands' identifiers that we did not send", kBus, kAwake, kThisCycle,
     kControlledStop, kOperator},
    {Fault::kOverrun, "overrun", "overrun_cycles cycles in a row ended after their period",
     "overruns counted", kArm, states({kEnabling, kActive, kStopping}), kOverrunCycles,
     kControlledStop, kOperator},
    {Fault::kConnectTimeout, "connect_timeout",
     "not configured and reporting within connect_timeout_s", "time since connecting began", kJoint,
     states({kConnecting}), Within::kConnectTimeout, kTorqueOff, kOperator},
    {Fault::kEnableTimeout, "enable_timeout", "not enabled and at rest within enable_timeout_s",
     "time since enabling began", kJoint, states({kEnabling}), Within::kEnableTimeout, kTorqueOff,
     kOperator},
    {Fault::kNotAtRest, "not_at_rest", "a start was asked for while the joint moved",
     "filtered velocity against start_velocity", kJoint, states({kReady}), kThisCycle, kRefuse,
     kItself},
    {Fault::kStartOutsideLimits, "start_outside_limits",
     "a start was asked for while the joint was outside its limits",
     "position against position_lower, position_upper", kJoint, states({kReady}), kThisCycle,
     kRefuse, kItself},
    {Fault::kContact, "contact", "something pushes the joint",
     "observed external torque against contact_torque", kJoint, kHolding, Within::kContact, kWarn,
     kItself},
    {Fault::kVibration, "vibration", "the joint vibrates: a limit cycle; its gains are lowered",
     "swings of velocity that the drive feeds", kJoint, kHolding, kHalfCycles, kWarn, kItself},
    {Fault::kVibrationPersists, "vibration_persists",
     "the joint vibrates even with the lowest gains", "swings of velocity that the drive feeds",
     kJoint, kHolding, kHalfCycles, kControlledStop, kOperator},
    {Fault::kStaticTorque, "static_torque",
     "at arm-up the drive measures another torque than the model expects",
     "measured against modelled torque while authority ramps in", kJoint, states({kActive}),
     kStartRamp, kControlledStop, kOperator},
    {Fault::kEncoderStuck, "encoder_stuck", "the position does not change though it must",
     "way by velocity against way by position", kJoint, kTorque, kEncoderWay, kDriveDamping,
     kOperator},
    {Fault::kForbiddenCall, "forbidden_call",
     "the sealed real-time thread asked for a system call it may not make",
     "the kernel's filter on that thread", kArm, kAwake, kThisCycle, kControlledStop, kOperator},
    {Fault::kOtherArm, "other_arm", "another arm of this robot has a fault", "its supervisor", kArm,
     states({kConnecting, kReady, kEnabling, kActive, kStopping}), kNextCycle, kControlledStop,
     kOperator},
}};

constexpr bool complete_and_ordered() {
  for (std::size_t i = 0; i < kFaults; ++i) {
    if (kTable[i].fault != static_cast<Fault>(i) || kTable[i].name == nullptr) {
      return false;
    }
  }
  return true;
}
static_assert(complete_and_ordered(), "one line a fault, in the order of enum Fault");

// The arm never falls by a decision of ours while its encoders can be trusted.
constexpr bool never_drops_the_arm() {
  for (const FaultPolicy& line : kTable) {
    if (line.action == Action::kTorqueOff && (line.states & kTorque) != 0) {
      return false;
    }
  }
  return true;
}
static_assert(never_drops_the_arm(), "kTorqueOff is for faults found before torque flows");

// What stops the arm stays until a person has seen it; what does not clears by itself.
constexpr bool clears_as_it_acts() {
  for (const FaultPolicy& line : kTable) {
    if ((line.action >= kControlledStop) != (line.clears == kOperator)) {
      return false;
    }
  }
  return true;
}
static_assert(clears_as_it_acts(), "only warnings clear by themselves");

// Torque that cannot be checked by encoders is the only torque that may be cut while it flows.
constexpr bool cuts_torque_only_for_encoders() {
  for (const FaultPolicy& line : kTable) {
    const bool of_encoder = line.fault == Fault::kEncoderJump ||
                            line.fault == Fault::kEncoderStuck || line.fault == Fault::kNotFinite;
    if ((line.action == kDriveDamping) != of_encoder) {
      return false;
    }
  }
  return true;
}
static_assert(cuts_torque_only_for_encoders(), "kDriveDamping is for encoders alone");

}  // namespace

const FaultPolicy& policy(Fault fault) noexcept {
  const auto index = static_cast<std::size_t>(fault);
  return kTable[index < kFaults ? index : 0];
}

Action action_of(Fault fault, const SafetyOptions& options) noexcept {
  if (fault != Fault::kContact) {
    return policy(fault).action;
  }
  switch (options.contact) {
    case ContactReaction::kReport:
      return Action::kWarn;
    case ContactReaction::kDamp:
      return Action::kDamp;
    case ContactReaction::kStop:
      break;
  }
  return Action::kControlledStop;
}

Clears clears_of(Fault fault, const SafetyOptions& options) noexcept {
  return action_of(fault, options) >= kControlledStop ? kOperator : kItself;
}

int cycles_to_detect(Fault fault, const SafetyOptions& options) noexcept {
  switch (policy(fault).within) {
    case kSilentCycles:
      return options.silent_cycles;
    case kOverrunCycles:
      return options.overrun_cycles;
    default:
      return 1;
  }
}

const char* to_string(SupervisorState state) noexcept {
  constexpr std::array<const char*, kSupervisorStates> kNames{
      "off", "connecting", "ready", "enabling", "active", "stopping", "lowering", "fault"};
  const auto index = static_cast<std::size_t>(state);
  return index < kNames.size() ? kNames[index] : "?";
}

const char* to_string(Action action) noexcept {
  constexpr std::array<const char*, 7> kNames{
      "none", "warn", "refuse", "damp", "controlled_stop", "drive_damping", "torque_off"};
  const auto index = static_cast<std::size_t>(action);
  return index < kNames.size() ? kNames[index] : "?";
}

const char* to_string(Subject subject) noexcept {
  constexpr std::array<const char*, 3> kNames{"joint", "bus", "arm"};
  const auto index = static_cast<std::size_t>(subject);
  return index < kNames.size() ? kNames[index] : "?";
}

const char* to_string(Within within) noexcept {
  constexpr std::array<const char*, 10> kNames{
      "1 cycle",           "2 cycles",         "silent_cycles", "overrun_cycles",
      "connect_timeout_s", "enable_timeout_s", "10 ms",         "half_cycles half-waves",
      "start_ramp_s",      "encoder_stuck way"};
  const auto index = static_cast<std::size_t>(within);
  return index < kNames.size() ? kNames[index] : "?";
}

const char* to_string(Clears clears) noexcept {
  return clears == kItself ? "itself" : "operator";
}

std::string states_in_words(BitSet set) {
  std::string words;
  for (std::size_t i = 0; i < kSupervisorStates; ++i) {
    if (has(set, i)) {
      words += words.empty() ? "" : ", ";
      words += to_string(static_cast<SupervisorState>(i));
    }
  }
  return words;
}

std::string policy_table_markdown() {
  std::string table =
      "| fault | of | meaning | detected by | within | looked for in | action | clears | cleared "
      "by "
      "|\n|---|---|---|---|---|---|---|---|---|\n";
  for (const FaultPolicy& line : kTable) {
    const char* when =
        line.clears == kItself ? "1 s after the condition has gone" : "at the next start";
    table += std::string("| `") + line.name + "` | " + to_string(line.subject) + " | " +
             line.meaning + " | " + line.detection + " | " + to_string(line.within) + " | " +
             states_in_words(line.states) + " | `" + to_string(line.action) + "` | " + when +
             " | " + to_string(line.clears) + " |\n";
  }
  return table;
}

}  // namespace geodesic::control
