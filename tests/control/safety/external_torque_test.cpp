// The observer against a planar arm in closed form: textbook equations, integrated here, with the
// timing of drives and frames.
#include "control/safety/external_torque.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "control/safety/contact.hpp"
#include "tests/control/planar_arm.hpp"

namespace geodesic::control {
namespace {

using testing::kPeriod;

/// Two equal uniform links of planar_arm.hpp (Siciliano et al. 2009, section 7.3.2).
struct PlanarTruth {
  static constexpr double kMass = 2.0, kLength = 0.5, kCom = 0.25, kInertia = 0.042;
  double gravity = 9.81;
  Eigen::Vector2d q{0.4, -0.7};
  Eigen::Vector2d v{0.0, 0.0};

  Eigen::Matrix2d mass() const {
    const double cross = kMass * kLength * kCom * std::cos(q[1]);
    const double tip = kInertia + kMass * kCom * kCom;
    Eigen::Matrix2d m;
    m(0, 0) = kInertia + kMass * kCom * kCom + kMass * kLength * kLength + tip + 2.0 * cross;
    m(0, 1) = m(1, 0) = tip + cross;
    m(1, 1) = tip;
    return m;
  }
  Eigen::Vector2d bias() const {
    const double h = -kMass * kLength * kCom * std::sin(q[1]);
    const double lower = kMass * kCom * gravity * std::cos(q[0] + q[1]);
    return {h * (2.0 * v[0] * v[1] + v[1] * v[1]) +
                (kMass * kCom + kMass * kLength) * gravity * std::cos(q[0]) + lower,
            -h * v[0] * v[0] + lower};
  }
  void step(const Eigen::Vector2d& torque, double dt) {
    v += dt * mass().inverse() * (torque - bias());
    q += dt * v;
  }
};

struct ObserverBench {
  PlanarTruth truth;
  ControllerOptions options = testing::planar_options();
  Mechanism mechanism = testing::planar_mechanism();
  Workspace workspace{mechanism};
  Estimator estimator{options};
  ExternalTorque observer{mechanism};
  ArmState state;
  ArmCommand sent;
  Eigen::Vector2d external{0.0, 0.0};
  std::function<Eigen::Vector2d(const PlanarTruth&)> law =
      [](const PlanarTruth& at) -> Eigen::Vector2d { return at.bias(); };

  ObserverBench() {
    for (JointTuning& joint : options.joints) {
      joint.coulomb_friction = 0.0;
      joint.viscous_friction = 0.0;
    }
    state.joints = 2;
    sent.joints = 2;
    state.tick_ns = 1'000'000'000;
  }

