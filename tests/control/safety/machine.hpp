// The supervisor with time and flags in the test's hand, a millisecond a step.
#pragma once

#include "control/safety/supervisor.hpp"

namespace geodesic::control::testing {

inline constexpr std::size_t kJoints = 3;
inline constexpr BitSet kAll = first(kJoints);

struct Machine {
  SupervisorOptions options;
  SupervisorMemory memory;
  SupervisorDecision decision;
  Flags flags;
  std::int64_t now_ns = 5'000'000'000;

  Machine() {
    options.joints = kAll;
    flags.fresh = kAll;
  }

  SupervisorState state() const { return memory.state; }

  /// Drives that report what the state asks of them.
  void obey() {
    const bool enable = state() == SupervisorState::kEnabling || makes_torque(state());
    flags.enabled = enable ? kAll & ~flags.error : 0;
    flags.disabled = enable ? 0 : kAll & ~flags.error & ~flags.refused;
  }

  SupervisorState step() {
    now_ns += 1'000'000;
    decision = supervise(options, memory, flags, now_ns);
    memory = decision.memory;
    flags.law_requested = false;
    flags.stop_requested = false;
    return state();
  }

  SupervisorState run(int steps) {
    for (int i = 0; i < steps; ++i) {
      obey();
      step();
    }
    return state();
  }

  /// @return steps it took to reach `wanted`, or -1.
  int run_until(SupervisorState wanted, int limit = 20'000) {
    for (int i = 0; i <= limit; ++i) {
      if (state() == wanted) {
        return i;
      }
      obey();
      step();
    }
    return -1;
  }

  void set(Fault fault, BitSet subjects) {
    flags.present[static_cast<std::size_t>(fault)] = subjects;
  }

  int told(Fault fault) const {
    int count = 0;
    for (std::size_t i = 0; i < decision.events; ++i) {
      count += decision.event[i].fault == fault ? 1 : 0;
    }
    return count;
  }
};

}  // namespace geodesic::control::testing
