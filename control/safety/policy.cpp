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

constexpr const char* kByOperator = "by the operator: ask for a law";
constexpr const char* kByItself = "by itself, 1 s after the condition has gone";

constexpr std::array<FaultPolicy, kFaults> kTable{{
    {Fault::kJointSilent, "joint_silent", "no reply from the drive for silent_cycles in a row",
     Subject::kJoint, kConnected, Action::kControlledStop, kByOperator},
    {Fault::kDriveError, "drive_error",
     "the drive reports an error; it is disabled while the others stop", Subject::kJoint, kAwake,
     Action::kControlledStop, kByOperator},
    {Fault::kDriveRefused, "drive_refused",
     "what the drive reports of itself contradicts the configuration", Subject::kJoint,
     kBeforeTorque, Action::kTorqueOff, kByOperator},
    {Fault::kDriveDisabled, "drive_disabled",
     "the drive left the enabled state without being told; it stays disabled while the others stop",
     Subject::kJoint, kTorque, Action::kControlledStop, kByOperator},
    {Fault::kPositionLimit, "position_limit", "position beyond the hard limit and its tolerance",
     Subject::kJoint, kHolding, Action::kControlledStop, kByOperator},
    {Fault::kVelocityLimit, "velocity_limit", "velocity beyond the limit", Subject::kJoint,
     kHolding, Action::kControlledStop, kByOperator},
    {Fault::kTemperatureWarn, "temperature_warn", "the drive is warm", Subject::kJoint, kWarm,
     Action::kWarn, kByItself},
    {Fault::kTemperatureLimit, "temperature_limit", "the drive is too hot", Subject::kJoint, kWarm,
     Action::kControlledStop, kByOperator},
    {Fault::kTorqueSaturated, "torque_saturated", "more torque wanted than the limit allows",
     Subject::kJoint, kHolding, Action::kWarn, kByItself},
    {Fault::kEncoderJump, "encoder_jump", "position stepped further than velocity allows",
     Subject::kJoint, kAwake, Action::kDriveDamping, kByOperator},
    {Fault::kNotFinite, "not_finite", "a measured or computed value is not a number, or beyond 1e6",
     Subject::kJoint, kAwake, Action::kDriveDamping, kByOperator},
    {Fault::kBusDown, "bus_down", "the interface is down or the adapter is gone", Subject::kBus,
     kAwake, Action::kControlledStop, kByOperator},
    {Fault::kBusOff, "bus_off", "the CAN controller left the bus", Subject::kBus, kAwake,
     Action::kControlledStop, kByOperator},
    {Fault::kBusErrorPassive, "bus_error_passive", "the bus is error-passive: errors pile up",
     Subject::kBus, kAwake, Action::kWarn, kByItself},
    {Fault::kBusStalled, "bus_stalled",
     "frames of the last cycle had not left; this cycle's were skipped", Subject::kBus, kAwake,
     Action::kWarn, kByItself},
    {Fault::kForeignCommander, "foreign_commander", "somebody else commands our drives",
     Subject::kBus, kAwake, Action::kControlledStop, kByOperator},
    {Fault::kOverrun, "overrun", "overrun_cycles cycles in a row ended after their period",
     Subject::kArm, states({kEnabling, kActive, kStopping}), Action::kControlledStop, kByOperator},
    {Fault::kConnectTimeout, "connect_timeout",
     "not configured and reporting within connect_timeout_s", Subject::kJoint,
     states({kConnecting}), Action::kTorqueOff, kByOperator},
    {Fault::kEnableTimeout, "enable_timeout", "not enabled and at rest within enable_timeout_s",
     Subject::kJoint, states({kEnabling}), Action::kTorqueOff, kByOperator},
    {Fault::kNotAtRest, "not_at_rest", "a start was asked for while the joint moved",
     Subject::kJoint, states({kReady}), Action::kRefuse, kByItself},
    {Fault::kStartOutsideLimits, "start_outside_limits",
     "a start was asked for while the joint was outside its limits", Subject::kJoint,
     states({kReady}), Action::kRefuse, kByItself},
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

const char* to_string(Subject subject) {
  switch (subject) {
    case Subject::kJoint:
      return "joint";
    case Subject::kBus:
      return "bus";
    case Subject::kArm:
      return "arm";
  }
  return "?";
}

}  // namespace

const FaultPolicy& policy(Fault fault) noexcept {
  const auto index = static_cast<std::size_t>(fault);
  return kTable[index < kFaults ? index : 0];
}

const char* to_string(SupervisorState state) noexcept {
  constexpr std::array<const char*, kSupervisorStates> kNames{
      "off", "connecting", "ready", "enabling", "active", "stopping", "lowering", "fault"};
  const auto index = static_cast<std::size_t>(state);
  return index < kNames.size() ? kNames[index] : "?";
}

const char* to_string(Action action) noexcept {
  constexpr std::array<const char*, 6> kNames{
      "none", "warn", "refuse", "controlled_stop", "drive_damping", "torque_off"};
  const auto index = static_cast<std::size_t>(action);
  return index < kNames.size() ? kNames[index] : "?";
}

std::string policy_table_markdown() {
  std::string table =
      "| fault | of | meaning | looked for in | action | clears |\n|---|---|---|---|---|---|\n";
  for (const FaultPolicy& line : kTable) {
    table += std::string("| `") + line.name + "` | " + to_string(line.subject) + " | " +
             line.meaning + " | " + states_in_words(line.states) + " | `" + to_string(line.action) +
             "` | " + line.clears + " |\n";
  }
  return table;
}

}  // namespace geodesic::control
