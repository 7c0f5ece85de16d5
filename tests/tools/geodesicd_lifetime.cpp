// When a run ends and how; and when the real-time thread counts as standing still.
#include "tools/geodesicd/lifetime.hpp"

#include <gtest/gtest.h>

#include "tools/geodesicd/standstill.hpp"

namespace geodesic::tools {
namespace {

using control::SupervisorState;
using std::chrono::milliseconds;

constexpr std::int64_t kMs = 1'000'000;

/// Steps a Lifetime by milliseconds.
struct SteppedRun {
  explicit SteppedRun(const LifetimeOptions& options = {}) : lifetime(options) {}

  Course step(SupervisorState state, bool enabled, int ms = 1) {
    Course course = Course::kOnward;
    for (int i = 0; i < ms; ++i) {
      course = lifetime.update(state, enabled, now_ns += kMs);
    }
    return course;
  }

  Lifetime lifetime;
  std::int64_t now_ns = 1'000 * kMs;
};

TEST(Lifetime, GoesOnUntilAsked) {
  SteppedRun run;
  EXPECT_EQ(run.step(SupervisorState::kActive, true, 100'000), Course::kOnward);
  EXPECT_EQ(run.step(SupervisorState::kFault, false, 100'000), Course::kOnward);
  EXPECT_FALSE(run.lifetime.ending());
}

TEST(Lifetime, EndsByAControlledStop) {
  SteppedRun run;
  run.step(SupervisorState::kActive, true);
  run.lifetime.ask_exit();
  EXPECT_EQ(run.step(SupervisorState::kActive, true), Course::kAskStop);
  EXPECT_TRUE(run.lifetime.ending());
  EXPECT_EQ(run.step(SupervisorState::kStopping, true, 500), Course::kOnward);
  EXPECT_EQ(run.step(SupervisorState::kLowering, true, 500), Course::kOnward);
  EXPECT_EQ(run.step(SupervisorState::kOff, true), Course::kOnward) << "drives are still enabled";
  EXPECT_EQ(run.step(SupervisorState::kOff, false), Course::kOver);
  EXPECT_FALSE(run.lifetime.forced());
}

TEST(Lifetime, AsksAgainIfTheStopWasOverrun) {
  SteppedRun run;
  run.lifetime.ask_exit();
  EXPECT_EQ(run.step(SupervisorState::kActive, true), Course::kAskStop);
  EXPECT_EQ(run.step(SupervisorState::kActive, true), Course::kAskStop);
}

TEST(Lifetime, DoesNotWaitForeverForADriveThatIsGone) {
  SteppedRun run;
  run.lifetime.ask_exit();
  EXPECT_EQ(run.step(SupervisorState::kFault, true, 200), Course::kOnward);
  EXPECT_EQ(run.step(SupervisorState::kFault, true, 2), Course::kOver);
}

TEST(Lifetime, TakesTorqueOffIfTheStopDoesNotEnd) {
  SteppedRun run;
  run.lifetime.ask_exit();
  const int bound_ms = static_cast<int>(run.lifetime.stop_bound_ns() / kMs);
  EXPECT_EQ(run.step(SupervisorState::kStopping, true, bound_ms), Course::kOnward);
  EXPECT_EQ(run.step(SupervisorState::kStopping, true, 2), Course::kTorqueOff);
  EXPECT_EQ(run.step(SupervisorState::kStopping, false), Course::kOver);
  EXPECT_TRUE(run.lifetime.forced());
}

TEST(Lifetime, TakesTorqueOffIfToldSo) {
  SteppedRun run;
  run.step(SupervisorState::kActive, true);
  run.lifetime.ask_torque_off();
  EXPECT_EQ(run.step(SupervisorState::kActive, true), Course::kTorqueOff);
  EXPECT_EQ(run.step(SupervisorState::kActive, false), Course::kOver);
  EXPECT_TRUE(run.lifetime.forced());
}

TEST(Lifetime, CountsItsSecondsFromActive) {
  LifetimeOptions options;
  options.run_ns = 100 * kMs;
  SteppedRun run(options);
  EXPECT_EQ(run.step(SupervisorState::kConnecting, false, 500), Course::kOnward);
  EXPECT_EQ(run.step(SupervisorState::kActive, true, 100), Course::kOnward);
  EXPECT_EQ(run.step(SupervisorState::kActive, true, 1), Course::kAskStop);
}

TEST(Lifetime, EndsOnAFaultIfItIsToldTo) {
  LifetimeOptions options;
  options.exit_on_fault = true;
  SteppedRun run(options);
  EXPECT_EQ(run.step(SupervisorState::kLowering, true), Course::kOnward);
  run.step(SupervisorState::kFault, false);
  EXPECT_EQ(run.step(SupervisorState::kFault, false), Course::kOver);
}

TEST(Standstill, IsNoticedAfterTheLimit) {
  Standstill standstill(milliseconds(1000));
  for (int i = 0; i < 1000; ++i) {
    EXPECT_FALSE(standstill.update(0, milliseconds(10))) << "nothing has begun yet";
  }
  EXPECT_FALSE(standstill.update(7, milliseconds(10)));
  for (int i = 0; i < 100; ++i) {
    EXPECT_FALSE(standstill.update(7, milliseconds(10)));
  }
  EXPECT_TRUE(standstill.update(7, milliseconds(10)));
  EXPECT_FALSE(standstill.update(8, milliseconds(10)));
}

TEST(Standstill, APauseOfTheWholeProcessProvesNothing) {
  Standstill standstill(milliseconds(1000));
  standstill.update(7, milliseconds(10));
  EXPECT_FALSE(standstill.update(7, milliseconds(3'600'000)));
}

}  // namespace
}  // namespace geodesic::tools