  /// Frames out, answers in, a period of motion; joints in `lost` do not answer.
  void cycle(BitSet lost = 0) {
    state.tick_ns += kPeriod;
    const Eigen::Vector2d torque = law(truth);
    for (std::size_t i = 0; i < 2; ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      sent.joint[i].mode = DriveMode::kEnable;
      sent.joint[i].torque = torque[k];
      JointState& joint = state.joint[i];
      joint.fresh = !has(lost, i);
      if (joint.fresh) {
        joint.position = truth.q[k];
        joint.velocity = truth.v[k];
        joint.torque = torque[k];
        joint.stamp_ns = state.tick_ns;
        joint.condition = DriveCondition::kEnabled;
      }
    }
    observer.update(options, mechanism, workspace, state, estimator.update(state, kPeriod), sent,
                    kPeriod);
    for (int i = 0; i < 100; ++i) {
      truth.step(torque + external, 1e-5);
    }
  }
  void run(int cycles) {
    for (int i = 0; i < cycles; ++i) {
      cycle();
    }
  }
};

Eigen::Vector2d swinging(const PlanarTruth& at) {
  return at.bias() + Eigen::Vector2d(3.0 * (0.3 - at.q[0]), 2.0 * (0.5 - at.q[1]));
}

TEST(ExternalTorque, IsZeroForTheExactModelInFreeMotion) {
  ObserverBench bench;
  bench.law = swinging;
  double largest = 0.0;
  for (int i = 0; i < 3000; ++i) {
    bench.cycle();
    largest = std::max(
        {largest, std::abs(bench.observer.torque()[0]), std::abs(bench.observer.torque()[1])});
  }
  EXPECT_EQ(bench.observer.observed(), 3U);
  EXPECT_GT(bench.truth.v.norm() + (bench.truth.q - Eigen::Vector2d(0.4, -0.7)).norm(), 0.1);
  // What is left is the change of torque and drift within a period.
  EXPECT_LT(largest, 0.02);
}

TEST(ExternalTorque, FallingFreelyIsNoExternalTorque) {
  ObserverBench bench;
  bench.law = [](const PlanarTruth&) { return Eigen::Vector2d(0.0, 0.0); };
  bench.run(300);
  EXPECT_GT(bench.truth.v.norm(), 2.0);
  EXPECT_NEAR(bench.observer.torque()[0], 0.0, 0.02);
  EXPECT_NEAR(bench.observer.torque()[1], 0.0, 0.02);
}

TEST(ExternalTorque, EqualsTheTrueOneAtSteadyStateAtRestAndMoving) {
  for (const bool measured : {true, false}) {
    ObserverBench bench;
    bench.options.contact.measured_torque = measured;
    bench.external = {2.5, -1.2};
    bench.law = [](const PlanarTruth& at) -> Eigen::Vector2d {  // a hold that the push displaces
      return Eigen::Vector2d(at.bias() + 60.0 * (Eigen::Vector2d(0.4, -0.7) - at.q) - 8.0 * at.v);
    };
    for (int i = 0; i < 2000; ++i) {
      bench.cycle();
      if (i > 40) {
        ASSERT_NEAR(bench.observer.torque()[0], 2.5, 0.03) << i;
        ASSERT_NEAR(bench.observer.torque()[1], -1.2, 0.03) << i;
      }
    }
  }
}

TEST(ExternalTorque, DoesNotDependOnGravity) {
  std::array<double, 2> seen{};
  for (std::size_t k = 0; k < 2; ++k) {
    ObserverBench bench;
    const double gravity = k == 0 ? 9.81 : 0.0;
    bench.truth.gravity = gravity;
    bench.mechanism = Mechanism(testing::planar_tree(), Eigen::Vector3d(0.0, -gravity, 0.0));
    bench.external = {1.0, 0.5};
    bench.run(60);
    seen[k] = bench.observer.torque()[0];
  }
  EXPECT_NEAR(seen[0], seen[1], 1e-3);
}

TEST(ExternalTorque, AStepArrivesAsTheExactFirstOrderDecay) {
  ObserverBench bench;
  bench.run(20);
  bench.external = {4.0, 0.0};
  for (int i = 0; i < 20; ++i) {
    bench.cycle();
    // The step began with the period before this answer's.
    const double expected = 4.0 * (1.0 - std::exp(-2.0 * M_PI * 50.0 * 1e-3 * i));
    ASSERT_NEAR(bench.observer.torque()[0], expected, 0.02) << i;
  }
}

TEST(ExternalTorque, LostAnswersOnlyDelayIt) {
  ObserverBench bench;
  bench.law = swinging;
  bench.external = {1.5, 0.7};
  for (int i = 0; i < 2000; ++i) {
    bench.cycle(i % 7 == 0 ? 1U : (i % 11 == 0 ? 2U : 0U));
    if (i > 40) {
      ASSERT_NEAR(bench.observer.torque()[0], 1.5, 0.08) << i;
      ASSERT_NEAR(bench.observer.torque()[1], 0.7, 0.08) << i;
    }
  }
  for (int i = 0; i < 15; ++i) {
    bench.cycle(1U);
  }
  // The joints move one another: without one, neither is observed.
  EXPECT_EQ(bench.observer.observed(), 0U);
  bench.run(100);
  EXPECT_EQ(bench.observer.observed(), 3U);
  EXPECT_NEAR(bench.observer.torque()[0], 1.5, 0.03);
}

TEST(ExternalTorque, ConfiguredFrictionIsNotExternal) {
  ObserverBench bench;
  bench.options.joints[0].coulomb_friction = 0.8;
  bench.options.joints[0].viscous_friction = 0.3;
  bench.options.joints[0].friction_velocity = 0.01;
  bench.law =
      [](const PlanarTruth& at) -> Eigen::Vector2d {  // friction acts, its compensation as well
    return at.bias() + Eigen::Vector2d(0.0, 0.0);
  };
  bench.truth.v = {1.0, 0.0};
  for (int i = 0; i < 200; ++i) {
    bench.external = {-(0.8 + 0.3 * bench.truth.v[0]), 0.0};
    bench.cycle();
  }
  EXPECT_GT(bench.truth.v[0], 0.3);
  EXPECT_NEAR(bench.observer.torque()[0], 0.0, 0.03);
}

TEST(ExternalTorque, ANewModelIsNotComparedWithTheOld) {
  ObserverBench bench;
  bench.truth.v = {1.0, -2.0};
  bench.run(50);
  TreeDescription heavier = testing::planar_tree();
  heavier.links[2].inertia.mass_kg *= 2.0;
  bench.mechanism = Mechanism(heavier, Eigen::Vector3d(0.0, 0.0, 0.0));
  bench.observer.rebase();
  const double before = bench.observer.torque()[0];
  bench.cycle();
  EXPECT_EQ(bench.observer.torque()[0], before);
  EXPECT_EQ(bench.observer.observed(), 0U);
}

TEST(ExternalTorque, ArmsOnOneTorsoDoNotWaitForEachOther) {
  TreeDescription tree = testing::planar_tree();
  const std::size_t links = tree.links.size();
  for (std::size_t i = 1; i < links; ++i) {
    LinkDescription link = tree.links[i];
    link.name = "other" + link.name;
    tree.links.push_back(link);
    JointDescription joint = tree.joints[i - 1];
    joint.name = "other" + joint.name;
    joint.parent_link = i == 1 ? "base" : "otherlink1";
    joint.child_link = link.name;
    tree.joints.push_back(joint);
  }
  const Mechanism mechanism(tree, Eigen::Vector3d(0.0, -9.81, 0.0));
  const std::array<BitSet, kMaxJoints> sets = coupled_joints(mechanism);
  EXPECT_EQ(sets[0], 0b0011U);
  EXPECT_EQ(sets[1], 0b0011U);
  EXPECT_EQ(sets[2], 0b1100U);
  EXPECT_EQ(sets[3], 0b1100U);
}

TEST(Contact, BeginsBelowTheConfiguredTorqueAndEndsWithHysteresisAndTime) {
  ControllerOptions options = testing::planar_options();
  options.joints[0].contact_torque = 4.0;
  ContactDetector detector;
  std::array<double, kMaxJoints> torque{};
  const auto after = [&](double value, int cycles) {
    torque[0] = value;
    for (int i = 0; i < cycles; ++i) {
      detector.update(options, torque, 3U, 1e-3);
    }
    return detector.touched();
  };
  EXPECT_EQ(after(2.9, 100), 0U);
  EXPECT_EQ(after(-3.01, 1), 1U);
  EXPECT_EQ(after(2.5, 1000), 1U);  // above 0.7 * 3
  EXPECT_EQ(after(2.0, 99), 1U);
  EXPECT_EQ(after(2.0, 3), 0U);
  torque[1] = 1e6;  // no threshold there
  EXPECT_EQ(after(5.0, 1), 1U);
  detector.update(options, torque, 0U, 1e-3);  // not judged, no contact
  EXPECT_EQ(detector.touched(), 0U);
}

}  // namespace
}  // namespace geodesic::control
