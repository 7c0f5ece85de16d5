// Arithmetic of limits, walls and bounds; the statements about them are in limits.hpp.
#include "control/safety/limits.hpp"

#include <algorithm>
#include <cmath>

namespace geodesic::control {
namespace {

/// How far the wall reaches inside its hard limit; two walls never fill more than half the range.
double wall_margin(const JointTuning& joint) noexcept {
  return std::min(joint.soft_margin, 0.25 * (joint.position_upper - joint.position_lower));
}

/// Push of one wall, >= 0. @param depth  behind its beginning  @param into  velocity into it
double push(const JointTuning& joint, double margin, double depth, double into) noexcept {
  if (!(depth > 0.0)) {
    return 0.0;
  }
  const double spring = joint.wall_stiffness * std::min(depth, margin + joint.position_tolerance);
  const double fade = margin > 0.0 ? std::min(1.0, 4.0 * depth / margin) : 1.0;
  return spring + joint.wall_damping * std::max(0.0, into) * fade;
}

}  // namespace

bool outside_limits(const JointTuning& joint, double position) noexcept {
  return !(position >= joint.position_lower - joint.position_tolerance &&
           position <= joint.position_upper + joint.position_tolerance);
}

double nearest_limit(const JointTuning& joint, double position) noexcept {
  const bool lower = position - joint.position_lower < joint.position_upper - position;
  return lower ? joint.position_lower : joint.position_upper;
}

double wall_torque(const JointTuning& joint, double position, double velocity) noexcept {
  const double margin = wall_margin(joint);
  const double lower = joint.position_lower + margin;
  const double upper = joint.position_upper - margin;
  // Without a limit the depth is minus infinity: no push.
  return push(joint, margin, lower - position, -velocity) -
         push(joint, margin, position - upper, velocity);
}

BoundedTorque bound_torque(const JointTuning& joint, double wanted, double previous,
                           double period_s) noexcept {
  return bound_torque(joint, joint.torque_limit, wanted, previous, period_s);
}

BoundedTorque bound_torque(const JointTuning& joint, double limit, double wanted, double previous,
                           double period_s) noexcept {
  BoundedTorque result;
  if (!std::isfinite(wanted)) {
    result.finite = false;
    return result;
  }
  const double clamped = std::clamp(wanted, -limit, limit);
  result.saturated = clamped != wanted;
  const double step = joint.torque_rate_limit * period_s;
  result.torque = std::clamp(clamped, previous - step, previous + step);
  if (!std::isfinite(result.torque)) {
    result = BoundedTorque{0.0, result.saturated, false};
  }
  return result;
}

}  // namespace geodesic::control
