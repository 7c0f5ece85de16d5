// The state machine people trust, and the one table of faults that is policy and documentation at
// once. A pure function of (memory, flags, time); it knows joints only as flags.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "control/joint.hpp"
#include "control/options.hpp"

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
  kCount
};
inline constexpr std::size_t kFaults = static_cast<std::size_t>(Fault::kCount);

/// What a fault is found on.
enum class Subject : std::uint8_t { kJoint, kBus, kArm };

/// A set of joints, buses or states: bit i is number i.
using BitSet = std::uint32_t;
constexpr BitSet bit(std::size_t index) noexcept {
  return BitSet{1} << index;
}
constexpr bool has(BitSet set, std::size_t index) noexcept {
  return (set & bit(index)) != 0;
}
/// The first `count` members, count <= 32.
constexpr BitSet first(std::size_t count) noexcept {
  return count >= 32 ? ~BitSet{0} : bit(count) - 1;
}

struct FaultPolicy {
  Fault fault;
  const char* name;     ///< as logs and summaries call it: "joint_silent"
  const char* meaning;  ///< one line for people
  Subject subject;
  BitSet states;  ///< in which states it is looked for; bit of SupervisorState
  Action action;
  const char* clears;  ///< when, and by whom
};

/// The one table. Real-time.
const FaultPolicy& policy(Fault fault) noexcept;
const char* to_string(SupervisorState state) noexcept;
const char* to_string(Action action) noexcept;
/// The table as README.md shows it. Not real-time.
std::string policy_table_markdown();

inline constexpr std::size_t kMaxEventsPerCycle = 16;
inline constexpr int kNoJoint = -1;

/// A fault raised at a moment, with its evidence.
struct FaultEvent {
  std::int64_t time_ns = 0;  ///< ArmState::tick_ns of the cycle that found it
  Fault fault = Fault::kCount;
  int joint = kNoJoint;  ///< index in order of v
  int bus = -1;          ///< index of the bus, where it is the bus's fault
  double found = 0.0;
  double limit = 0.0;
};

struct SupervisorOptions {
  std::size_t joints = 0;
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
/// @param now_ns  the cycle's due instant, CLOCK_MONOTONIC
SupervisorDecision supervise(const SupervisorOptions& options, const SupervisorMemory& memory,
                             const Flags& flags, std::int64_t now_ns) noexcept;

/// What the drive of `joint` is to be, given what it says it is. Real-time.
DriveMode drive_mode(const SupervisorMemory& memory, std::size_t joint,
                     DriveCondition condition) noexcept;

/// Joints whose own drive has failed: they are disabled while the others stop. Real-time.
BitSet failed_drives(const SupervisorMemory& memory) noexcept;

/// The worst action among all latched faults. Real-time.
Action worst_action(const SupervisorMemory& memory) noexcept;

/// Joints that have not answered for SafetyOptions::silent_cycles. Real-time.
BitSet silent_joints(const SupervisorOptions& options, const SupervisorMemory& memory) noexcept;

/// True where torque may leave the controller: active, stopping, lowering.
constexpr bool makes_torque(SupervisorState state) noexcept {
  return state == SupervisorState::kActive || state == SupervisorState::kStopping ||
         state == SupervisorState::kLowering;
}

}  // namespace geodesic::control
