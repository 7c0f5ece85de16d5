// The host's side of one Damiao drive: which frame leaves in which cycle, and what a report means.
// Bytes are codec.hpp's, the start-up dialogue is start_up.hpp's.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "drivers/damiao/codec.hpp"
#include "drivers/damiao/start_up.hpp"
#include "drivers/drive.hpp"
#include "drivers/error_diffusion.hpp"

namespace geodesic::drivers::damiao {

/// Contracts as drivers::Drive. One frame a cycle at most, and every frame brings one answer.
///
/// Torque never comes back by itself: the drive is enabled only on the way into DriveMode::kEnable.
/// One that leaves enabled untold, or does not become enabled, stays out until the mode has been
/// another one; then the whole start-up dialogue is held again before the next attempt.
class Driver final : public Drive {
 public:
  static constexpr std::int64_t kEnableIntervalNs = 10'000'000;  ///< between two enable frames
  static constexpr int kMaxEnables = 50;                         ///< of one attempt
  /// A drive not in operation that was silent for this long may have been off: it is asked anew.
  static constexpr std::int64_t kForgetNs = 100'000'000;
  /// What brakes the joint while there is no command that could be sent [N·m·s/rad].
  static constexpr double kFallbackDamping = 0.5;

  /// @param options must pass check().
  explicit Driver(const DriveOptions& options);

  std::size_t transmit(const DriveCommand& command, std::int64_t now_ns,
                       std::span<Frame> out) noexcept override;
  bool receive(const ReceivedFrame& received) noexcept override;
  const DriveState& state() const noexcept override { return state_; }
  const DriveComplaint& complaint() const noexcept override;
  void restart() noexcept override;
  std::vector<IdFilter> reply_ids() const override;
  std::vector<IdFilter> command_ids() const override;

  /// Register sw_ver as the drive told; 0 before that.
  std::uint32_t firmware() const noexcept { return start_up_.firmware(); }

 private:
  enum class Phase : std::uint8_t {
    kStartUp,
    kIdle,      ///< configured, disabled
    kEnabling,  ///< asked to enable, not confirmed
    kEnabled,
    kDisabling,  ///< asked to disable, not confirmed
    kOut,        ///< left enabled untold, or would not become enabled
    kRefused,
  };

  void follow(control::DriveMode mode, std::int64_t now_ns) noexcept;
  void begin_start_up() noexcept;
  Frame enabling_frame(std::int64_t now_ns) noexcept;
  Frame disabling_frame() noexcept;
  Frame torque_frame(const DriveCommand& command) noexcept;
  /// With what earlier codes rounded away, if DriveOptions::error_diffusion.
  Frame diffused_frame(MitCommand command) noexcept;
  Frame brake_frame(double damping) const noexcept;
  void take_status(std::uint8_t status) noexcept;
  /// A drive counts within +-PMAX and wraps around; a step of more than half of that is a wrap.
  double unwrapped(double reported_rad) noexcept;
  void update_condition() noexcept;

  DriveOptions options_;
  Ranges ranges_;
  ErrorDiffusion diffusion_;  ///< owes nothing while the drive does not follow torque
  StartUp start_up_;
  Phase phase_ = Phase::kStartUp;
  control::DriveMode mode_ = control::DriveMode::kMonitor;
  bool enable_due_ = false;    ///< the mode has become kEnable and no attempt was made yet
  bool zero_sent_ = false;     ///< kDisabling: zero torque has left
  bool disable_sent_ = false;  ///< kDisabling: so has the disable frame
  int enables_ = 0;
  std::int64_t next_enable_ns_ = 0;
  std::int64_t last_heard_ns_ = 0;
  std::uint8_t status_ = 0;
  bool counting_ = false;  ///< reported_rad_ is what it reported last
  double reported_rad_ = 0.0;
  double wraps_ = 0.0;  ///< whole spans of 2 PMAX, up
  DriveState state_;
  DriveComplaint complaint_;
};

}  // namespace geodesic::drivers::damiao
