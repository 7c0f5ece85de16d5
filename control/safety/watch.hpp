// All that watches the moving arm beside its limits: contact, vibration, the static check at
// arm-up, stuck encoders; one object for the controller to ask. What follows is policy.cpp's.
#pragma once

#include "control/safety/contact.hpp"
#include "control/safety/external_torque.hpp"
#include "control/safety/static_check.hpp"
#include "control/safety/stuck_encoder.hpp"
#include "control/safety/suspect.hpp"
#include "control/safety/vibration.hpp"

namespace geodesic::control {

/// One cycle as the watch sees it, before the supervisor has decided anything.
struct WatchInput {
  const ArmState& state;
  const Estimate& estimate;
  const ArmCommand& sent;                           ///< left at the beginning of this cycle
  const std::array<double, kMaxJoints>& model;      ///< gravity + Coriolis, of the last cycle
  const std::array<double, kMaxJoints>& authority;  ///< of each joint, as of the last cycle
  BitSet active;                                    ///< joints a law runs on
  BitSet torque;                                    ///< joints torque flows on
  std::int64_t period_ns;
};

/// Remembers from cycle to cycle; options are handed in each time, so that they may change.
class Watch {
 public:
  /// Not real-time.
  explicit Watch(const Mechanism& mechanism);

  /// One cycle. Real-time, O(joints).
  void observe(const ControllerOptions& options, const Mechanism& mechanism, Workspace& workspace,
               const WatchInput& input) noexcept;

  /// The model has changed: its momentum is not comparable with the last cycle's. Real-time.
  void rebase() noexcept { external_.rebase(); }
  /// The drives start anew: positions may have jumped. Real-time.
  void restart() noexcept;
  /// An operator has asked for a law: gains that a vibration has lowered come back. Real-time.
  void recover() noexcept { vibration_.recover(); }

  /// Sets this cycle's conditions. Real-time.
  void add_to(Flags& flags) const noexcept;
  /// Fills in the evidence of a fault that add_to() has raised; nothing for others. Real-time.
  void add_evidence(FaultEvent& event, const ControllerOptions& options) const noexcept;

  const std::array<double, kMaxJoints>& external_torque() const noexcept {
    return external_.torque();
  }
  BitSet touched() const noexcept { return contact_.touched(); }
  /// 0..1, for all that feeds back: damping, stiffness, friction compensation, walls.
  double gain(std::size_t joint) const noexcept { return vibration_.authority(joint); }
  const StaticCheck& static_check() const noexcept { return static_; }

 private:
  void check_statics(const ControllerOptions& options, const Mechanism& mechanism,
                     Workspace& workspace, const WatchInput& input, double period_s) noexcept;

  std::array<BitSet, kMaxJoints> coupled_;
  ExternalTorque external_;
  ContactDetector contact_;
  Vibration vibration_;
  StaticCheck static_;
  StuckEncoder encoder_;
  std::array<double, kMaxJoints> acted_{};  // torque since the last cycle
  std::array<Suspicion, kMaxJoints> suspicion_{};
  BitSet active_before_ = 0;
};

}  // namespace geodesic::control
