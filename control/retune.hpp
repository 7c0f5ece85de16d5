// One joint's torque on its way from an old setup to a new one: what the old one made beyond the
// new one at the exchange, fading out. Arithmetic only; when it begins is the controller's.
#pragma once

#include <algorithm>
#include <cmath>

namespace geodesic::control {

/// Torque leaves as
///   clamp(clamp(wanted, limit) + offset * fraction * scale, limit + excess * fraction)
/// where `wanted` and `limit` are the new setup's, and fraction falls linearly from 1 to 0. At the
/// exchange that is the torque that left last. From cycle to cycle it changes by no more than
/// wanted does by itself plus step() (a clamp is no steeper than its argument and its bound), and
/// once fraction is 0 it is the new setup's to the bit.
struct Retune {
  double offset = 0.0;          ///< [N·m or N]
  double excess = 0.0;          ///< what left last beyond the new torque limit [N·m or N], >= 0
  double damping_offset = 0.0;  ///< of the drive-side damping [N·m·s/rad]
  double fraction = 0.0;        ///< 1 at the exchange, 0: done
  double fraction_rate = 0.0;   ///< [1/s]
  double scale_at_start = 1.0;  ///< how far lowering had come at the exchange: 1..0

  bool under_way() const noexcept { return fraction > 0.0; }

  /// @param left     torque that left in the last cycle      @param wanted  by the new setup then
  /// @param damping  drive-side damping by the old setup - by the new one
  /// @param scale    what lowering leaves of the torque, 1..0
  /// All finite but the limits, which may be infinite.
  void begin(double left, double wanted, double limit, double rate_limit, double damping,
             double retune_s, double scale) noexcept {
    offset = left - std::clamp(wanted, -limit, limit);
    excess = std::max(0.0, std::abs(left) - limit);
    damping_offset = damping;
    scale_at_start = scale;
    // Not faster than the joint's own torque_rate_limit; |excess| <= |offset|.
    const double duration_s = std::max(retune_s, std::abs(offset) / rate_limit);
    const bool needed = offset != 0.0 || damping != 0.0;
    fraction = needed ? 1.0 : 0.0;
    fraction_rate = 1.0 / duration_s;
  }

  /// One cycle on. The command of the exchange's cycle has left already.
  void advance(double period_s) noexcept {
    fraction = std::max(0.0, fraction - fraction_rate * period_s);
  }

  /// Largest change of torque by the exchange in a cycle [N·m or N].
  double step(double period_s) const noexcept {
    return std::abs(offset) * fraction_rate * period_s;
  }

  double limit(double new_limit) const noexcept {
    return under_way() ? new_limit + excess * fraction : new_limit;
  }

  /// @param scale  what lowering leaves of the torque; never rises.
  double torque(double wanted, double new_limit, double scale) const noexcept {
    if (!under_way() || !std::isfinite(wanted)) {
      return wanted;
    }
    const double part = scale_at_start > 0.0 ? fraction * (scale / scale_at_start) : 0.0;
    return std::clamp(wanted, -new_limit, new_limit) + offset * part;
  }

  double damping(double wanted) const noexcept {
    return under_way() ? std::max(0.0, wanted + damping_offset * fraction) : wanted;
  }
};

}  // namespace geodesic::control
