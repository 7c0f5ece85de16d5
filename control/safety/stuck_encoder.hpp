// Finds an encoder that stands still while its drive says that the joint moves. Jumps are found by
// the estimator, and what follows from either is the policy table's.
#pragma once

#include <array>

#include "control/estimate.hpp"
#include "control/joint.hpp"
#include "control/options.hpp"
#include "control/safety/supervisor.hpp"

namespace geodesic::control {

/// Adds up the way that the drive's velocity says since the position last changed. Velocities below
/// 0.1 rad/s do not count: a drive's truncation may report a standing joint as creeping.
///
/// A position and a velocity that freeze together, as those of a drive with one encoder may, cannot
/// be told from a joint at rest: torque that balances the frozen pose is consistent with it. Such a
/// drive loses its commutation too and reports an error of its own.
class StuckEncoder {
 public:
  /// One cycle. Real-time.
  void update(const ControllerOptions& options, const ArmState& state,
              const Estimate& estimate) noexcept;
  void reset() noexcept { *this = StuckEncoder{}; }

  BitSet stuck() const noexcept { return stuck_; }
  /// The way that velocity says since the position last changed [rad or m].
  double way(std::size_t joint) const noexcept { return joint_[joint].way; }

 private:
  struct Joint {
    double anchor = 0.0;  // position
    double way = 0.0;
    std::int64_t stamp_ns = 0;
  };
  BitSet stuck_ = 0;
  std::array<Joint, kMaxJoints> joint_{};
};

}  // namespace geodesic::control
