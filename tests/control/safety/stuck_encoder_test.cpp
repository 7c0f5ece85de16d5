// A position that stands still while velocity says it moves.
#include "control/safety/stuck_encoder.hpp"

#include <gtest/gtest.h>

#include "tests/control/planar_arm.hpp"

namespace geodesic::control {
namespace {

struct StuckBench {
  ControllerOptions options = testing::planar_options();
  StuckEncoder detector;
  ArmState state;
  Estimate estimate;

  StuckBench() { state.joints = 2; }
  /// @return cycles until joint 0 is found stuck, or -1.
  int run(double velocity, double moving, int cycles) {
    for (int i = 1; i <= cycles; ++i) {
      estimate.fresh = 1U;
      state.joint[0].velocity = velocity;
      state.joint[0].position += moving * 1e-3;
      state.joint[0].stamp_ns += 1'000'000;
      detector.update(options, state, estimate);
      if (has(detector.stuck(), 0)) {
        return i;
      }
    }
    return -1;
  }
};

TEST(StuckEncoder, IsFoundAfterTheConfiguredWay) {
  EXPECT_NEAR(StuckBench{}.run(2.0, 0.0, 1000), 11, 1);  // 0.02 rad at 2 rad/s
  EXPECT_NEAR(StuckBench{}.run(-0.25, 0.0, 1000), 81, 1);
}

TEST(StuckEncoder, MotionAndRestAreNone) {
  EXPECT_EQ(StuckBench{}.run(2.0, 2.0, 5000), -1);
  EXPECT_EQ(StuckBench{}.run(0.15, 0.13, 5000), -1);
  EXPECT_EQ(StuckBench{}.run(0.05, 0.0, 100'000), -1);  // a drive that truncates, at rest
}

TEST(StuckEncoder, EndsOnceItMovesOrAtANewStart) {
  StuckBench bench;
  EXPECT_GT(bench.run(2.0, 0.0, 100), 0);
  bench.state.joint[0].position += 0.1;
  EXPECT_EQ(bench.run(0.0, 0.0, 1), -1);
  EXPECT_GT(bench.run(2.0, 0.0, 100), 0);
  bench.detector.reset();
  EXPECT_EQ(bench.detector.stuck(), 0U);
}

}  // namespace
}  // namespace geodesic::control
