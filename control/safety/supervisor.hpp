// The state machine people trust, and the one table of faults that is policy and documentation at
// once. A pure function of (memory, flags, time); it knows joints only as flags.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "control/bit_set.hpp"
#include "control/joint.hpp"
#include "control/options.hpp"
#include "control/safety/suspect.hpp"

namespace geodesic::control {

enum class SupervisorState : std::uint8_t {
  kOff,         ///< drives disabled; nothing happens until somebody asks
  kConnecting,  ///< drives are configured and must report; no torque
  kReady,       ///< all is well; no torque
  kEnabling,    ///< drives are being enabled; zero torque
  kActive,      ///< the law runs; authority ramps in
  kStopping,    ///< controlled stop: compensation and damping until at rest
  kLowering,    ///< drives damp, authority ramps out
  kFault,       ///< drives disabled after a fault; an operator has to ask for a start
};
inline constexpr std::size_t kSupervisorStates = 8;

/// In rising severity: the worst of all raised wins.
enum class Action : std::uint8_t {
  kNone,
  kWarn,            ///< carry on, say so
  kRefuse,          ///< do not start; no effect once active
  kDamp,            ///< stay active, but the damp law runs until the condition has gone
  kControlledStop,  ///< compensation and damping until at rest, then lowering, then fault
  kDriveDamping,    ///< encoders not trustworthy: drive-side damping only, then fault
  kTorqueOff,       ///< drives disabled at once; only for faults found before torque flows
};

enum class Fault : std::uint8_t {
  kJointSilent,
  kDriveError,
  kDriveRefused,
  kDriveDisabled,  ///< a drive left enabled without being told
  kPositionLimit,
  kVelocityLimit,
  kTemperatureWarn,
  kTemperatureLimit,
  kTorqueSaturated,
  kEncoderJump,
  kNotFinite,
  kBusDown,
  kBusOff,
  kBusErrorPassive,
  kBusStalled,
  kForeignCommander,
  kOverrun,
  kConnectTimeout,
  kEnableTimeout,
  kNotAtRest,           ///< a start was asked for while a joint moved
  kStartOutsideLimits,  ///< a start was asked for while a joint was outside its limits
  kContact,             ///< something pushes a joint; what follows is SafetyOptions::contact
  kVibration,           ///< a limit cycle of a joint
  kVibrationPersists,   ///< it does not end with the lowest gains
  kStaticTorque,        ///< at arm-up the drive measures another torque than the model expects
  kEncoderStuck,        ///< a position that does not change though it must
  kForbiddenCall,       ///< the sealed real-time thread asked for a system call it may not make
  kOtherArm,            ///< another arm of this robot has a fault
  kCount
};
inline constexpr std::size_t kFaults = static_cast<std::size_t>(Fault::kCount);

/// What a fault is found on.
enum class Subject : std::uint8_t { kJoint, kBus, kArm };

/// When a condition that has come is a fault.
enum class Within : std::uint8_t {
  kThisCycle,       ///< in the cycle that sees it
  kNextCycle,       ///< it is found at the end of a cycle, or on another arm
  kSilentCycles,    ///< SafetyOptions::silent_cycles in a row
  kOverrunCycles,   ///< SafetyOptions::overrun_cycles in a row
  kConnectTimeout,  ///< SafetyOptions::connect_timeout_s
  kEnableTimeout,   ///< SafetyOptions::enable_timeout_s
  kContact,         ///< 10 ms (safety/contact.hpp)
  kHalfCycles,      ///< VibrationOptions::half_cycles half-waves (safety/vibration.hpp)
  kStartRamp,       ///< SafetyOptions::start_ramp_s (safety/static_check.hpp)
  kEncoderWay,      ///< once velocity says it went SafetyOptions::encoder_stuck
};

/// What ends a fault once its condition has gone.
enum class Clears : std::uint8_t {
  kItself,    ///< kRearmSeconds without the condition
  kOperator,  ///< a person asks for a law
};
/// A warning ends, and may be told again, after the condition has been away for this long.
inline constexpr double kRearmSeconds = 1.0;

struct FaultPolicy {
  Fault fault;
  const char* name;       ///< as logs and summaries call it: "joint_silent"
  const char* meaning;    ///< one line for people
  const char* detection;  ///< how it is found
  Subject subject;
  BitSet states;  ///< in which states it is looked for; bit of SupervisorState
  Within within;
  Action action;  ///< where it is a matter of options, the default; see action_of()
  Clears clears;  ///< likewise; see clears_of()
};

/// The one table. Real-time.
const FaultPolicy& policy(Fault fault) noexcept;
/// What `fault` leads to with these options: the table's action, but for contact. Real-time.
Action action_of(Fault fault, const SafetyOptions& options) noexcept;
/// What ends it: itself if it is no more than a warning, else an operator. Real-time.
Clears clears_of(Fault fault, const SafetyOptions& options) noexcept;
/// In how many cycles in a row the condition becomes a fault; where the table names a time, the
/// detector counts, and the supervisor takes its word in 1. Real-time.
int cycles_to_detect(Fault fault, const SafetyOptions& options) noexcept;
const char* to_string(SupervisorState state) noexcept;
const char* to_string(Action action) noexcept;
const char* to_string(Subject subject) noexcept;
const char* to_string(Within within) noexcept;
const char* to_string(Clears clears) noexcept;
/// The states of `set`, as "active, stopping". Not real-time.
std::string states_in_words(BitSet set);
/// The table as README.md shows it. Not real-time.
std::string policy_table_markdown();

inline constexpr std::size_t kMaxEventsPerCycle = 16;
inline constexpr int kNoJoint = -1;

/// A fault raised at a moment, with its evidence.
struct FaultEvent {
  std::int64_t time_ns = 0;  ///< ArmState::tick_ns of the cycle that found it
  Fault fault = Fault::kCount;
  Action action = Action::kNone;  ///< what it leads to
  int joint = kNoJoint;           ///< index in order of v
  int bus = -1;                   ///< index of the bus, where it is the bus's fault
  int arm = 0;                    ///< index of the arm that raised it
  double found = 0.0;
  double limit = 0.0;
  Suspicion suspicion;  ///< kStaticTorque: what it looks like
};

/// One supervisor looks after one arm: a set of joints, and the buses they are on.
struct SupervisorOptions {
  BitSet joints = 0;
  BitSet buses = first(kMaxBuses);
  bool start_active = true;
  SafetyOptions safety;
};

/// One cycle as the supervisor sees it. Sets of joints unless said otherwise.
struct Flags {
  bool law_requested = false;
  bool stop_requested = false;  ///< wins over law_requested
  bool overran = false;
  BitSet fresh = 0;     ///< answered in this cycle with a plausible state
  BitSet disabled = 0;  ///< configured, without torque
  BitSet enabled = 0;
  BitSet error = 0;
  BitSet refused = 0;
  BitSet moving = 0;    ///< faster than SafetyOptions::start_velocity
  BitSet unrested = 0;  ///< faster than SafetyOptions::stop_rest_velocity
  BitSet outside = 0;   ///< beyond a position limit and its tolerance
  /// Conditions that need no memory (limits, temperatures, encoder, bus), each a set of joints or
  /// of buses by policy(fault).subject. Those that supervise() derives itself are ignored.
  std::array<BitSet, kFaults> present{};
};

/// All that supervise() remembers from cycle to cycle. Plain data: copy it, replay from it.
struct SupervisorMemory {
  SupervisorState state = SupervisorState::kOff;
  bool start_done = false;         ///< SupervisorOptions::start_active has had its one effect
  bool drives_only = false;        ///< lowering by drive-side damping alone
  int overruns = 0;                ///< in a row
  std::int64_t since_ns = 0;       ///< when `state` was entered
  std::int64_t rest_since_ns = 0;  ///< since when no joint moves; as entered, if none has
  double authority = 0.0;          ///< 0..1, what compensation is scaled with
  double lower_from = 0.0;         ///< authority when lowering began
  double ramp_s = 0.0;             ///< of the ramp under way: one that has begun ends as it began
  std::array<std::uint16_t, kMaxJoints> silent{};   ///< cycles without an answer, in a row
  std::array<std::uint16_t, kMaxJoints> answers{};  ///< since connecting began, saturating
  std::array<BitSet, kFaults> latched{};            ///< raised since connecting began
  std::array<BitSet, kFaults> reported{};           ///< of these, already told as an event
  std::array<std::int64_t, kFaults> seen_ns{};      ///< when the condition was last present
};

struct SupervisorDecision {
  SupervisorMemory memory;  ///< for the next call
  bool restart_drives = false;
  std::array<FaultEvent, kMaxEventsPerCycle> event{};  ///< without found and limit
  std::size_t events = 0;  ///< what does not fit is told in the next cycle, nothing is lost
};

/// One step of the state machine: counts, latches faults by the table, moves at most one state on.
/// Real-time: no allocation, bounded; the same arguments give the same decision.
/// Flags of joints and buses that are not the arm's do not count.
/// @param now_ns  the cycle's due instant, CLOCK_MONOTONIC
/// @param room    how many events may be told in this cycle, at most kMaxEventsPerCycle
SupervisorDecision supervise(const SupervisorOptions& options, const SupervisorMemory& memory,
                             const Flags& flags, std::int64_t now_ns,
                             std::size_t room = kMaxEventsPerCycle) noexcept;

/// The state of a robot as a whole: of all its arms' states the one in which most can move, in the
/// order active, stopping, lowering, enabling, ready, connecting, fault, off. So the robot is `off`
/// only if every arm is, and `fault` only if none moves and one has a fault. Real-time.
SupervisorState overall(SupervisorState one, SupervisorState other) noexcept;

/// Whether this arm's own fault (not another arm's) stops it: what kOtherArm tells the others.
/// Real-time.
bool has_own_fault(const SupervisorOptions& options, const SupervisorMemory& memory) noexcept;

/// What the drive of `joint` is to be, given what it says it is. Real-time.
DriveMode drive_mode(const SupervisorMemory& memory, std::size_t joint,
                     DriveCondition condition) noexcept;

/// Joints whose own drive has failed: they are disabled while the others stop. Real-time.
BitSet failed_drives(const SupervisorMemory& memory) noexcept;

/// The worst action among all latched faults. Real-time.
Action worst_action(const SupervisorOptions& options, const SupervisorMemory& memory) noexcept;

/// Joints that have not answered for SafetyOptions::silent_cycles. Real-time.
BitSet silent_joints(const SupervisorOptions& options, const SupervisorMemory& memory) noexcept;

/// Whether a joint has not answered for SafetyOptions::damp_cycles. Real-time.
bool is_late(const SupervisorOptions& options, const SupervisorMemory& memory,
             std::size_t joint) noexcept;

/// What is left of a law at a joint that misses replies: 1 before damp_cycles, 0 at silent_cycles,
/// linear between. Real-time.
double law_share(const SupervisorOptions& options, const SupervisorMemory& memory,
                 std::size_t joint) noexcept;

/// True where torque may leave the controller: active, stopping, lowering.
constexpr bool makes_torque(SupervisorState state) noexcept {
  return state == SupervisorState::kActive || state == SupervisorState::kStopping ||
         state == SupervisorState::kLowering;
}

}  // namespace geodesic::control
