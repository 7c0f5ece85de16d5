// Explores every reachable state of a supervisor under every flag combination, breadth first, and
// checks what must hold on each transition against counters of its own.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "control/safety/supervisor.hpp"

namespace geodesic::control::testing {

/// What is abstracted, and why that loses nothing:
/// - Time goes in steps of half a second; every option is a multiple of it. supervise() only ever
///   compares differences of time with options, so that shorter cycles pass the same comparisons
///   in the same order, only more often.
/// - Counters and ages stop at the largest figure they are compared with.
/// - Of the latched faults, the worst action and the set of failed drives are kept, each by one
///   fault that stands for all: supervise() reads latched faults by worst_action() and
///   failed_drives() alone (what is told of them does not feed back). abstraction_holds() checks
///   that on random walks through the whole memory.
/// - Joints: one with every flag there is; two with the letters that differ in some predicate.
///   supervise() reads sets of joints only by "any" and "all", so that a third joint adds nothing
///   that two do not have.
inline constexpr double kStepS = 0.5;
inline constexpr std::int64_t kStepNs = 500'000'000;

using Supervise = SupervisorDecision (*)(const SupervisorOptions&, const SupervisorMemory&,
                                         const Flags&, std::int64_t now_ns);

struct Exploration {
  std::size_t states = 0;
  std::size_t transitions = 0;
  std::vector<std::string> violations;  ///< at most a few; empty: all holds
};

SupervisorOptions explored_options(std::size_t joints);

/// @param joints  1: every flag combination; 2: letters
/// @param every   only every so many of the flag combinations: enough to find what is wrong
Exploration explore(Supervise supervise, std::size_t joints, std::size_t every = 1);

/// Empty, or where the abstract step differs from the whole one.
std::string abstraction_holds(unsigned seed, int steps);

}  // namespace geodesic::control::testing
