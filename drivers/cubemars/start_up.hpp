// Bringing a CubeMars drive of unknown state to one that reports steadily, without error, out of
// torque control. It cannot be asked for its ranges; what can be seen of its mode is looked at.
#pragma once

#include <cstdint>

#include "drivers/cubemars/codec.hpp"
#include "drivers/cubemars/settings.hpp"
#include "drivers/drive.hpp"

namespace geodesic::drivers::cubemars {

/// Real-time throughout.
class StartUp {
 public:
  static constexpr std::int64_t kReplyTimeoutNs = 20'000'000;
  static constexpr int kSteadyReports = 5;  ///< in a row, without error
  /// Servo mode: no two reports may be further apart; nor may they be further than the watchdog.
  static constexpr std::int64_t kMostGapNs = 50'000'000;
  /// Servo mode: when to tell that no report comes, or not often enough.
  static constexpr std::int64_t kPatienceNs = 1'000'000'000;

  explicit StartUp(const DriveOptions& options);

  void restart() noexcept;
  /// @return false: an answer is awaited, or the drive reports without being asked.
  bool transmit(std::int64_t now_ns, Frame& out) noexcept;
  void receive(std::uint8_t error, std::int64_t stamp_ns) noexcept;

  bool done() const noexcept { return reports_ >= kSteadyReports; }
  bool heard() const noexcept { return heard_; }
  bool held_by_error() const noexcept { return held_by_error_; }
  const DriveComplaint& complaint() const noexcept { return complaint_; }

 private:
  std::uint32_t id_;
  bool servo_;
  std::int64_t most_gap_ns_;
  int reports_ = 0;
  bool heard_ = false;
  bool held_by_error_ = false;
  bool awaiting_ = false;
  bool begun_ = false;
  std::int64_t begun_ns_ = 0;
  std::int64_t asked_ns_ = 0;
  std::int64_t stamp_ns_ = 0;
  DriveComplaint complaint_;
};

}  // namespace geodesic::drivers::cubemars
