// What one cycle carries between the drives and the controller: joint states in, joint commands
// out. Joint side only (after sign, ratio and offset); bytes and drive units live in drivers/.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace geodesic::control {

/// Capacity of every fixed-size array that is indexed by joint: two arms, a torso and grippers.
inline constexpr std::size_t kMaxJoints = 32;
/// Capacity of every fixed-size array that is indexed by bus.
inline constexpr std::size_t kMaxBuses = 8;

/// What a drive last said of itself.
enum class DriveCondition : std::uint8_t {
  kUnknown,      ///< it has not answered yet
  kConfiguring,  ///< the start-up dialogue is under way; it makes no torque
  kDisabled,     ///< configured and reporting; it makes no torque
  kEnabled,      ///< it follows torque commands
  kError,        ///< it reports an error of its own (JointState::drive_error says which)
  kRefused,      ///< what it reported contradicts the configuration; it will not be enabled
};

/// One joint as measured. A revolute joint counts in rad, rad/s and N·m; a prismatic one in m, m/s
/// and N.
struct JointState {
  double position = 0.0;       ///< [rad or m]
  double velocity = 0.0;       ///< [rad/s or m/s]
  double torque = 0.0;         ///< [N·m or N], as the drive reports it
  double temperature_c = 0.0;  ///< [°C], the hottest the drive reports
  std::int64_t stamp_ns = 0;   ///< CLOCK_MONOTONIC, arrival of the frame; 0: none yet
  DriveCondition condition = DriveCondition::kUnknown;
  std::uint8_t drive_error = 0;  ///< the drive family's own error code; 0: none
  bool fresh = false;            ///< a report newer than the last one arrived in this cycle
};

/// One bus as seen by this host.
struct BusState {
  bool down = false;               ///< interface down, adapter gone, or socket closed
  bool bus_off = false;            ///< the controller left the bus
  bool error_passive = false;      ///< error counters above 127
  bool stalled = false;            ///< last cycle's frames have not left: this cycle's were skipped
  bool foreign_commander = false;  ///< somebody else sends commands to our drives
};

/// Everything measured in one cycle.
struct ArmState {
  std::int64_t tick_ns = 0;  ///< CLOCK_MONOTONIC, the instant this cycle was due
  std::size_t joints = 0;    ///< joint[0 .. joints) are valid, in the mechanism's order of v
  std::size_t buses = 0;     ///< bus[0 .. buses) are valid, in the configuration's order
  bool overran = false;      ///< the cycle before this one ended after its period
  /// Number of the system call that this thread asked for since the last cycle though it is sealed,
  /// plus one; 0: none.
  int forbidden_call = 0;
  std::array<JointState, kMaxJoints> joint{};
  std::array<BusState, kMaxBuses> bus{};
};

/// What a drive is asked to be.
enum class DriveMode : std::uint8_t {
  kMonitor,  ///< configure if need be, then report without torque
  kEnable,   ///< become enabled (once configured), then follow the torque command
  kDisable,  ///< zero torque, then disabled; keeps reporting
};

/// One joint's command. The drive makes
///   torque + stiffness * (position - measured) + damping * (velocity - measured).
struct JointCommand {
  DriveMode mode = DriveMode::kMonitor;
  double torque = 0.0;     ///< [N·m or N]
  double position = 0.0;   ///< [rad or m], counts only where stiffness > 0
  double velocity = 0.0;   ///< [rad/s or m/s], counts only where damping > 0
  double stiffness = 0.0;  ///< [N·m/rad or N/m], >= 0
  double damping = 0.0;    ///< [N·m·s/rad or N·s/m], >= 0
};

/// Everything commanded in one cycle; joint[i] belongs to ArmState::joint[i].
struct ArmCommand {
  std::size_t joints = 0;
  std::array<JointCommand, kMaxJoints> joint{};
};

}  // namespace geodesic::control
