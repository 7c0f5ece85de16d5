// The host's side of one ODrive axis: which frame leaves in which cycle, and what a report means.
// Bytes are codec.hpp's, the start-up dialogue is start_up.hpp's.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "drivers/drive.hpp"
#include "drivers/odrive/settings.hpp"
#include "drivers/odrive/start_up.hpp"
#include "drivers/odrive/status.hpp"

namespace geodesic::drivers::odrive {

/// Contracts as drivers::Drive. The drive makes torque only: stiffness and damping of a command are
/// computed here from its last report.
///
/// Torque never comes back by itself: the axis is enabled only on the way into DriveMode::kEnable.
/// One that leaves closed loop untold, tells an error, loses its heartbeat or does not become
/// enabled stays out until the mode has been another one; then the whole start-up dialogue is held
/// again before the next attempt.
class Driver final : public Drive {
 public:
  static constexpr int kMaxEnables = 5;  ///< requests for closed loop, of one attempt
  static constexpr std::int64_t kHeartbeatLostNs = 500'000'000;
  /// An axis not in operation that was silent for this long may have been off: it is asked anew.
  static constexpr std::int64_t kForgetNs = 200'000'000;
  /// Stiffness and damping count as long as the report they act on is no older than this.
  static constexpr std::int64_t kStaleNs = 20'000'000;
  /// Between two looks at the temperature, and at the errors of an axis that is out.
  static constexpr std::int64_t kSlowNs = 100'000'000;

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

 private:
  enum class Phase : std::uint8_t {
    kStartUp,
    kIdle,      ///< configured, disabled
    kEnabling,  ///< asked for closed loop, not confirmed
    kEnabled,
    kDisabling,  ///< asked to be idle, not confirmed
    kOut,        ///< left closed loop untold, or would not enter it
    kRefused,
  };

  void follow(control::DriveMode mode, std::int64_t now_ns) noexcept;
  void watch(std::int64_t now_ns) noexcept;
  void begin_start_up() noexcept;
  void leave(std::int64_t now_ns) noexcept;
  void add(const std::optional<Frame>& frame) noexcept;
  void add_enabling(std::int64_t now_ns) noexcept;
  void add_disabling(std::int64_t now_ns) noexcept;
  void add_torque(const DriveCommand& command, std::int64_t now_ns) noexcept;
  void add_requests(std::int64_t now_ns) noexcept;
  double wanted_torque(const DriveCommand& command, std::int64_t now_ns) noexcept;
  void take_heartbeat() noexcept;
  bool take_estimates(const ReceivedFrame& received) noexcept;
  void take_torque(const Frame& frame) noexcept;
  void update_condition() noexcept;

  DriveOptions options_;
  Settings settings_;
  Status status_;
  StartUp start_up_;
  Phase phase_ = Phase::kStartUp;
  control::DriveMode mode_ = control::DriveMode::kMonitor;
  bool enable_due_ = false;  ///< the mode has become kEnable and no attempt was made yet
  bool zero_sent_ = false;   ///< kDisabling: zero torque has left
  bool expired_ = false;     ///< the watchdog has expired in operation
  bool heartbeat_lost_ = false;
  int enables_ = 0;
  bool mode_set_ = false;  ///< kEnabling: limits and mode have left
  std::uint32_t bad_heartbeats_ = 0;
  std::int64_t requested_ns_ = 0;  ///< the last state request
  std::int64_t last_heard_ns_ = 0;
  std::int64_t next_slow_ns_ = 0;
  std::span<Frame> out_;
  std::size_t count_ = 0;
  std::size_t due_ = 0;
  DriveState state_;
  DriveComplaint complaint_;
};

}  // namespace geodesic::drivers::odrive
