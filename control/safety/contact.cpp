// Implements contact.hpp.
#include "control/safety/contact.hpp"

#include <algorithm>
#include <cmath>

namespace geodesic::control {

void ContactDetector::update(const ControllerOptions& options,
                             const std::array<double, kMaxJoints>& torque, BitSet observed,
                             double period_s) noexcept {
  const std::size_t joints = std::min(options.joints.size(), kMaxJoints);
  touched_ &= observed;
  for (std::size_t i = 0; i < joints; ++i) {
    if (!has(observed, i)) {
      continue;
    }
    const double begins = kContactLevel * options.joints[i].contact_torque;
    const double ends = (1.0 - options.contact.hysteresis) * begins;
    const double size = std::abs(torque[i]);
    below_s_[i] = size < ends ? below_s_[i] + period_s : 0.0;
    if (size >= begins) {
      touched_ |= bit(i);
    } else if (below_s_[i] > options.contact.release_s) {
      touched_ &= ~bit(i);
    }
  }
}

}  // namespace geodesic::control
