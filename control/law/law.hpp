// The laws, one joint at a time: tuning and state in, torque out. Pure functions; ramps, walls and
// bounds come after, in safety/ and in the controller.
#pragma once

#include "control/friction.hpp"
#include "control/options.hpp"

namespace geodesic::control {

/// One joint as a law sees it. [rad, N·m] revolute; [m, N] prismatic.
struct LawInput {
  double position = 0.0;
  double velocity = 0.0;
  double model_torque = 0.0;  ///< gravity + the chosen share of Coriolis at the arm's (q, v)
  double reference = 0.0;     ///< position at entry into the law
};

/// Gravity + Coriolis + friction compensation - damping. With the model and no damping, M(q) a is
/// what others apply: left alone, the joints stay at rest, or coast at constant joint velocity
/// (without Coriolis compensation: along a geodesic).
inline double float_torque(const JointTuning& joint, const LawInput& input) noexcept {
  const Friction friction{joint.coulomb_friction, joint.viscous_friction, joint.friction_velocity};
  return input.model_torque + compensate(friction, input.velocity) - joint.damping * input.velocity;
}

/// A spring and a damper about the pose at entry, on top of gravity + Coriolis. Friction is not
/// compensated: it helps to hold, and compensating it around a spring makes limit cycles.
inline double hold_torque(const JointTuning& joint, const LawInput& input) noexcept {
  return input.model_torque + joint.hold_stiffness * (input.reference - input.position) -
         joint.hold_damping * input.velocity;
}

/// Gravity + Coriolis and the stop damping: any motion dies out where it is. Friction is not
/// compensated: it brakes. Also what a controlled stop does.
inline double damp_torque(const JointTuning& joint, const LawInput& input) noexcept {
  return input.model_torque - joint.stop_damping * input.velocity;
}

/// The torque of `law` for one joint. Real-time.
inline double law_torque(LawKind law, const JointTuning& joint, const LawInput& input) noexcept {
  switch (law) {
    case LawKind::kFloat:
      return float_torque(joint, input);
    case LawKind::kHold:
      return hold_torque(joint, input);
    case LawKind::kDamp:
      return damp_torque(joint, input);
    case LawKind::kZero:
      break;
  }
  return 0.0;
}

}  // namespace geodesic::control
