// The host's side of one CiA 402 drive: which frame leaves in which cycle, and what a report means.
// Bytes are codec.hpp's, the dialogue up to operational is start_up.hpp's.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "drivers/cia402/codec.hpp"
#include "drivers/cia402/settings.hpp"
#include "drivers/cia402/start_up.hpp"
#include "drivers/drive.hpp"
#include "drivers/error_diffusion.hpp"

namespace geodesic::drivers::cia402 {

/// Contracts as drivers::Drive. One frame a cycle for the drive; the leader of a bus adds this
/// host's heartbeat and, last, SYNC, which every operational drive answers with its TPDOs.
///
/// A drive in cyclic torque knows no stiffness and damping: this host adds what they ask for from
/// what the drive reported last, and leaves them out when that is older than kStaleNs.
///
/// Torque never comes back by itself: the power state machine is walked only on the way into
/// DriveMode::kEnable, a fault is reset only at start-up and only if the options say so. A drive
/// that leaves operation enabled untold, does not reach it, or was silent for longer than its own
/// watchdog waits, stays out until the mode has been
/// another one; then the whole start-up is held again before the next attempt.
class Driver final : public Drive {
 public:
  /// From the first transition to operation enabled; a brake may have to be released.
  static constexpr std::int64_t kEnableTimeoutNs = 2'000'000'000;
  /// A drive not in operation that was silent for this long may have been off: it is asked anew.
  static constexpr std::int64_t kForgetNs = 100'000'000;
  static constexpr std::int64_t kStaleNs = 20'000'000;
  static constexpr int kMissedHeartbeats = 5;
  static constexpr std::int64_t kClearIntervalNs = 20'000'000;  ///< one edge of fault reset
  static constexpr int kMaxClears = 10;
  static constexpr double kFallbackDamping = 0.5;  ///< [N·m·s/rad] while no command can be sent
  /// In quarters of a report: what comes beyond one a cycle and a quarter may reach this (a link
  /// that doubles one frame in four never does, a second drive does within kSurplusLimit / 3
  /// cycles)...
  static constexpr int kSurplusLimit = 64;
  /// ...and what was lost before hides no more than this.
  static constexpr int kSurplusFloor = -64;

  /// @param options must pass check().
  explicit Driver(const DriveOptions& options);

  std::size_t transmit(const DriveCommand& command, std::int64_t now_ns,
                       std::span<Frame> out) noexcept override;
  std::size_t answers_due(std::size_t frames) const noexcept override;
  bool speaks_unasked() const noexcept override { return true; }
  bool receive(const ReceivedFrame& received) noexcept override;
  const DriveState& state() const noexcept override { return state_; }
  const DriveComplaint& complaint() const noexcept override;
  void restart() noexcept override;
  std::vector<IdFilter> reply_ids() const override;
  std::vector<IdFilter> command_ids() const override;

  std::uint32_t revision() const noexcept { return start_up_.revision(); }

 private:
  enum class Phase : std::uint8_t {
    kStartUp,
    kWaking,    ///< operational; its first report is awaited, or its fault reset
    kIdle,      ///< configured, not enabled
    kEnabling,  ///< on the way to operation enabled
    kEnabled,
    kDisabling,  ///< asked to disable, not confirmed
    kOut,        ///< left operation enabled untold, or would not reach it
    kRefused,
  };

  void follow(control::DriveMode mode, std::int64_t now_ns) noexcept;
  void begin_start_up() noexcept;
  void drop_out() noexcept;
  /// The drive's own frame of this cycle. @return whether there is one.
  bool own_frame(const DriveCommand& command, std::int64_t now_ns, Frame& out) noexcept;
  TorqueCommand waking(std::int64_t now_ns) noexcept;
  TorqueCommand enabling(std::int64_t now_ns) noexcept;
  TorqueCommand following(const DriveCommand& command, std::int64_t now_ns) noexcept;
  TorqueCommand disabling() noexcept;
  double braking_torque(double damping, std::int64_t now_ns) const noexcept;
  void take_power_state() noexcept;
  void take_heartbeat(NmtState state) noexcept;
  void take_emergency(const Emergency& emergency) noexcept;
  bool take_report(const Report& report, std::int64_t stamp_ns) noexcept;
  void take_position(std::int32_t counted, std::int64_t stamp_ns) noexcept;
  void watch_silence(std::int64_t now_ns) noexcept;
  bool in_fault() const noexcept;
  void update_condition() noexcept;

  DriveOptions options_;
  std::uint8_t node_;
  Units units_;
  StartUp start_up_;
  ErrorDiffusion diffusion_;
  Phase phase_ = Phase::kStartUp;
  control::DriveMode mode_ = control::DriveMode::kMonitor;
  bool operational_ = false;
  bool synced_ = false;      ///< the last transmit() left the drive with reports to send
  bool enable_due_ = false;  ///< the mode has become kEnable and no attempt was made yet
  bool zero_sent_ = false;   ///< kDisabling: zero torque has left
  bool disable_sent_ = false;
  bool held_by_error_ = false;
  int clears_ = 0;
  int surplus_ = 0;
  std::int64_t next_clear_ns_ = 0;
  std::int64_t enabling_since_ns_ = 0;
  std::int64_t next_host_heartbeat_ns_ = 0;
  std::int64_t last_heard_ns_ = 0;
  std::int64_t last_heartbeat_ns_ = 0;
  std::int64_t last_report_ns_ = 0;
  bool power_known_ = false;
  PowerState power_ = PowerState::kNotReady;
  std::uint8_t error_ = 0;
  bool counting_ = false;     ///< counted_ is what it reported last
  bool report_open_ = false;  ///< TPDO1 has come and TPDO2 has not
  std::uint32_t counted_ = 0;
  std::int64_t position_ = 0;  ///< increments, beyond the 32 bits of 0x6064
  DriveState state_;
  DriveState next_;  ///< of the report that is not complete yet
  DriveComplaint complaint_;
};

}  // namespace geodesic::drivers::cia402
