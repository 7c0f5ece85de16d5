// All joints of the robot on all its buses as one object: transmit a command, receive a state. It
// turns joint coordinates into the drives' (direction, ratio, offset) and back, and counts losses.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "control/bit_set.hpp"
#include "control/joint.hpp"
#include "drivers/bus/bus.hpp"
#include "drivers/drive.hpp"

namespace geodesic::drivers {

/// One joint's place in the robot: joint position = direction * ratio * drive position + offset;
/// torque at the joint = direction / ratio * drive torque.
struct JointOptions {
  std::string name;     ///< as in the URDF
  std::size_t bus = 0;  ///< index into ArmOptions::buses
  DriveOptions drive;
  double direction = 1.0;  ///< +1 or -1
  double ratio = 1.0;      ///< > 0, joint units per drive radian (1, or m/rad at a gripper)
  double offset = 0.0;     ///< [rad or m]
  /// Where the joint may stand when its drive is switched on [rad or m]: decides which turn a drive
  /// is in that forgets them (Family::position_period_rad). Narrower than that, or refused.
  double start_lower = -std::numeric_limits<double>::infinity();
  double start_upper = std::numeric_limits<double>::infinity();
};

struct ArmOptions {
  std::vector<BusOptions> buses;     ///< receive and transmit filters are filled in by Arm
  std::vector<JointOptions> joints;  ///< in the mechanism's order of v
  /// Virtual buses only: each cycle ends with a tick frame on each bus; receive() waits until the
  /// simulated arm answers it behind its replies (at most 1 s of real time) and stamps what it
  /// reads with the tick, so that a run does not depend on how fast this machine is.
  bool simulated_time = false;
};

/// Since start, for one joint.
struct JointCounters {
  std::uint64_t sent = 0;      ///< frames to this joint's drive that the kernel took
  std::uint64_t received = 0;  ///< frames from it
  std::uint64_t lost = 0;      ///< cycles in which a reply was due and did not come in time
};

class Arm {
 public:
  /// Opens every bus and builds every drive. Not real-time.
  /// @throws BusError, or std::invalid_argument for options no drive can have.
  explicit Arm(const ArmOptions& options);

  /// The same on buses that are open already, one for each of options.buses and in their order;
  /// they should let in and guard what filtered_buses() says. Not real-time.
  /// @throws std::invalid_argument as above, and if the number of buses differs.
  Arm(const ArmOptions& options, std::vector<std::unique_ptr<Bus>> buses);

  ~Arm();
  Arm(const Arm&) = delete;
  Arm& operator=(const Arm&) = delete;

  /// Encodes the commands that the next transmit() sends, so that nothing stands between the
  /// wake-up and the wire. `tick_ns` is that cycle's. A joint beyond command.joints is asked to
  /// DriveMode::kMonitor. Real-time.
  void prepare(const control::ArmCommand& command, std::int64_t tick_ns) noexcept;

  /// Sends what was prepared, or if nothing was, prepares `command` first. One batch a bus.
  /// Real-time; one system call a bus.
  void transmit(const control::ArmCommand& command, std::int64_t tick_ns) noexcept;

  /// Reads until every joint that was sent to has answered or the deadline (CLOCK_MONOTONIC) has
  /// passed. A reply to an earlier cycle updates the joint's state with its own time stamp, but
  /// does not count as this cycle's answer; nor does one joint's frame ever for another.
  /// A joint whose drive answers more often than it is asked is DriveCondition::kRefused until
  /// restart(): two drives have its identifiers, and nobody knows whose position it is.
  /// ArmState::overran is left to the caller, who knows the schedule.
  /// Real-time; bounded. The state lives until the next call.
  const control::ArmState& receive(std::int64_t tick_ns, std::int64_t deadline_ns) noexcept;

  /// Forgets the dialogues and refusals of these joints' drives: the next cycles configure them
  /// anew. A controller of theirs that left the bus for good is asked back. Real-time.
  void restart(control::BitSet joints = control::first(control::kMaxJoints)) noexcept;

  /// As Bus::tend() for every bus: before a real-time thread is sealed, and a few times a second
  /// from then on. One thread, not the real-time one.
  void tend() noexcept;

  /// As Bus::health() and Bus::take_news(). The thread that calls tend(); not real-time.
  LinkHealth bus_health(std::size_t bus) const;
  std::vector<BusNews> take_bus_news(std::size_t bus);

  /// All that transmit() and receive() send to and receive from; the same for the arm's whole life.
  std::vector<int> descriptors() const;

  /// When the last frames were read from a bus, before they were decoded (CLOCK_MONOTONIC; not kept
  /// in simulated time).
  std::int64_t last_read_ns() const noexcept;

  std::size_t joints() const noexcept;
  std::size_t buses() const noexcept;
  const JointCounters& joint_counters(std::size_t joint) const noexcept;
  const BusCounters& bus_counters(std::size_t bus) const noexcept;
  /// The last frame of this joint's drive that made sense; an empty one before there was any.
  const Frame& last_good_frame(std::size_t joint) const noexcept;
  const DriveComplaint& complaint(std::size_t joint) const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// options.buses with the filters that the joints' drives ask for: receive their replies, transmit
/// their commands. Not real-time.
/// @throws std::invalid_argument for options no drive can have, or drives that share identifiers.
std::vector<BusOptions> filtered_buses(const ArmOptions& options);

}  // namespace geodesic::drivers
