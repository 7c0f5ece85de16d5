// Pieces of the check at arm-up: the bound of its spring, the band, the guess of what is wrong. The
// whole of it on a simulated arm is in tests/tools.
#include "control/safety/static_check.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "control/mechanism/gravity.hpp"
#include "control/safety/suspect.hpp"
#include "tests/control/planar_arm.hpp"

namespace geodesic::control {
namespace {

struct CheckBench {
  ControllerOptions options = testing::planar_options();
  Mechanism mechanism = testing::planar_mechanism();
  Workspace workspace{mechanism};
  std::array<BitSet, kMaxJoints> coupled{};
  StaticCheck check{coupled};
  std::array<double, kMaxJoints> position{};
  std::array<double, kMaxJoints> velocity{};
  std::array<double, kMaxJoints> external{};
  std::array<double, kMaxJoints> drive{};
  std::array<double, kMaxJoints> model{};
  std::array<double, kMaxJoints> authority{};

  CheckBench() {
    coupled[0] = coupled[1] = 3U;
    check = StaticCheck(coupled);
    options.joints[0].static_torque_tolerance = 2.0;
    options.joints[1].static_torque_tolerance = 1.0;
    model = {20.0, -6.0};
    check.begin(options, mechanism, workspace, position, 3U);
  }
  void run(int cycles, double a) {
    authority.fill(a);
    for (int i = 0; i < cycles; ++i) {
      check.update(options, {position, velocity, external, drive, model, authority, 3U, 1e-3});
    }
  }
  double spring(std::size_t joint, double away, double a) const {
    return check.spring(options.joints[joint], joint, away, 0.0, model[joint], a);
  }
};

TEST(StaticCheck, TheSpringNeverGivesMoreThanTheRampWithholdsPlusTheTolerance) {
  const CheckBench bench;
  EXPECT_EQ(bench.spring(0, 0.0, 0.3), 0.0);
  EXPECT_GT(bench.spring(0, -1e-3, 0.3), 0.5);
  for (const double a : {0.0, 0.3, 0.9, 1.0}) {
    EXPECT_NEAR(bench.spring(0, -10.0, a), (1.0 - a) * 20.0 + 2.0, 1e-12);
    EXPECT_NEAR(bench.spring(0, 10.0, a), -2.0, 1e-12);
    EXPECT_NEAR(bench.spring(1, 10.0, a), -(1.0 - a) * 6.0 - 1.0, 1e-12);
    EXPECT_NEAR(bench.spring(1, -10.0, a), 1.0, 1e-12);
  }
}

TEST(StaticCheck, WhatCarriesLessThanTheRampWithholdsIsASupport) {
  CheckBench bench;
  for (int i = 0; i < 1000; ++i) {
    const double a = 1e-3 * i;
    bench.external = {(1.0 - a) * 20.0, (1.0 - a) * -6.0};
    bench.run(1, a);
  }
  EXPECT_EQ(bench.check.failed(), 0U);
  EXPECT_EQ(bench.check.state(), StaticCheckState::kPending);  // it has not carried itself yet
  bench.external.fill(0.0);
  bench.run(2000, 1.0);
  EXPECT_EQ(bench.check.state(), StaticCheckState::kPending);  // still where it was
  bench.position = {0.2, 0.3};
  bench.run(400, 1.0);
  EXPECT_EQ(bench.check.state(), StaticCheckState::kPassed);
  EXPECT_EQ(bench.spring(0, -10.0, 1.0), 0.0);  // it has let go
}

TEST(StaticCheck, WhoHangsOnTheSpringWithTheModelsWeightHasPassed) {
  CheckBench bench;
  bench.run(60, 0.5);
  EXPECT_EQ(bench.check.failed(), 0U);
  EXPECT_EQ(bench.check.state(0), StaticCheckState::kPassed);
  EXPECT_EQ(bench.check.state(1), StaticCheckState::kPassed);
}

TEST(StaticCheck, BeyondTheBandIsAFaultAfterItsProof) {
  for (const double excess : {2.5, -2.5}) {
    CheckBench bench;
    bench.external = {excess > 0.0 ? -excess : 10.0 - excess, 0.0};
    bench.run(19, 0.5);
    EXPECT_EQ(bench.check.limp(), 0U);
    bench.run(10, 0.5);
    EXPECT_EQ(bench.check.limp(), 1U);  // the probe
    EXPECT_EQ(bench.check.failed(), 0U);
    bench.run(25, 0.5);
    EXPECT_EQ(bench.check.limp(), 0U);
    EXPECT_EQ(bench.check.failed(), 1U);
    EXPECT_EQ(bench.check.state(0), StaticCheckState::kFailed);
    EXPECT_EQ(bench.check.state(), StaticCheckState::kFailed);
    EXPECT_NEAR(bench.check.excess(0), -bench.external[0], 1e-9);
    EXPECT_EQ(bench.check.reversed(), 0U);
    bench.check.begin(bench.options, bench.mechanism, bench.workspace, bench.position, 3U);
    EXPECT_EQ(bench.check.failed(), 0U);
  }
}

TEST(StaticCheck, ATorqueThatActsTheOtherWayIsKnownByWhatFollowsIt) {
  for (const double acts : {-1.0, 1.0}) {
    CheckBench bench;
    for (int i = 0; i < 70; ++i) {
      bench.drive[0] = has(bench.check.limp(), 0) ? 0.0 : 0.2 * i;  // the spring winds up
      // A load of 6; of what acts the other way the observer takes twice for external.
      bench.external[0] = -6.0 + (acts - 1.0) * bench.drive[0];
      bench.run(1, 0.1);
    }
    EXPECT_EQ(bench.check.failed() & 1U, 1U) << acts;
    EXPECT_EQ(bench.check.reversed(), acts < 0.0 ? 1U : 0U) << acts;
    EXPECT_EQ(bench.check.limp(), bench.check.reversed());
  }
}

TEST(StaticCheck, WithoutToleranceOrRampNothingIsChecked) {
  CheckBench bench;
  bench.options.joints[0].static_torque_tolerance = std::numeric_limits<double>::infinity();
  bench.check.begin(bench.options, bench.mechanism, bench.workspace, bench.position, 3U);
  bench.external = {50.0, 50.0};
  bench.run(100, 0.5);
  EXPECT_EQ(bench.check.failed(), 2U);
  EXPECT_EQ(bench.check.state(0), StaticCheckState::kOff);
  EXPECT_EQ(bench.spring(0, 1.0, 0.5), 0.0);
  bench.options.safety.start_ramp_s = 0.0;
  bench.check.begin(bench.options, bench.mechanism, bench.workspace, bench.position, 3U);
  EXPECT_EQ(bench.check.state(), StaticCheckState::kOff);
}

TEST(Suspect, TellsAPayloadFromWrongMasses) {
  const CheckBench bench;
  Workspace workspace(bench.mechanism);
  const std::array<double, kMaxJoints> q{0.4, -0.9};
  const Eigen::VectorXd& g =
      control::gravity(bench.mechanism, workspace, Eigen::VectorXd(Eigen::Vector2d(q[0], q[1])));
  const double g0 = g[0];
  const double g1 = g[1];
  const int tip = static_cast<int>(bench.mechanism.links().size()) - 1;  // origin of link2
  std::array<double, kMaxJoints> external{-0.3 * g0, -0.3 * g1};
  // At rest: the drives carry what gravity and the load need.
  const auto guess = [&] {
    const std::array<double, kMaxJoints> rest{};
    const std::array<double, kMaxJoints> drive{g0 - external[0], g1 - external[1]};
    return suspect_load(bench.mechanism, workspace, {q, rest, external, drive}, 3U, tip);
  };
  Suspicion found = guess();
  EXPECT_EQ(found.what, Suspect::kWrongMass);
  EXPECT_NEAR(found.size, 0.3, 1e-9);
  // 1.5 kg where the second link begins: 0.5 m from the shoulder, nothing at the elbow.
  external = {-1.5 * 9.81 * 0.5 * std::cos(0.4), 0.0};
  found = guess();
  EXPECT_EQ(found.what, Suspect::kPayload);
  EXPECT_NEAR(found.size, 1.5, 1e-9);
  external = {-10.0, 30.0};  // neither
  EXPECT_EQ(guess().what, Suspect::kNone);
}

}  // namespace
}  // namespace geodesic::control
