// Finds joints that the control loop itself keeps swinging, and lowers the gains of their arm until
// they stop. What is said of it, and the stop if nothing helps, are the policy table's.
#pragma once

#include <array>

#include "control/options.hpp"
#include "control/safety/supervisor.hpp"

namespace geodesic::control {

/// Detection: zero crossings of the velocity's swing (what is left above lowest_hz / 2) cut it into
/// half cycles. One counts if its peak is vibration_velocity or more, its duration that of
/// lowest_hz to highest_hz, and if the drive's torque, less its slow part, did positive work on
/// the swing: the loop feeds it. A hand that shakes the arm is faster than nothing and fed by
/// nobody; damping takes from it. half_cycles in a row are a limit cycle.
/// Sources: Hägglund 1995, "A control-loop performance monitor" (load between zero crossings,
/// counted); Hannaford, Ryu 2002, "Time-domain passivity control of haptic interfaces" (the sign of
/// the work tells who feeds).
///
/// Reaction: authority over the gains of all joints that move one another (damping, stiffness,
/// friction compensation, walls; never gravity and Coriolis) is halved, within 50 ms, again and
/// again as long as it swings, down to lowest_authority. It does not rise by itself: the cause is a
/// gain that does not fit, and a factor that comes back would bring the vibration back for ever, a
/// limit cycle of its own. recover() is the operator's, by asking for a law.
class Vibration {
 public:
  /// @param coupled  sets of joints that share an authority; as coupled_joints() makes them
  explicit Vibration(const std::array<BitSet, kMaxJoints>& coupled) noexcept;

  /// One cycle. Real-time.
  /// @param velocity  as reported    @param torque  that acted since the last cycle
  /// @param watched   joints whose swings are looked at: measured in this cycle, torque on
  void update(const ControllerOptions& options, const std::array<double, kMaxJoints>& velocity,
              const std::array<double, kMaxJoints>& torque, BitSet watched,
              double period_s) noexcept;

  /// Authority goes back to 1, within a second.
  void recover() noexcept;

  /// 0..1: what the gains of a joint are scaled with now.
  double authority(std::size_t joint) const noexcept { return joint_[joint].authority; }
  /// Where it is going.
  double target(std::size_t joint) const noexcept { return joint_[joint].target; }
  /// Velocity of the last swing that counted [rad/s or m/s].
  double swing(std::size_t joint) const noexcept { return joint_[joint].last_peak; }
  /// Joints found swinging within the last moment.
  BitSet vibrating() const noexcept { return vibrating_; }
  /// Joints that swing though their authority is the lowest there is.
  BitSet persistent() const noexcept { return persistent_; }

 private:
  struct Joint {
    bool started = false;
    double slow_velocity = 0.0;
    double slow_torque = 0.0;
    double before = 0.0;  // swing in the last cycle
    bool positive = false;
    double duration_s = 0.0;
    double peak = 0.0;
    double work = 0.0;  // [J]
    int count = 0;
    double last_peak = 0.0;
    double pause_s = 0.0;  // until it is looked at again
    double target = 1.0;
    double authority = 1.0;
  };

  bool swings(const VibrationOptions& options, double threshold, Joint& joint, double velocity,
              double torque, double weight, double period_s) noexcept;
  void lower(const VibrationOptions& options, std::size_t index) noexcept;

  std::array<BitSet, kMaxJoints> coupled_;
  std::array<Joint, kMaxJoints> joint_{};
  BitSet vibrating_ = 0;
  BitSet persistent_ = 0;
};

}  // namespace geodesic::control
