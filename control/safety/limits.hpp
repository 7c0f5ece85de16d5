// Limits of one joint: where it may be, the walls that keep it there, and the bounds that a torque
// passes last before it leaves. Pure functions; what a broken limit leads to is the supervisor's.
#pragma once

#include "control/options.hpp"

namespace geodesic::control {

/// True if `position` is beyond a hard limit by more than the tolerance; a NaN is outside.
/// Real-time.
bool outside_limits(const JointTuning& joint, double position) noexcept;

/// The limit that is nearest to `position` from where it may be: for messages.
double nearest_limit(const JointTuning& joint, double position) noexcept;

/// Torque of the walls at the soft limits, which begin soft_margin inside the hard ones:
///   stiffness * depth + damping * (velocity into the wall) * min(1, 4 depth / margin).
/// It only ever pushes back inside: the spring is conservative, the damper resists motion into the
/// wall and lets go without pulling, so that no energy comes out of a wall that did not go in. The
/// damping fades in over the first quarter, so that touching a wall at speed is no step in torque.
/// The spring stops growing at the hard limit + tolerance (behind it is a fault). Zero inside, and
/// where the joint has no limit. Real-time.
double wall_torque(const JointTuning& joint, double position, double velocity) noexcept;

/// A torque as it may leave.
struct BoundedTorque {
  double torque = 0.0;     ///< always finite
  bool saturated = false;  ///< more was wanted than torque_limit
  bool finite = true;      ///< false: what was wanted is no number; torque is 0
};

/// Clamp to torque_limit, then to torque_rate_limit from `previous` (what left in the last cycle,
/// finite and within the limit), then the finite check. @param period_s  > 0. Real-time.
BoundedTorque bound_torque(const JointTuning& joint, double wanted, double previous,
                           double period_s) noexcept;

/// The same within another torque limit than the joint's own. Real-time.
BoundedTorque bound_torque(const JointTuning& joint, double limit, double wanted, double previous,
                           double period_s) noexcept;

}  // namespace geodesic::control
