// The observer of external torque: what acts on each joint beside drives, gravity and friction.
// Only the estimate; what counts as a contact is in contact.hpp.
#pragma once

#include <array>
#include <cstdint>

#include "control/estimate.hpp"
#include "control/joint.hpp"
#include "control/mechanism/mechanism.hpp"
#include "control/mechanism/workspace.hpp"
#include "control/options.hpp"
#include "control/safety/supervisor.hpp"

namespace geodesic::control {

/// Which joints move one another: those whose bodies hang on the same body that moves in the world.
/// [i] is the set joint i belongs to. Fixed base. Not real-time.
std::array<BitSet, kMaxJoints> coupled_joints(const Mechanism& mechanism);

/// Residual of generalised momentum (De Luca, Mattone 2005, "Sensorless robot collision detection
/// and hybrid force/motion control", equation 8; De Luca, Albu-Schaeffer, Haddadin, Hirzinger
/// 2006):
///   r = K (p - integral of (tau + C'v - g + r)),    which is    dr/dt = K (tau_external - r).
/// Between two samples this is solved exactly for the mean external torque of the interval,
///   e = (p_k - p_k-1) / T - mean(tau) - (drift_k + drift_k-1) / 2,   drift = C'v - g,
///   r_k = r_k-1 + (1 - exp(-K T)) (e - r_k-1),
/// so that no integral is kept that could run away, and a lost answer just makes T longer.
///
/// Positions are the estimate's at the common instant, velocities as the drives report them: the
/// estimate's low pass would lag behind the torque. The torque that acts between the answers of
/// cycle k-1 and k is what left at cycle k-1, which the answer of cycle k-1 reports as well (or as
/// the drive's current then, half a period older: an error of half a period's change of torque).
/// It is taken as reported, since that holds saturation, the drive's own damping and lost frames;
/// by ContactOptions::measured_torque as commanded, for drives that report none. The friction of
/// the tuning is taken off.
class ExternalTorque {
 public:
  /// Not real-time.
  explicit ExternalTorque(const Mechanism& mechanism);

  /// The model has changed, or the measurements are not continuous: what was measured before is not
  /// compared with what comes. The observed torques stay. Real-time.
  void rebase() noexcept;

  /// One cycle. `sent` left at the beginning of this cycle. Real-time, O(joints).
  void update(const ControllerOptions& options, const Mechanism& mechanism, Workspace& workspace,
              const ArmState& state, const Estimate& estimate, const ArmCommand& sent,
              std::int64_t period_ns) noexcept;

  /// [N·m or N]; 0 until observed.
  const std::array<double, kMaxJoints>& torque() const noexcept { return torque_; }
  /// What the drives made, through the same low pass [N·m or N].
  const std::array<double, kMaxJoints>& drive_torque() const noexcept { return drive_torque_; }
  /// Joints whose external torque is that of this cycle or of a few before.
  BitSet observed() const noexcept { return observed_; }
  /// What acts on the joint from now until the next answer [N·m or N].
  double acting(std::size_t joint) const noexcept { return joint_[joint].acting; }

 private:
  struct Joint {
    double velocity = 0.0;  // as last reported
    double acting = 0.0;
    double impulse = 0.0;  // of the drive, less friction, since the sample below
    double elapsed_s = 0.0;
    double momentum = 0.0;  // at the last sample
    double drift = 0.0;
    bool based = false;  // there is a last sample
  };

  void commit(std::size_t index, double momentum, double drift, double corner_rad_s,
              double period_s) noexcept;

  std::size_t joints_;
  std::array<BitSet, kMaxJoints> coupled_;
  std::int64_t instant_ns_ = 0;
  BitSet observed_ = 0;
  double turn_ = 0.0;    // the last corner * interval,
  double weight_ = 0.0;  // and 1 - exp(-turn_)
  std::array<Joint, kMaxJoints> joint_{};
  std::array<double, kMaxJoints> torque_{};
  std::array<double, kMaxJoints> drive_torque_{};
};

}  // namespace geodesic::control
