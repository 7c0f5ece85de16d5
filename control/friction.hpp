// Compensation of joint friction as a function of velocity alone. Not a friction model for
// simulation: at rest it does nothing, on purpose.
#pragma once

#include <cmath>

namespace geodesic::control {

/// One joint's friction as configured; [N·m, rad/s] revolute, [N, m/s] prismatic.
struct Friction {
  double coulomb = 0.0;   ///< >= 0
  double viscous = 0.0;   ///< >= 0, per velocity
  double velocity = 0.1;  ///< > 0: at this velocity half is compensated
};

/// Torque that makes up for friction at `velocity`:
///   w(x) (coulomb sign(v) + viscous v),   x = v / friction.velocity,   w(x) = x^2 / (1 + x^2).
///
/// Why not the usual coulomb * tanh(x): that has slope coulomb / friction.velocity at rest, which
/// is a negative damping, largest exactly where velocity is encoder noise and the true friction is
/// uncertain; an arm with less friction than configured would set itself in motion. Here torque
/// and slope are both zero at rest, so that small motions are neither fed nor damped, and the power
/// given back grows only with |v|^3. Noise of mean size n in the velocity leaves a negative damping
/// of 2 coulomb n / friction.velocity^2, against coulomb / friction.velocity of the tanh: choose
/// friction.velocity well above the noise. Once continuously differentiable, odd, and never more
/// than coulomb + viscous |v|: with friction configured no larger than the true one, friction and
/// compensation together never feed energy at any velocity. Finite for every finite velocity as
/// long as viscous * velocity is. Real-time.
inline double compensate(const Friction& friction, double velocity) noexcept {
  const double x = std::abs(velocity) / friction.velocity;
  // Two forms of the same weight, each exact where it is used; x^2 may overflow in the second.
  const double weight = x <= 1.0 ? x * x / (1.0 + x * x) : 1.0 / (1.0 + 1.0 / (x * x));
  return weight * (std::copysign(friction.coulomb, velocity) + friction.viscous * velocity);
}

}  // namespace geodesic::control
