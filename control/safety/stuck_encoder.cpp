// Implements stuck_encoder.hpp.
#include "control/safety/stuck_encoder.hpp"

#include <algorithm>
#include <cmath>

namespace geodesic::control {
namespace {

constexpr double kLeastSpeed = 0.1;  // [rad/s or m/s]
// A position that has changed by this part of the way allowed is no longer where it stood.
constexpr double kMovedPart = 0.1;
constexpr std::int64_t kLongestStep = 20'000'000;  // [ns]

}  // namespace

void StuckEncoder::update(const ControllerOptions& options, const ArmState& state,
                          const Estimate& estimate) noexcept {
  const std::size_t joints = std::min({options.joints.size(), kMaxJoints, state.joints});
  const double allowed = options.safety.encoder_stuck;
  for (std::size_t i = 0; i < joints; ++i) {
    if (!has(estimate.fresh, i)) {
      continue;
    }
    const JointState& measured = state.joint[i];
    Joint& joint = joint_[i];
    const std::int64_t step_ns = joint.stamp_ns == 0 ? 0 : measured.stamp_ns - joint.stamp_ns;
    joint.stamp_ns = measured.stamp_ns;
    if (std::abs(measured.position - joint.anchor) > kMovedPart * allowed) {
      joint.anchor = measured.position;
      joint.way = 0.0;
    } else if (std::abs(measured.velocity) > kLeastSpeed) {
      joint.way += measured.velocity *
                   (static_cast<double>(std::clamp<std::int64_t>(step_ns, 0, kLongestStep)) * 1e-9);
    }
    const bool stuck = std::abs(joint.way) > allowed;
    stuck_ = stuck ? stuck_ | bit(i) : stuck_ & ~bit(i);
  }
}

}  // namespace geodesic::control
