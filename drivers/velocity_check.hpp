// Whether the velocity a drive reports is the change of the position it reports. Drives that cannot
// be asked for their ranges show a wrong one here as soon as the joint moves, by hand say.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace geodesic::drivers {

/// Integrates velocity over windows and compares with the way gone. Real-time throughout.
class VelocityCheck {
 public:
  static constexpr std::int64_t kWindowNs = 2'000'000'000;  ///< no window is longer
  static constexpr double kFullWindowRad = 4.0;             ///< this far is enough for one
  static constexpr double kLeastRad = 1.0;                  ///< less says nothing
  static constexpr double kTolerance = 0.06;                ///< of the way
  static constexpr double kSlackRad = 0.05;                 ///< filter delay of the velocity
  static constexpr std::int64_t kMostGapNs = 20'000'000;    ///< between two reports
  static constexpr int kBadWindows = 2;                     ///< in a row, and it contradicts

  /// @param step_rad_s  one code of the velocity: it may be off by so much all the time.
  VelocityCheck(bool on, double step_rad_s) noexcept : on_(on), step_rad_s_(step_rad_s) {}

  void restart() noexcept {
    running_ = false;
    bad_windows_ = 0;
  }

  /// @param counts  this report may be held against the drive: it is at rest or slow.
  /// @return true: velocity and position contradict each other.
  bool take(double position_rad, double velocity_rad_s, std::int64_t stamp_ns,
            bool counts) noexcept {
    const std::int64_t gap_ns = stamp_ns - stamp_ns_;
    const bool goes_on = on_ && counts && running_ && gap_ns >= 0 && gap_ns <= kMostGapNs;
    if (goes_on) {
      integral_rad_ +=
          0.5 * (velocity_rad_s + velocity_rad_s_) * static_cast<double>(gap_ns) * 1e-9;
    } else {
      begin_rad_ = position_rad;
      begin_ns_ = stamp_ns;
      integral_rad_ = 0.0;
    }
    running_ = on_ && counts;
    velocity_rad_s_ = velocity_rad_s;
    stamp_ns_ = stamp_ns;
    return goes_on && close(position_rad);
  }

  /// Velocity as reported over the velocity that the positions tell, of the last bad window.
  double ratio() const noexcept { return ratio_; }

 private:
  bool close(double position_rad) noexcept {
    const double way = position_rad - begin_rad_;
    const double most = std::max(std::abs(way), std::abs(integral_rad_));
    const std::int64_t lasted_ns = stamp_ns_ - begin_ns_;
    if (most < kFullWindowRad && lasted_ns < kWindowNs) {
      return false;
    }
    running_ = false;  // the next report begins the next window
    if (most < kLeastRad) {
      return false;
    }
    const double allowed =
        kTolerance * most + kSlackRad + step_rad_s_ * static_cast<double>(lasted_ns) * 1e-9;
    if (std::abs(integral_rad_ - way) <= allowed) {
      bad_windows_ = 0;
      return false;
    }
    ratio_ = way != 0.0 ? integral_rad_ / way : 0.0;
    return ++bad_windows_ >= kBadWindows;
  }

  bool on_;
  double step_rad_s_;
  bool running_ = false;
  int bad_windows_ = 0;
  double begin_rad_ = 0.0;
  std::int64_t begin_ns_ = 0;
  double integral_rad_ = 0.0;
  double velocity_rad_s_ = 0.0;
  std::int64_t stamp_ns_ = 0;
  double ratio_ = 1.0;
};

}  // namespace geodesic::drivers
