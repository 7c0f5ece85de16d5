// The supervisors of all arms of a robot, one step: each its own, but for what one's fault means to
// the others. A pure function like supervise().
#pragma once

#include "control/arms.hpp"
#include "control/safety/supervisor.hpp"

namespace geodesic::control {

/// What operators ask of which arms in this cycle.
struct Requests {
  BitSet law = 0;   ///< of arms
  BitSet stop = 0;  ///< of arms; wins
};

struct RobotSupervisor {
  std::size_t arms = 1;
  std::array<SupervisorOptions, kMaxArms> arm{};
};

/// Not real-time (it reads the options' vectors).
RobotSupervisor robot_supervisor(const ControllerOptions& options);

struct RobotMemory {
  std::array<SupervisorMemory, kMaxArms> arm{};
};

struct RobotDecision {
  BitSet restart = 0;  ///< joints whose drives' dialogues begin anew
  std::array<FaultEvent, kMaxEventsPerCycle> event{};
  std::size_t events = 0;
};

/// One step of every arm's supervise(). Flags::law_requested and stop_requested are taken from
/// `requests`. An arm has the fault kOtherArm if another had a fault of its own after the last
/// cycle and SafetyOptions::other_arm is kStop: one cycle later, whatever the arms' order.
/// Real-time.
RobotDecision supervise_arms(const RobotSupervisor& options, RobotMemory& memory,
                             const Flags& flags, const Requests& requests,
                             std::int64_t now_ns) noexcept;

/// overall() of all arms. Real-time.
SupervisorState overall(const RobotSupervisor& options, const RobotMemory& memory) noexcept;

}  // namespace geodesic::control
