// The dialogue that turns a MyActuator drive of unknown state into one that is shut down, free of
// error, new enough, with its watchdog set. What follows is driver.hpp's.
#pragma once

#include <cstdint>

#include "drivers/drive.hpp"
#include "drivers/myactuator/codec.hpp"
#include "drivers/myactuator/settings.hpp"

namespace geodesic::drivers::myactuator {

/// One request at a time. The first is status 1, since the drive sends the first request after its
/// watchdog back unexecuted, and of this one that shows: no drive runs at 0 V. Real-time
/// throughout.
class StartUp {
 public:
  static constexpr std::int64_t kReplyTimeoutNs = 20'000'000;
  static constexpr std::int64_t kResetNs = 1'500'000'000;  ///< it starts anew for so long
  static constexpr int kMaxTries = 25;                     ///< of what a living drive ignores
  static constexpr int kMaxClears = 3;
  /// Motion mode: how far its position may be from that of 0x92, at rest and per speed.
  static constexpr double kToleranceRad = 2e-3;
  static constexpr double kToleranceS = 0.05;

  explicit StartUp(const DriveOptions& options);

  void restart() noexcept;
  /// @return false: an answer is still awaited, or there is nothing to ask.
  bool transmit(std::int64_t now_ns, Frame& out) noexcept;
  /// The last request brings an answer.
  bool answer_due() const noexcept { return step_ != Step::kReset; }
  void receive(const Frame& frame) noexcept;

  bool done() const noexcept { return step_ == Step::kDone; }
  bool refused() const noexcept { return step_ == Step::kRefused; }
  bool heard() const noexcept { return heard_; }
  bool held_by_error() const noexcept { return held_by_error_; }
  std::uint16_t errors() const noexcept { return errors_; }
  /// Version date as YYYYMMDD; 0 before it was read.
  std::uint32_t firmware() const noexcept { return firmware_; }
  const DriveComplaint& complaint() const noexcept { return complaint_; }

 private:
  enum class Step : std::uint8_t {
    kStatus,    ///< no error, or clear it
    kReset,     ///< clears it
    kShutdown,  ///< whoever left it running
    kVersion,
    kWatchdog,  ///< set; the answer says what it took
    kAngle,
    kMotion,  ///< motion mode: its position is that of 0x92
    kShutdownAgain,
    kConfirm,
    kDone,
    kRefused,
  };

  void enter(Step step) noexcept;
  void refuse(const DriveComplaint& complaint) noexcept;
  Frame request() const noexcept;
  bool answers(const Frame& frame) const noexcept;
  void take_status(const Frame& frame) noexcept;
  void take_version(const Frame& frame) noexcept;
  void take_angle(const Frame& frame) noexcept;
  void take_motion(const Frame& frame) noexcept;

  DriveOptions options_;
  Facts facts_;
  Ranges ranges_;
  Step step_ = Step::kStatus;
  bool awaiting_ = false;
  bool heard_ = false;
  bool held_by_error_ = false;
  bool bare_angle_ = false;  ///< 0 degrees, or the request sent back
  int tries_ = 0;
  int clears_ = 0;
  std::int64_t next_ns_ = 0;
  std::uint16_t errors_ = 0;
  std::uint32_t firmware_ = 0;
  double angle_rad_ = 0.0;
  DriveComplaint complaint_;
};

}  // namespace geodesic::drivers::myactuator
