// The supervisor explored whole, and wrong supervisors that the same explorer must catch.
#include "tests/control/safety/explorer.hpp"

#include <gtest/gtest.h>

#include <cstdio>

namespace geodesic::control {
namespace {

using testing::Exploration;
using testing::explore;
using enum SupervisorState;

SupervisorDecision right(const SupervisorOptions& options, const SupervisorMemory& memory,
                         const Flags& flags, std::int64_t now_ns) {
  return supervise(options, memory, flags, now_ns);
}

std::string text(const Exploration& found) {
  std::string all;
  for (const std::string& violation : found.violations) {
    all += violation + "\n";
  }
  return all;
}

TEST(Explorer, EveryReachableStateKeepsItsPromises) {
  for (const std::size_t joints : {std::size_t{1}, std::size_t{2}}) {
    const Exploration found = explore(right, joints);
    std::printf("%zu joint(s): %zu states, %zu transitions\n", joints, found.states,
                found.transitions);
    EXPECT_TRUE(found.violations.empty()) << text(found);
    EXPECT_GT(found.states, 100u);
  }
}

TEST(Explorer, TheAbstractionLosesNothing) {
  for (unsigned seed = 1; seed <= 4; ++seed) {
    EXPECT_EQ(testing::abstraction_holds(seed, 20'000), "") << seed;
  }
}

/// A supervisor that is wrong in one way.
struct Wrong {
  const char* how;
  testing::Supervise supervise;
};

template <class Mask>
SupervisorDecision masked(const SupervisorOptions& options, const SupervisorMemory& memory,
                          Flags flags, std::int64_t now_ns, Mask mask) {
  mask(flags);
  return supervise(options, memory, flags, now_ns);
}

#define GEODESIC_MASKED(change)                                                               \
  [](const SupervisorOptions& options, const SupervisorMemory& memory, const Flags& flags_in, \
     std::int64_t now_ns) {                                                                   \
    return masked(options, memory, flags_in, now_ns, [](Flags& flags) { change; });           \
  }
#define GEODESIC_CHANGED(change)                                                           \
  [](const SupervisorOptions& options, const SupervisorMemory& memory, const Flags& flags, \
     std::int64_t now_ns) {                                                                \
    SupervisorDecision decision = supervise(options, memory, flags, now_ns);               \
    SupervisorMemory& next = decision.memory;                                              \
    change;                                                                                \
    return decision;                                                                       \
  }

TEST(Explorer, CatchesEveryWrongSupervisor) {
  const Wrong kWrong[] = {
      {"believes every joint fresh", GEODESIC_MASKED(flags.fresh = ~BitSet{0})},
      {"sees no limit at the start", GEODESIC_MASKED(flags.outside = 0)},
      {"sees no motion", GEODESIC_MASKED(flags.moving = 0)},
      {"ignores stops", GEODESIC_MASKED(flags.stop_requested = false)},
      {"starts by itself", GEODESIC_MASKED(flags.law_requested = true)},
      {"sees no condition", GEODESIC_MASKED(flags.present.fill(0))},
      {"sees no encoder jump", GEODESIC_MASKED(flags.present[9] = 0)},
      {"sees no drive error", GEODESIC_MASKED(flags.error = 0)},
      {"sees no refusal", GEODESIC_MASKED(flags.refused = 0)},
      {"sees no overrun", GEODESIC_MASKED(flags.overran = false)},
      {"believes every drive enabled", GEODESIC_MASKED(flags.enabled = ~BitSet{0})},
      {"believes every drive configured", GEODESIC_MASKED(flags.disabled = ~BitSet{0})},
      {"forgets faults", GEODESIC_CHANGED(next.latched.fill(0))},
      {"keeps torque at the end", GEODESIC_CHANGED(if (next.state == kFault) next.authority = 1.0)},
      {"raises authority in a stop",
       GEODESIC_CHANGED(if (next.state == kStopping) next.authority = 1.0)},
      {"ramps at once", GEODESIC_CHANGED(if (next.state == kActive) next.authority = 1.0)},
      {"trusts encoders again", GEODESIC_CHANGED(if (next.drives_only) {
         next.drives_only = false;
         next.authority = next.lower_from;
       })},
      {"never ends a stop", GEODESIC_CHANGED(if (next.state == kStopping) next.since_ns = now_ns)},
      {"never ends lowering",
       GEODESIC_CHANGED(if (next.state == kLowering) next.since_ns = now_ns)},
      {"waits for ever at connecting",
       GEODESIC_CHANGED(if (next.state == kConnecting) next.since_ns = now_ns)},
      {"skips ready", GEODESIC_CHANGED(if (next.state == kReady) next.state = kEnabling)},
      {"skips enabling", GEODESIC_CHANGED(if (next.state == kEnabling) next.state = kActive)},
      {"skips lowering", GEODESIC_CHANGED(if (next.state == kLowering) next.state = kFault)},
      {"calls a fault off", GEODESIC_CHANGED(if (next.state == kFault) next.state = kOff)},
      {"never leaves fault", GEODESIC_CHANGED(if (memory.state == kFault) { next = memory; })},
      {"forgets silence", GEODESIC_CHANGED(next.silent.fill(0))},
      {"forgets failed drives", GEODESIC_CHANGED(next.latched[1] = 0)},
  };
  for (const Wrong& wrong : kWrong) {
    EXPECT_FALSE(explore(wrong.supervise, 1, 7).violations.empty()) << wrong.how;
  }
}

#undef GEODESIC_MASKED
#undef GEODESIC_CHANGED

}  // namespace
}  // namespace geodesic::control
