// When an external torque counts as a contact, joint by joint. What follows is the policy table's
// business, where the torque comes from the observer's (external_torque.hpp).
#pragma once

#include <array>
#include <cstdint>

#include "control/options.hpp"
#include "control/safety/supervisor.hpp"

namespace geodesic::control {

/// A contact begins where the observed torque passes this part of contact_torque. The observer is a
/// low pass: a step of exactly contact_torque passes it ln(4) / (2 pi observer_hz) later, which is
/// 4.4 ms at 50 Hz; with two cycles until it is measured that leaves room within 10 ms.
inline constexpr double kContactLevel = 0.75;

class ContactDetector {
 public:
  /// One cycle. @param observed  joints whose `torque` is to be judged; the others are in no
  /// contact. Real-time.
  void update(const ControllerOptions& options, const std::array<double, kMaxJoints>& torque,
              BitSet observed, double period_s) noexcept;

  BitSet touched() const noexcept { return touched_; }

 private:
  BitSet touched_ = 0;
  std::array<double, kMaxJoints> below_s_{};  // since when it would have ended
};

}  // namespace geodesic::control
