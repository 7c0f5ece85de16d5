// Carries what a torque code rounds away into the next cycle, so that the mean torque is exact
// though its steps are coarse (12 bits: 5 to 98 mN·m). Floyd & Steinberg 1976, in one dimension.
#pragma once

#include <cmath>

namespace geodesic::drivers {

/// Real-time throughout.
class ErrorDiffusion {
 public:
  /// @param step_nm  one code of the torque field; no more than this is ever owed.
  constexpr ErrorDiffusion(bool on, double step_nm) noexcept : step_nm_(on ? step_nm : 0.0) {}

  /// What to ask for, so that what was rounded away comes back.
  double next(double wanted_nm) const noexcept { return wanted_nm + owed_nm_; }

  /// What went out for `wanted_nm`. Beyond a step, clamping took it away, and that is not owed.
  void went(double wanted_nm, double sent_nm) noexcept {
    const double owed_nm = owed_nm_ + wanted_nm - sent_nm;
    owed_nm_ = std::isfinite(owed_nm) && std::abs(owed_nm) <= step_nm_ ? owed_nm : 0.0;
  }

  void reset() noexcept { owed_nm_ = 0.0; }

 private:
  double step_nm_;
  double owed_nm_ = 0.0;
};

}  // namespace geodesic::drivers
