// The host's side of one RobStride or CyberGear drive: which frame leaves in which cycle, and what
// a report means. Bytes are codec.hpp's, the start-up dialogue is start_up.hpp's.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "drivers/drive.hpp"
#include "drivers/error_diffusion.hpp"
#include "drivers/robstride/codec.hpp"
#include "drivers/robstride/start_up.hpp"

namespace geodesic::drivers::robstride {

/// Contracts as drivers::Drive. Every frame but one of the start-up brings one answer.
///
/// Torque never comes back by itself: the drive is enabled only on the way into DriveMode::kEnable.
/// One that leaves run mode untold, has a fault, was switched off and on or does not become enabled
/// stays out until the mode has been another one; then the whole start-up dialogue is held again
/// before the next attempt.
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
  std::size_t answers_due(std::size_t frames) const noexcept override;
  bool receive(const ReceivedFrame& received) noexcept override;
  const DriveState& state() const noexcept override { return state_; }
  const DriveComplaint& complaint() const noexcept override;
  void restart() noexcept override;
  std::vector<IdFilter> reply_ids() const override;
  std::vector<IdFilter> command_ids() const override;

  /// As the drive told, see decode_version(); 0 before that.
  std::uint32_t firmware() const noexcept { return start_up_.firmware(); }

 private:
  enum class Phase : std::uint8_t {
    kStartUp,
    kIdle,      ///< configured, stopped
    kEnabling,  ///< asked to run, not confirmed
    kEnabled,
    kDisabling,  ///< asked to stop, not confirmed
    kOut,        ///< left run mode untold, or would not enter it
    kRefused,
  };

  void follow(control::DriveMode mode, std::int64_t now_ns) noexcept;
  void begin_start_up() noexcept;
  std::size_t enabling_frames(std::int64_t now_ns, std::span<Frame> out) noexcept;
  Frame disabling_frame() noexcept;
  Frame torque_frame(const DriveCommand& command) noexcept;
  Frame brake_frame(double damping) const noexcept;
  void go_out(std::uint8_t error) noexcept;
  bool take_feedback(const ReceivedFrame& received) noexcept;
  void take_faults(const FaultReport& report) noexcept;
  void take_identity() noexcept;
  void take_mode(std::uint8_t mode, std::uint8_t faults) noexcept;
  double unwrapped(double reported_rad) noexcept;
  void update_condition() noexcept;

  DriveOptions options_;
  Link link_;
  Ranges ranges_;
  bool wraps_around_;
  StartUp start_up_;
  ErrorDiffusion diffusion_;
  Phase phase_ = Phase::kStartUp;
  control::DriveMode mode_ = control::DriveMode::kMonitor;
  bool enable_due_ = false;    ///< the mode has become kEnable and no attempt was made yet
  bool zero_sent_ = false;     ///< kDisabling: zero torque has left
  bool disable_sent_ = false;  ///< kDisabling: so has the stop frame
  int enables_ = 0;
  std::int64_t next_enable_ns_ = 0;
  std::int64_t last_heard_ns_ = 0;
  std::uint8_t drive_mode_ = 0;  ///< as in its last feedback, and its faults
  std::uint8_t faults_ = 0;
  std::uint8_t latched_ = 0;  ///< error code of what put it out, until the next start-up
  bool counting_ = false;     ///< reported_rad_ is what it reported last
  double reported_rad_ = 0.0;
  double turns_ = 0.0;  ///< whole spans of kWrapRad, up
  DriveState state_;
  DriveComplaint complaint_;
};

}  // namespace geodesic::drivers::robstride
