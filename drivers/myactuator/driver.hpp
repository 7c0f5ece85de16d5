// The host's side of one MyActuator drive, by current (0xA1) or in motion mode: which frame leaves
// in which cycle, and what a reply means. Bytes are codec.hpp's, the dialogue is start_up.hpp's.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "drivers/drive.hpp"
#include "drivers/error_diffusion.hpp"
#include "drivers/myactuator/codec.hpp"
#include "drivers/myactuator/settings.hpp"
#include "drivers/myactuator/start_up.hpp"
#include "drivers/velocity_check.hpp"

namespace geodesic::drivers::myactuator {

/// Contracts as drivers::Drive. By current two frames a cycle (0xA1, then 0x92 for the position),
/// in motion mode one; every kStatusIntervalNs one more, since only status 1 tells errors.
///
/// After its watchdog the drive takes up torque again with the second command. So this side
/// latches: silence of either for longer than the watchdog, the drive's notice of it, a command
/// sent back, an error: the drive is out until the mode has been another one, and then brought up
/// anew.
class Driver final : public Drive {
 public:
  static constexpr std::int64_t kEnableIntervalNs = 10'000'000;
  static constexpr int kMaxEnables = 50;  ///< of one attempt
  static constexpr std::int64_t kStatusIntervalNs = 50'000'000;
  /// A drive not in operation that was silent for this long may have been off.
  static constexpr std::int64_t kForgetNs = 100'000'000;
  /// Asked for more than this share of its range and making less than half: status 1 at once.
  static constexpr double kAskedShare = 0.005;
  /// But not more often than this.
  static constexpr std::int64_t kSoonestNs = 10'000'000;
  static constexpr double kFallbackDamping = 0.5;  ///< [N·m·s/rad]
  /// Shut-downs to be answered when the drive is out: the first answer may be a request sent back.
  static constexpr int kShutdowns = 4;
  /// An angle of exactly 0 may be a request sent back; so far from the last one it must come twice.
  static constexpr double kNearZeroRad = 0.1;

  /// @param options must pass check().
  explicit Driver(const DriveOptions& options);

  std::size_t transmit(const DriveCommand& command, std::int64_t now_ns,
                       std::span<Frame> out) noexcept override;
  std::size_t answers_due(std::size_t frames) const noexcept override {
    return phase_ == Phase::kStartUp && !start_up_.answer_due() ? 0 : frames;
  }
  bool receive(const ReceivedFrame& received) noexcept override;
  const DriveState& state() const noexcept override { return state_; }
  const DriveComplaint& complaint() const noexcept override;
  void restart() noexcept override;
  std::vector<IdFilter> reply_ids() const override;
  std::vector<IdFilter> command_ids() const override;

  /// Version date as YYYYMMDD; 0 before it was read.
  std::uint32_t firmware() const noexcept { return start_up_.firmware(); }

 private:
  enum class Phase : std::uint8_t {
    kStartUp,
    kIdle,
    kEnabling,
    kEnabled,
    kDisabling,
    kOut,  ///< stays away until the mode has been another one
    kRefused,
  };

  void follow(control::DriveMode mode, std::int64_t now_ns) noexcept;
  void begin_start_up() noexcept;
  void fall_out(const DriveComplaint& complaint) noexcept;
  bool following() const noexcept {
    return phase_ == Phase::kEnabling || phase_ == Phase::kEnabled;
  }
  std::size_t start_up_frames(std::int64_t now_ns, std::span<Frame> out) noexcept;
  std::size_t enabling_frames(std::int64_t now_ns, std::span<Frame> out) noexcept;
  std::size_t enabled_frames(const DriveCommand& command, std::int64_t now_ns,
                             std::span<Frame> out) noexcept;
  std::size_t disabling_frames(std::span<Frame> out) noexcept;
  std::size_t asking_frames(std::int64_t now_ns, std::span<Frame> out) noexcept;
  std::size_t status_frame(std::int64_t now_ns, std::span<Frame> out) noexcept;
  std::int64_t own_share_of(std::int64_t interval_ns) const noexcept;
  Frame torque_frame(const DriveCommand& command) noexcept;
  Frame motion_frame(const DriveCommand& command) noexcept;
  Frame zero_frame() const noexcept;
  Frame request(Command command) const noexcept { return encode_request(options_.id, command); }
  bool take(const Frame& frame, std::int64_t stamp_ns) noexcept;
  void take_status(const Frame& frame) noexcept;
  void take_loop_reply(const Frame& frame) noexcept;
  bool take_angle(const Frame& frame, std::int64_t stamp_ns) noexcept;
  bool take_motion_reply(const Frame& frame, std::int64_t stamp_ns) noexcept;
  void look_at_torque() noexcept;
  void become_enabled() noexcept;
  void update_condition() noexcept;

  DriveOptions options_;
  Facts facts_;
  Ranges ranges_;
  StartUp start_up_;
  VelocityCheck velocity_check_;
  ErrorDiffusion diffusion_;
  Phase phase_ = Phase::kStartUp;
  control::DriveMode mode_ = control::DriveMode::kMonitor;
  bool enable_due_ = false;
  bool zero_sent_ = false;
  bool disable_sent_ = false;
  bool torque_answered_ = false;  ///< kEnabling: a command of ours was obeyed
  bool status_heard_ = false;     ///< kEnabling: status 1 came, and was without error
  bool brake_released_ = false;   ///< as status 1 last said
  bool bare_reply_ = false;       ///< the last reply to A1 was one
  bool bare_angle_ = false;       ///< the last reply to 92 was one
  int enables_ = 0;
  int shutdowns_ = 0;
  Frame last_torque_;
  double asked_nm_ = 0.0;  ///< by it
  std::int64_t next_enable_ns_ = 0;
  std::int64_t next_status_ns_ = 0;
  std::int64_t last_status_ns_ = 0;
  bool asked_angle_ = false;  ///< motion mode, not in operation: angle and status 2 take turns
  std::int64_t last_transmit_ns_ = 0;
  std::int64_t last_heard_ns_ = 0;
  std::uint16_t errors_ = 0;
  DriveState state_;
  DriveComplaint complaint_;
};

}  // namespace geodesic::drivers::myactuator
