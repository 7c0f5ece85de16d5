// The check at arm-up: do the drives measure the torque that the model expects, before it is given
// whole authority? Finds the difference and holds the arm meanwhile; what it looks like is worked
// out in suspect.hpp, what follows from it is the policy table's.
#pragma once

#include <array>
#include <cstdint>

#include "control/mechanism/mechanism.hpp"
#include "control/mechanism/workspace.hpp"
#include "control/options.hpp"
#include "control/safety/supervisor.hpp"

namespace geodesic::control {

/// Of one joint, or of the whole: what is still to be seen counts before what was seen.
enum class StaticCheckState : std::uint8_t {
  kOff,      ///< no tolerance configured, or no ramp to check in
  kPassed,   ///< the joint has carried its own load, and it was the model's
  kPending,  ///< rests where it rested before: a support may still carry it, nothing to see
  kFailed,   ///< see the fault
};
const char* to_string(StaticCheckState state) noexcept;

/// What the check sees in one cycle, of the observer and of the controller's last cycle.
struct StaticCheckInput {
  const std::array<double, kMaxJoints>& position;
  const std::array<double, kMaxJoints>& velocity;
  const std::array<double, kMaxJoints>& external;  ///< observed external torque
  const std::array<double, kMaxJoints>& drive;     ///< drives' torque, likewise low-passed
  const std::array<double, kMaxJoints>& model;     ///< gravity + Coriolis
  const std::array<double, kMaxJoints>& authority;
  BitSet observed;
  double period_s;
};

/// While authority a ramps in, a spring holds each joint at the pose of entry. It may make up for
/// what the ramp still withholds, (1 - a) of the model's torque, and beyond that for
/// static_torque_tolerance to either side; so no joint gets more than its pose needs plus the
/// tolerance. Whatever carries an arm before it is switched on (a stand, a table, a hand) still
/// carries between nothing and that (1 - a) part: the observed external torque outside of this
/// band by more than the tolerance, for kProofSeconds, is a fault. The band does not ask whether
/// the joint rests on something, is let go in the middle of the ramp, or moves.
///
/// A torque of the wrong sign drives the joint away from its spring and the spring it, so that the
/// observed torque soon leaves the band. It is told from a load by a probe: the joint gets no
/// torque for kProbeSeconds, and the observed external torque is compared with that before. A load
/// is what it was, or falls and weighs less, so that the external torque changes by less than the
/// torque T that was taken away; of a T that acts the other way, the observer has taken 2 T for
/// external.
///
/// Passed is who was seen to carry itself: off its support while the ramp withheld more than the
/// tolerance, or at rest elsewhere than at entry. An arm that lies on a support with the model's
/// own torque in its drives shows nothing: pending, which is no fault.
class StaticCheck {
 public:
  static constexpr double kStiffness_rad_s = 37.0;  ///< natural frequency of each joint's spring
  static constexpr double kProofSeconds = 0.02;
  static constexpr double kProbeSeconds = 0.025;

  /// Not real-time.
  explicit StaticCheck(const std::array<BitSet, kMaxJoints>& coupled) noexcept;

  /// Torque begins to flow on the joints `entering`: the pose of entry is where they are.
  /// Real-time, O(joints depth).
  void begin(const ControllerOptions& options, const Mechanism& mechanism, Workspace& workspace,
             const std::array<double, kMaxJoints>& position, BitSet entering) noexcept;

  /// One cycle; input.observed are joints with torque. Real-time.
  void update(const ControllerOptions& options, const StaticCheckInput& input) noexcept;

  /// What the spring adds to a joint's torque, given the model's and the authority. Real-time.
  double spring(const JointTuning& tuning, std::size_t joint, double position, double velocity,
                double model, double authority) const noexcept;

  BitSet failed() const noexcept { return failed_; }
  /// Joints whose torque acts the other way round: any torque would make it worse.
  BitSet reversed() const noexcept { return reversed_; }
  /// Joints that are to get no torque now: reversed, or probed.
  BitSet limp() const noexcept { return reversed_ | probed_; }
  /// External and drives' torques where the last proof ended: what suspect_load() asks for.
  const std::array<double, kMaxJoints>& proven_external() const noexcept {
    return proven_external_;
  }
  const std::array<double, kMaxJoints>& proven_drive() const noexcept { return proven_drive_; }
  /// Measured less modelled torque of a joint where it failed [N·m or N].
  double excess(std::size_t joint) const noexcept { return joint_[joint].excess; }

  StaticCheckState state(std::size_t joint) const noexcept { return joint_[joint].state; }
  /// Of all joints together.
  StaticCheckState state() const noexcept;

 private:
  struct Mean {
    int samples = 0;
    double external = 0.0;
    double drive = 0.0;
    void add(double one_external, double one_drive) noexcept;
  };
  struct Joint {
    StaticCheckState state = StaticCheckState::kOff;
    double reference = 0.0;
    double stiffness = 0.0;
    double damping = 0.0;
    double outside_s = 0.0;  // out of the band for
    double carried_s = 0.0;  // seen carrying itself for
    double excess = 0.0;
    double held = 0.0;  // beyond the tolerance, for the spring, after a fault
    double fade = 0.0;  // of the spring: 1 while the ramp lasts, then falling to 0
    Mean before;        // the probe
    Mean after;
  };

  void prove(const ControllerOptions& options, const StaticCheckInput& input, std::size_t i,
             bool outside) noexcept;
  void fail(const ControllerOptions& options, const StaticCheckInput& input,
            std::size_t i) noexcept;
  void judge(const ControllerOptions& options, const StaticCheckInput& input,
             std::size_t i) noexcept;

  std::array<BitSet, kMaxJoints> coupled_;
  std::array<Joint, kMaxJoints> joint_{};
  BitSet failed_ = 0;
  BitSet reversed_ = 0;
  BitSet probed_ = 0;
  std::array<double, kMaxJoints> smooth_external_{};
  std::array<double, kMaxJoints> smooth_drive_{};
  std::array<double, kMaxJoints> proven_external_{};
  std::array<double, kMaxJoints> proven_drive_{};
};

}  // namespace geodesic::control
