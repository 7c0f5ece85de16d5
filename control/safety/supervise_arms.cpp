// One step of all arms.
#include "control/safety/supervise_arms.hpp"

namespace geodesic::control {

RobotSupervisor robot_supervisor(const ControllerOptions& options) {
  const Arms arms = arms_of(options);
  RobotSupervisor robot;
  robot.arms = arms.count;
  for (std::size_t a = 0; a < arms.count; ++a) {
    robot.arm[a] = {arms.joints[a], arms.buses[a], options.start_active, options.safety};
  }
  return robot;
}

RobotDecision supervise_arms(const RobotSupervisor& options, RobotMemory& memory,
                             const Flags& flags, const Requests& requests,
                             std::int64_t now_ns) noexcept {
  RobotDecision robot;
  BitSet faulted = 0;
  for (std::size_t a = 0; a < options.arms; ++a) {
    faulted |= has_own_fault(options.arm[a], memory.arm[a]) ? bit(a) : 0;
  }
  for (std::size_t a = 0; a < options.arms; ++a) {
    const SupervisorOptions& arm = options.arm[a];
    Flags own = flags;
    own.law_requested = has(requests.law, a);
    own.stop_requested = has(requests.stop, a);
    const bool another = arm.safety.other_arm == OtherArm::kStop && (faulted & ~bit(a)) != 0;
    own.present[static_cast<std::size_t>(Fault::kOtherArm)] = another ? bit(0) : 0;
    const SupervisorDecision decision =
        supervise(arm, memory.arm[a], own, now_ns, kMaxEventsPerCycle - robot.events);
    memory.arm[a] = decision.memory;
    robot.restart |= decision.restart_drives ? arm.joints : 0;
    for (std::size_t i = 0; i < decision.events; ++i) {
      FaultEvent& event = robot.event[robot.events++];
      event = decision.event[i];
      event.arm = static_cast<int>(a);
    }
  }
  return robot;
}

SupervisorState overall(const RobotSupervisor& options, const RobotMemory& memory) noexcept {
  SupervisorState state = memory.arm[0].state;
  for (std::size_t a = 1; a < options.arms; ++a) {
    state = overall(state, memory.arm[a].state);
  }
  return state;
}

}  // namespace geodesic::control
