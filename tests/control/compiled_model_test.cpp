// The controller takes compiled functions in place of the algorithms, for as long as the setup that
// holds them counts.
#include <gtest/gtest.h>

#include "control/controller.hpp"
#include "control/mechanism/dynamics.hpp"
#include "tests/control/planar_arm.hpp"

namespace geodesic::control {
namespace {

using Tuned = Setup;  // gtest keeps the name for itself

constexpr double kTorque = 1.25;

/// Unlike any arm's, so that it shows who computed.
void constant_bias(const double* /*q*/, const double* /*v*/, double* out) {
  out[0] = kTorque;
  out[1] = -kTorque;
}

TEST(CompiledModel, IsTakenAsLongAsItsSetupCounts) {
  const CompiledModel compiled{constant_bias, nullptr, nullptr};
  Controller controller(testing::planar_mechanism(), testing::planar_options(), &compiled);
  testing::ObedientArm arm;
  ArmCommand command;
  const auto cycle = [&] {
    arm.obey(command);
    command = controller.update(arm.state, testing::kPeriod);
  };
  for (int i = 0; i < 3000; ++i) cycle();
  EXPECT_EQ(controller.report().model_torque[0], kTorque);
  EXPECT_EQ(controller.report().model_torque[1], -kTorque);

  const Tuned other{testing::planar_options(), testing::planar_mechanism()};
  ASSERT_EQ(other.compiled, nullptr);
  ASSERT_EQ(controller.exchange(&other), nullptr);
  cycle();
  Workspace workspace(other.mechanism);
  const Eigen::Vector2d q(arm.state.joint[0].position, arm.state.joint[1].position);
  const Eigen::VectorXd& expected = bias(other.mechanism, workspace, q, Eigen::Vector2d::Zero());
  EXPECT_NEAR(controller.report().model_torque[0], expected[0], 1e-12);
  EXPECT_NEAR(controller.report().model_torque[1], expected[1], 1e-12);

  ASSERT_EQ(controller.exchange(nullptr), &other);
  cycle();
  EXPECT_EQ(controller.report().model_torque[0], kTorque);
}

}  // namespace
}  // namespace geodesic::control
