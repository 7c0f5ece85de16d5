// Parameters of a 0.6 drive that have an endpoint in the robot file: read, compared, where that is
// allowed written, and read back, one after the other.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "drivers/odrive/codec.hpp"
#include "drivers/odrive/settings.hpp"

namespace geodesic::drivers::odrive {

/// Real-time throughout.
class ParameterCheck {
 public:
  static constexpr std::int64_t kReplyTimeoutNs = 20'000'000;
  /// Firmware 0.6.11 and on confirms a write; that is not what is read back.
  static constexpr std::int64_t kSettleNs = 10'000'000;
  static constexpr int kMaxReads = 25;  ///< of a parameter that a living drive does not answer for
  static constexpr int kMaxWrites = 10;

  explicit ParameterCheck(const DriveOptions& options) noexcept;

  /// @param period_ns  of the control loop: cyclic reports are wanted as often.
  void restart(std::int64_t period_ns) noexcept;
  /// The next request, if one is due.
  std::optional<Frame> request(std::int64_t now_ns) noexcept;
  void receive(const ReceivedFrame& received) noexcept;

  bool done() const noexcept { return at_ == kParameterCount; }
  bool refused() const noexcept { return complaint_.quantity != nullptr; }
  const DriveComplaint& complaint() const noexcept { return complaint_; }
  /// Both the time-out and the enabling have endpoints.
  bool covers_watchdog() const noexcept;

 private:
  bool wanted(Parameter parameter) const noexcept;
  double target(Parameter parameter) const noexcept;
  void skip_unwanted() noexcept;
  void next() noexcept;
  void refuse(double found, const char* fix) noexcept;

  std::uint32_t node_;
  double watchdog_s_;
  Settings settings_;
  std::int64_t period_ns_ = 1'000'000;
  std::size_t at_ = 0;
  bool writing_ = false;
  bool awaiting_ = false;
  std::int64_t asked_ns_ = 0;
  std::int64_t settled_ns_ = 0;
  int reads_ = 0;
  int writes_ = 0;
  DriveComplaint complaint_;
};

}  // namespace geodesic::drivers::odrive
