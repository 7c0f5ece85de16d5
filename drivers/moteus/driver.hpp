// The host's side of one moteus drive: which frame leaves in which cycle, and what a reply means.
// Bytes are codec.hpp's, the start-up dialogue is start_up.hpp's.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "drivers/drive.hpp"
#include "drivers/error_diffusion.hpp"
#include "drivers/moteus/codec.hpp"
#include "drivers/moteus/start_up.hpp"

namespace geodesic::drivers::moteus {

/// How this drive's registers travel: by `resolution`, wider where 16 bits would saturate.
Formats formats_for(const DriveOptions& options) noexcept;
Link link_for(const DriveOptions& options) noexcept;

/// Contracts as drivers::Drive. One frame a cycle at most, and every frame brings one answer.
///
/// A moteus frame both asks for position mode and brings its torque. So that torque never comes
/// back by itself, such frames leave only from an attempt to enable (on the way into
/// DriveMode::kEnable) until the drive tells another mode than position, or is silent for
/// kForgetNs; then it is out until the mode has been another one, and the start-up dialogue is held
/// again.
class Driver final : public Drive {
 public:
  static constexpr std::int64_t kEnableNs = 500'000'000;  ///< one attempt lasts no longer
  /// A drive that was silent for this long may have been off: it is asked anew.
  static constexpr std::int64_t kForgetNs = 100'000'000;
  /// Older than this, a report is no ground for stiffness or damping made here.
  static constexpr std::int64_t kFreshNs = 5'000'000;
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

  /// Register 0x101 as the drive told; 0 before that.
  std::uint32_t firmware() const noexcept { return start_up_.firmware(); }

 private:
  enum class Phase : std::uint8_t {
    kStartUp,
    kIdle,      ///< configured, stopped
    kEnabling,  ///< asked for position mode, not confirmed
    kEnabled,
    kDisabling,  ///< asked to stop, not confirmed
    kOut,        ///< left position mode untold, or would not enter it
    kRefused,
  };

  void follow(control::DriveMode mode, std::int64_t now_ns) noexcept;
  void begin_start_up() noexcept;
  void leave() noexcept;
  Frame position_frame(const DriveCommand& command, std::int64_t now_ns) noexcept;
  Frame torque_frame(const DriveCommand& command, std::int64_t now_ns) noexcept;
  Frame disabling_frame(std::int64_t now_ns) noexcept;
  bool read_back(const Frame& reply) noexcept;
  void take_mode(const StateReport& report, const Frame& reply) noexcept;
  bool take_measures(const StateReport& report, std::int64_t stamp_ns) noexcept;
  void update_condition() noexcept;

  DriveOptions options_;
  Link link_;
  Formats formats_;
  double kp_nm_rad_;    ///< what kp scale 1 makes; 0: unknown
  double kd_nm_s_rad_;  ///< what kd scale 1 makes; 0: unknown
  StartUp start_up_;
  ErrorDiffusion diffusion_;
  Phase phase_ = Phase::kStartUp;
  control::DriveMode mode_ = control::DriveMode::kMonitor;
  bool enable_due_ = false;  ///< the mode has become kEnable and no attempt was made yet
  bool zero_sent_ = false;   ///< kDisabling: zero torque has left
  bool stop_sent_ = false;   ///< kDisabling: so has a stop
  std::int64_t enable_until_ns_ = 0;
  std::int64_t last_heard_ns_ = 0;
  std::uint8_t told_ = 0;  ///< the mode it reported last
  std::uint8_t fault_ = 0;
  DriveState state_;
  DriveComplaint complaint_;
};

}  // namespace geodesic::drivers::moteus
