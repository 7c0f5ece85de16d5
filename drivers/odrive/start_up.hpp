// The dialogue that turns an ODrive of unknown state into one that is idle, free of error, checked
// against the configuration, watched over by its own watchdog and set for torque. What follows is
// driver.hpp's; what is read and written by endpoint is parameters.hpp's.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "drivers/drive.hpp"
#include "drivers/odrive/parameters.hpp"
#include "drivers/odrive/settings.hpp"
#include "drivers/odrive/status.hpp"

namespace geodesic::drivers::odrive {

/// Asks for the error word along with whatever else it asks, so that every cycle in which it sends
/// brings an answer. Real-time throughout.
class StartUp {
 public:
  static constexpr std::int64_t kReplyTimeoutNs = 20'000'000;
  static constexpr std::int64_t kPatienceNs = 1'500'000'000;  ///< for the first heartbeat
  static constexpr int kProbes = 10;     ///< answers to command 03 without one to 00: firmware 0.5
  static constexpr int kMaxClears = 10;  ///< of errors, as told to
  static constexpr int kMaxWatchdogClears = 3;   ///< of a watchdog that expired while idle
  static constexpr std::uint32_t kSamples = 24;  ///< reports that are timed
  static constexpr std::int64_t kSlowestHeartbeatNs = 250'000'000;
  /// The watchdog may expire this late, beyond the heartbeat that tells.
  static constexpr std::int64_t kProofSlackNs = 20'000'000;

  explicit StartUp(const DriveOptions& options);

  /// @param expired  the watchdog expired while the drive was ours to move: no idle one.
  void restart(bool expired) noexcept;

  /// This cycle's frames, at most Drive::kMaxFramesPerCycle. @return how many.
  std::size_t transmit(std::int64_t now_ns, const Status& status, std::span<Frame> out) noexcept;
  /// Every frame of the drive, after `status` has taken it.
  void receive(const ReceivedFrame& received, const Status& status) noexcept;

  /// How many of the last transmit()'s frames bring an answer.
  std::size_t answers_due() const noexcept { return due_; }
  bool done() const noexcept { return step_ == Step::kDone; }
  bool refused() const noexcept { return step_ == Step::kRefused; }
  /// It is the firmware we take it for.
  bool firmware_verified() const noexcept { return verified_; }
  bool heard() const noexcept { return heard_; }
  /// The drive is in error and is not, or no longer, cleared.
  bool held_by_error() const noexcept { return held_; }
  /// Set-points do not feed this drive's watchdog while it is idle: its error is cleared directly
  /// before the drive is enabled.
  bool idle_expires() const noexcept { return idle_expires_; }
  const DriveComplaint& complaint() const noexcept { return complaint_; }

 private:
  enum class Step : std::uint8_t {
    kListen,      ///< hear a heartbeat, and see the axis idle
    kVersion,     ///< ask for the version until it comes, or certainly does not
    kErrors,      ///< read all error words and judge them
    kClear,       ///< Clear_Errors, then judge again
    kParameters,  ///< read, and where allowed write, what endpoints are known of
    kSilence,     ///< send nothing until the watchdog expires
    kRates,       ///< time the cyclic reports
    kConfigure,   ///< limits and mode
    kConfirm,     ///< a heartbeat after that: idle, no error
    kDone,
    kRefused,
  };

  void enter(Step step, std::int64_t now_ns) noexcept;
  void refuse(const DriveComplaint& complaint) noexcept;
  void advance(std::int64_t now_ns, const Status& status) noexcept;
  void listen(std::int64_t now_ns, const Status& status) noexcept;
  void probe(std::int64_t now_ns, const Status& status) noexcept;
  void judge(std::int64_t now_ns, const Status& status) noexcept;
  bool watchdog_known() const noexcept;
  void after_errors(std::int64_t now_ns) noexcept;
  void wait_for_expiry(std::int64_t now_ns, const Status& status) noexcept;
  void time_reports(std::int64_t now_ns) noexcept;
  void confirm(std::int64_t now_ns, const Status& status) noexcept;
  bool feeds() const noexcept;
  void add_step_frames(std::int64_t now_ns, const Status& status) noexcept;
  void add(const std::optional<Frame>& frame) noexcept;

  DriveOptions options_;
  Settings settings_;
  ParameterCheck parameters_;
  Step step_ = Step::kListen;
  Step after_errors_ = Step::kParameters;
  std::int64_t entered_ns_ = -1;
  std::int64_t asked_ns_ = 0;
  bool awaiting_ = false;
  bool heard_ = false;
  bool verified_ = false;
  bool held_ = false;
  bool expired_ = false;
  bool idle_expires_ = false;
  bool proven_ = false;
  int probes_ = 0;
  std::uint32_t probes_answered_ = 0;
  std::uint32_t answers_before_ = 0;
  std::uint32_t versions_before_ = 0;
  int clears_ = 0;
  int watchdog_clears_ = 0;
  int configured_ = 0;
  std::int64_t last_now_ns_ = -1;
  std::int64_t period_ns_ = 0;
  std::int64_t next_idle_ns_ = 0;
  struct Timing {
    std::uint32_t count = 0;
    std::int64_t first_ns = 0;
    std::int64_t last_ns = 0;
  };
  Timing estimates_;
  Timing torques_;
  std::span<Frame> out_;
  std::size_t count_ = 0;
  std::size_t due_ = 0;
  DriveComplaint complaint_;
};

}  // namespace geodesic::drivers::odrive
