// What the real-time thread tells the service thread: one record a cycle, an event for each fault
// and change of state, and now and then all counters. Neither side ever waits for the other.
#pragma once

#include <array>
#include <cstdint>
#include <limits>

#include "control/controller.hpp"
#include "control/joint.hpp"
#include "drivers/arm.hpp"
#include "rt/latest_value.hpp"
#include "rt/ring.hpp"

namespace geodesic::tools {

/// One joint in one cycle. [rad, N·m] revolute; [m, N] prismatic.
struct JointRecord {
  static constexpr std::int32_t kNever = std::numeric_limits<std::int32_t>::max();

  double position = 0.0;  ///< as measured
  double velocity = 0.0;  ///< at the common instant, filtered
  float torque = 0.0F;    ///< as the drive reports it
  float command = 0.0F;   ///< torque commanded
  float model = 0.0F;     ///< gravity + Coriolis
  float external = 0.0F;  ///< observed external torque
  float gain = 1.0F;      ///< what a vibration has left of the gains, 0..1
  bool touched = false;   ///< in contact
  control::StaticCheckState static_check = control::StaticCheckState::kOff;
  float temperature_c = 0.0F;
  std::int32_t age_us = kNever;  ///< of the last good frame; 0: answered in this cycle
  control::DriveCondition condition = control::DriveCondition::kUnknown;
  std::uint8_t drive_error = 0;
};

/// One cycle.
struct Record {
  std::int64_t index = 0;    ///< of the cycle
  std::int64_t tick_ns = 0;  ///< the instant it was due
  control::SupervisorState state = control::SupervisorState::kOff;
  control::LawKind law = control::LawKind::kFloat;
  bool overran = false;
  float authority = 0.0F;
  bool retuning = false;
  std::array<control::ArmReport, control::kMaxArms> arm{};
  std::array<JointRecord, control::kMaxJoints> joint{};
  std::array<std::uint16_t, control::kMaxBuses>
      sent{};  ///< frames handed to each bus in this cycle
};

/// A fault with its evidence, a change of state, or a request that was not followed; tick_ns tells
/// when.
struct Event {
  enum class Kind : std::uint8_t { kFault, kState, kArmState, kRefusal } kind = Kind::kFault;
  std::int64_t tick_ns = 0;
  control::FaultEvent fault;          ///< kFault
  std::uint8_t drive_error = 0;       ///< kFault of a joint: what its drive last said
  std::int64_t frame_age_ns = -1;     ///< kFault of a joint: of its last good frame; -1: none
  drivers::Frame last_frame;          ///< kFault of a joint: that frame
  drivers::DriveComplaint complaint;  ///< kFault of a joint
  control::SupervisorState from = control::SupervisorState::kOff;  ///< kState, kArmState
  control::SupervisorState to = control::SupervisorState::kOff;    ///< kState, kArmState
  int arm = 0;                                                     ///< kArmState
  control::LawKind law = control::LawKind::kFloat;                 ///< kState
  const char* refusal = nullptr;                                   ///< kRefusal: why, a literal
};

/// Everything counted since the start.
struct Counters {
  struct Joint {
    drivers::JointCounters frames;
    double max_torque = 0.0;    ///< largest magnitude measured [N·m or N]
    double max_command = 0.0;   ///< largest magnitude commanded [N·m or N]
    double max_external = 0.0;  ///< largest external torque observed at whole authority [N·m or N]
    control::MissingReplies missing;
    drivers::DriveComplaint complaint;
  };
  struct Bus {
    drivers::BusCounters frames;
    control::BusState state;
  };
  std::int64_t first_tick_ns = 0;
  std::array<Joint, control::kMaxJoints> joint{};
  std::array<Bus, control::kMaxBuses> bus{};
};

class Telemetry {
 public:
  Telemetry(const drivers::Arm& arm, std::int64_t period_ns);

  /// One cycle. Real-time thread only; O(joints).
  void push(std::int64_t index, const control::ArmState& state, const control::ArmCommand& command,
            const control::ControllerReport& report) noexcept;

  // Service thread only.
  bool pop(Record& record) noexcept { return records_.pop(record); }
  bool pop(Event& event) noexcept { return events_.pop(event); }
  /// @return true if counters() is newer than before.
  bool refresh() noexcept { return published_.update(); }
  const Counters& counters() const noexcept { return published_.front(); }

  /// What the service thread was too late for; nothing else is harmed by it. Any thread.
  std::uint64_t records_dropped() const noexcept { return records_.dropped(); }
  std::uint64_t events_dropped() const noexcept { return events_.dropped(); }

  /// Once the real-time thread has ended: brings counters() up to date.
  void finish() noexcept;

 private:
  void push_record(std::int64_t index, const control::ArmState& state,
                   const control::ArmCommand& command,
                   const control::ControllerReport& report) noexcept;
  void push_events(const control::ArmState& state,
                   const control::ControllerReport& report) noexcept;
  void publish_counters() noexcept;

  const drivers::Arm& arm_;
  std::int64_t cycles_a_count_;  ///< counters are published every so many cycles
  std::int64_t next_count_ = 0;  ///< index of the cycle that publishes them next
  control::SupervisorState last_state_ = control::SupervisorState::kOff;
  std::array<control::SupervisorState, control::kMaxArms> last_arm_state_{};
  Record record_;
  std::array<std::uint64_t, control::kMaxBuses> sent_before_{};
  Counters counters_;
  rt::Ring<Record, 2048> records_;
  rt::Ring<Event, 256> events_;
  rt::LatestValue<Counters> published_;
};

}  // namespace geodesic::tools
