// Measurements against options: which conditions hold in this cycle, and the figures that prove
// them. What follows from a condition is decided in supervisor.hpp.
#pragma once

#include "control/estimate.hpp"
#include "control/options.hpp"
#include "control/safety/supervisor.hpp"

namespace geodesic::control {

/// What the last stage of the last cycle found, joint by joint.
struct BoundFindings {
  BitSet saturated = 0;
  BitSet not_finite = 0;
  std::array<double, kMaxJoints> wanted{};  ///< before the bounds; may be anything
};

/// Everything the supervisor needs to know of this cycle except the requests. Real-time, O(joints).
Flags assess(const ControllerOptions& options, const ArmState& state, const Estimate& estimate,
             const BoundFindings& bounds) noexcept;

/// Fills in FaultEvent::found and limit. Always finite. Real-time.
void add_evidence(FaultEvent& event, const ControllerOptions& options, const ArmState& state,
                  const Estimate& estimate, const BoundFindings& bounds,
                  const SupervisorMemory& memory) noexcept;

}  // namespace geodesic::control
