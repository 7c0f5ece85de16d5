// The host's side of one CubeMars drive, in MIT mode or in servo mode: which frame leaves in which
// cycle, and what a report means. Bytes are codec.hpp's, the way there is start_up.hpp's.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "drivers/cubemars/codec.hpp"
#include "drivers/cubemars/settings.hpp"
#include "drivers/cubemars/start_up.hpp"
#include "drivers/drive.hpp"
#include "drivers/error_diffusion.hpp"
#include "drivers/velocity_check.hpp"

namespace geodesic::drivers::cubemars {

/// Contracts as drivers::Drive. One frame a cycle, three in the one that enables.
///
/// The drive tells neither that it is enabled nor that its watchdog expired, and takes up torque by
/// itself when commands come again. So this side latches: silence of either for longer than the
/// watchdog, an error, reported torque that does not follow, a position at the edge of its range:
/// the drive is out until the mode has been another one, and is then brought up anew.
class Driver final : public Drive {
 public:
  static constexpr std::int64_t kEnableIntervalNs = 10'000'000;
  static constexpr int kMaxEnables = 50;  ///< of one attempt
  /// Replies after which the drive counts as enabled: those to the frames around the first enable.
  static constexpr int kEnabledReplies = 4;
  /// A drive not in operation that was silent for this long may have been off.
  static constexpr std::int64_t kForgetNs = 100'000'000;
  static constexpr double kFallbackDamping = 0.5;  ///< [N·m·s/rad]
  /// A drive that is asked for more than this share of its range...
  static constexpr double kAskedShare = 0.05;
  /// ...and reports less than this share of what it is asked for...
  static constexpr double kFollowedShare = 0.25;
  static constexpr std::int64_t kFollowNs = 200'000'000;  ///< ...for so long does not follow.
  static constexpr int kReleases = 5;  ///< servo mode: frames of zero current when it ends

  /// @param options must pass check().
  explicit Driver(const DriveOptions& options);

  std::size_t transmit(const DriveCommand& command, std::int64_t now_ns,
                       std::span<Frame> out) noexcept override;
  std::size_t answers_due(std::size_t frames) const noexcept override {
    return facts_.servo ? 0 : frames;
  }
  bool speaks_unasked() const noexcept override { return facts_.servo; }
  bool claims(const Frame& frame) const noexcept override;
  bool receive(const ReceivedFrame& received) noexcept override;
  const DriveState& state() const noexcept override { return state_; }
  const DriveComplaint& complaint() const noexcept override;
  void restart() noexcept override;
  std::vector<IdFilter> reply_ids() const override;
  std::vector<IdFilter> command_ids() const override;

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
  struct Report {
    double position_rad = 0.0;
    double velocity_rad_s = 0.0;
    double torque_nm = 0.0;
    double temperature_c = 0.0;
    std::uint8_t error = 0;
  };

  void follow(control::DriveMode mode, std::int64_t now_ns) noexcept;
  void begin_start_up() noexcept;
  void fall_out(const DriveComplaint& complaint) noexcept;
  void refuse(const DriveComplaint& complaint) noexcept;
  bool following() const noexcept {
    return phase_ == Phase::kEnabling || phase_ == Phase::kEnabled;
  }
  std::size_t enabling_frames(std::int64_t now_ns, std::span<Frame> out) noexcept;
  std::size_t disabling_frames(std::span<Frame> out) noexcept;
  std::size_t released_frames(std::span<Frame> out) noexcept;
  Frame torque_frame(const DriveCommand& command) noexcept;
  Frame mit_frame(const DriveCommand& command) noexcept;
  Frame current_frame() const noexcept;
  Frame zero_frame() const noexcept;
  bool take_other_servo_frame(const Frame& frame) noexcept;
  bool take(const Report& report, std::int64_t stamp_ns) noexcept;
  void look_at_position(double position_rad) noexcept;
  void look_at_velocity(const Report& report, std::int64_t stamp_ns) noexcept;
  void look_at_torque(double reported_nm, std::int64_t stamp_ns) noexcept;
  void advance(std::uint8_t error, std::int64_t stamp_ns) noexcept;
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
  int enables_ = 0;
  int enabled_replies_ = 0;
  int releases_ = 0;
  std::int64_t next_enable_ns_ = 0;
  std::int64_t last_transmit_ns_ = 0;
  std::int64_t last_heard_ns_ = 0;
  bool counting_ = false;  ///< reported_rad_ is what it reported last
  double reported_rad_ = 0.0;
  double asked_nm_ = 0.0;  ///< of the drive, by the last frame
  std::int64_t followed_ns_ = 0;
  std::uint8_t error_ = 0;
  DriveState state_;
  DriveComplaint complaint_;
};

}  // namespace geodesic::drivers::cubemars
