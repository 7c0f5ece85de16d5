// What must hold of the controller whatever it is shown: the same bits for the same inputs, no
// allocation, nothing but finite numbers out; and that an arm of its own equations floats.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <limits>
#include <random>

#include "control/controller.hpp"
#include "control/mechanism/dynamics.hpp"
#include "rt/heap_counter.hpp"
#include "tests/control/planar_arm.hpp"

namespace geodesic::control {
namespace {

using testing::Bench;
using testing::kPeriod;
using testing::ObedientArm;
using testing::planar_mechanism;
using testing::planar_options;
using enum SupervisorState;

bool same_bits(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

bool same(const ArmCommand& a, const ArmCommand& b) {
  bool equal = a.joints == b.joints;
  for (std::size_t i = 0; i < kMaxJoints; ++i) {
    const JointCommand& x = a.joint[i];
    const JointCommand& y = b.joint[i];
    equal = equal && x.mode == y.mode && same_bits(x.torque, y.torque) &&
            same_bits(x.position, y.position) && same_bits(x.velocity, y.velocity) &&
            same_bits(x.stiffness, y.stiffness) && same_bits(x.damping, y.damping);
  }
  return equal;
}

bool finite(const JointCommand& joint) {
  return std::isfinite(joint.torque) && std::isfinite(joint.position) &&
         std::isfinite(joint.velocity) && std::isfinite(joint.stiffness) &&
         std::isfinite(joint.damping) && joint.damping >= 0.0 && joint.stiffness == 0.0;
}

/// Random motion, losses, faults and numbers that are none, more rarely the worse.
class Storm {
 public:
  explicit Storm(unsigned seed) : random_(seed) {}

  void disturb(ArmState& state) {
    for (std::size_t i = 0; i < 2; ++i) {
      JointState& joint = state.joint[i];
      joint.position += 1e-4 * unit();
      joint.velocity += 0.01 * unit();
      joint.fresh = !chance(50);
      joint.stamp_ns += static_cast<std::int64_t>(random_() % 100'000);
      if (chance(20'000)) {
        joint.condition = DriveCondition::kError;
      } else if (chance(20'000)) {
        joint.condition = DriveCondition::kUnknown;
      }
      if (chance(5'000)) {
        wild(joint.position);
      }
      if (chance(5'000)) {
        wild(joint.velocity);
      }
      if (chance(20'000)) {
        wild(joint.temperature_c);
      }
      if (chance(20'000)) {
        joint.stamp_ns = static_cast<std::int64_t>((std::uint64_t{random_()} << 32) | random_());
      }
    }
    state.overran = chance(2);
    state.bus[0].stalled = chance(1'000);
    state.bus[0].down = chance(20'000);
    if (chance(20'000)) {
      state.joints = random_() % 40;
    }
    if (chance(50'000)) {
      state.tick_ns = static_cast<std::int64_t>((std::uint64_t{random_()} << 32) | random_());
    }
  }

  Request request() {
    if (!chance(1'000)) {
      return {};
    }
    const auto kind = static_cast<Request::Kind>(random_() % 3);
    return {kind, static_cast<LawKind>(random_() % 6)};
  }

 private:
  bool chance(unsigned one_in) { return random_() % one_in == 0; }
  double unit() { return static_cast<double>(random_()) / 2147483648.0 - 1.0; }
  void wild(double& value) {
    constexpr std::array<double, 8> kWild{std::numeric_limits<double>::quiet_NaN(),
                                          std::numeric_limits<double>::infinity(),
                                          -std::numeric_limits<double>::infinity(),
                                          std::numeric_limits<double>::max(),
                                          std::numeric_limits<double>::denorm_min(),
                                          -9.9e5,
                                          1e-320,
                                          -0.0};
    value = kWild[random_() % kWild.size()];
  }

  std::mt19937 random_;
};

TEST(ControllerRobustness, SameInputsGiveTheSameBitsAndOnlyFiniteOnes) {
  ControllerOptions options = planar_options();
  options.allow_zero_law = true;
  options.safety.start_ramp_s = 0.2;
  options.safety.lower_s = 0.1;
  int active = 0;
  for (unsigned seed = 1; seed <= 4; ++seed) {
    Controller one(planar_mechanism(), options);
    Controller two(planar_mechanism(), options);
    ObedientArm arm;
    Storm storm(seed);
    ArmCommand command;
    for (int i = 0; i < 100'000; ++i) {
      arm.obey(command);
      // Now and then the arm is repaired, else it would be broken for most of the time.
      if (i % 2'000 == 0) {
        const std::int64_t tick_ns = arm.state.tick_ns;
        arm = ObedientArm();
        arm.state.tick_ns = tick_ns < 0 || tick_ns > (std::int64_t{1} << 60) ? 0 : tick_ns;
      }
      ArmState seen = arm.state;
      storm.disturb(seen);
      arm.state.joint = seen.joint;
      const Request request =
          i % 2'000 == 500 ? Request{Request::Kind::kLaw, LawKind::kFloat} : storm.request();
      one.request(request);
      two.request(request);
      command = one.update(seen, kPeriod);
      ASSERT_TRUE(same(command, two.update(seen, kPeriod))) << "seed " << seed << " cycle " << i;
      const SupervisorState state = one.report().state;
      active += state == kActive ? 1 : 0;
      for (std::size_t k = 0; k < 2; ++k) {
        ASSERT_TRUE(finite(command.joint[k]));
        ASSERT_TRUE(makes_torque(state) || command.joint[k].torque == 0.0);
        ASSERT_LE(std::abs(command.joint[k].torque), options.joints[k].torque_limit);
      }
      for (std::size_t k = 0; k < one.report().events; ++k) {
        ASSERT_TRUE(std::isfinite(one.report().event[k].found));
        ASSERT_TRUE(std::isfinite(one.report().event[k].limit));
      }
    }
  }
  EXPECT_GT(active, 10'000);
}

TEST(ControllerRobustness, AnythingThatIsNoNumberEndsInFault) {
  constexpr std::array<double, 4> kBad{
      std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(),
      -std::numeric_limits<double>::infinity(), std::numeric_limits<double>::max()};
  for (const SupervisorState from :
       {kConnecting, kReady, kEnabling, kActive, kStopping, kLowering}) {
    for (const double bad : kBad) {
      for (double JointState::*field : {&JointState::position, &JointState::velocity,
                                        &JointState::torque, &JointState::temperature_c}) {
        Bench bench;
        if (from == kStopping || from == kLowering) {
          ASSERT_TRUE(bench.run_until(kActive));
          bench.controller.request({Request::Kind::kStop, LawKind::kFloat});
        }
        ASSERT_TRUE(bench.run_until(from));
        bench.cycle([&](ArmState& state) { state.joint[1].*field = bad; });
        EXPECT_TRUE(bench.raised(Fault::kNotFinite, 1));
        EXPECT_EQ(bench.state(), makes_torque(from) ? kLowering : kFault);
        EXPECT_EQ(bench.command.joint[0].torque, 0.0);
        EXPECT_TRUE(bench.run_until(kFault, 3100));
      }
    }
  }
}

TEST(ControllerRobustness, UpdateGoesNowhereNearTheHeap) {
  Bench bench;
  Storm storm(3);
  const std::uint64_t before = rt::heap_calls();
  for (int i = 0; i < 20'000; ++i) {
    bench.cycle([&](ArmState& state) { storm.disturb(state); });
    bench.controller.request(storm.request());
  }
  EXPECT_EQ(rt::heap_calls() - before, 0u);
}

/// The planar arm as its own equations see it, between the cycles of a controller. As in the
/// daemon, what is computed in one cycle acts from the next on.
struct FreeArm {
  const Mechanism mechanism = planar_mechanism();
  Workspace workspace{mechanism};
  Bench bench;

  explicit FreeArm(const ControllerOptions& options) : bench(options) {}

  /// To active and past the ramp, carried by a stand.
  void start() {
    ASSERT_TRUE(bench.run_until(kActive));
    for (int i = 0; i < 1100; ++i) {
      bench.cycle();
    }
  }

  void cycle() {
    const ArmCommand sent = bench.command;
    bench.cycle();
    move(sent);
  }

  double kinetic() {
    const Eigen::Vector4d x = get();
    return kinetic_energy(mechanism, workspace, Eigen::VectorXd(x.head<2>()),
                          Eigen::VectorXd(x.tail<2>()));
  }

  Eigen::Vector4d get() const {
    const auto& joint = bench.arm.state.joint;
    return {joint[0].position, joint[1].position, joint[0].velocity, joint[1].velocity};
  }

  Eigen::Vector4d rate(const Eigen::Vector4d& x, const Eigen::VectorXd& torque) {
    const Eigen::VectorXd q = x.head<2>();
    const Eigen::VectorXd v = x.tail<2>();
    Eigen::Vector4d result;
    result << v, *forward_dynamics(mechanism, workspace, q, v, torque);
    return result;
  }

  /// One period by the classical Runge-Kutta method.
  void move(const ArmCommand& command) {
    const Eigen::VectorXd torque =
        Eigen::Vector2d(command.joint[0].torque, command.joint[1].torque);
    const double h = 1e-9 * static_cast<double>(kPeriod);
    const Eigen::Vector4d x = get();
    const Eigen::Vector4d k1 = rate(x, torque);
    const Eigen::Vector4d k2 = rate(x + 0.5 * h * k1, torque);
    const Eigen::Vector4d k3 = rate(x + 0.5 * h * k2, torque);
    const Eigen::Vector4d k4 = rate(x + h * k3, torque);
    const Eigen::Vector4d next = x + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
    for (std::size_t i = 0; i < 2; ++i) {
      bench.arm.state.joint[i].position = next[static_cast<Eigen::Index>(i)];
      bench.arm.state.joint[i].velocity = next[static_cast<Eigen::Index>(i) + 2];
    }
  }
};

TEST(ControllerFloat, StaysWhereItIsLeft) {
  FreeArm arm(planar_options());
  arm.start();
  for (int i = 0; i < 20'000; ++i) {
    arm.cycle();
  }
  EXPECT_NEAR(arm.get()[0], 0.3, 1e-9);
  EXPECT_NEAR(arm.get()[1], 0.3, 1e-9);
}

ControllerOptions free_options() {
  ControllerOptions options = planar_options();
  for (JointTuning& joint : options.joints) {
    joint.coulomb_friction = 0.0;
    joint.viscous_friction = 0.0;
    joint.position_lower = -std::numeric_limits<double>::infinity();
    joint.position_upper = std::numeric_limits<double>::infinity();
  }
  return options;
}

// With gravity and Coriolis both compensated M(q) a = 0: joint velocities stay, energy need not.
TEST(ControllerFloat, CoastsAtConstantJointVelocity) {
  FreeArm arm(free_options());
  arm.start();
  arm.bench.arm.state.joint[0].velocity = 0.5;
  arm.bench.arm.state.joint[1].velocity = -1.0;
  for (int i = 0; i < 4'000; ++i) {
    arm.cycle();
  }
  EXPECT_EQ(arm.bench.state(), kActive);
  EXPECT_GT((arm.get().head<2>() - Eigen::Vector2d(0.3, 0.3)).norm(), 4.0);
  EXPECT_NEAR(arm.get()[2], 0.5, 0.01);
  EXPECT_NEAR(arm.get()[3], -1.0, 0.01);
}

TEST(ControllerFloat, AControlledStopTakesEnergyOutUntilRest) {
  FreeArm arm(free_options());
  arm.start();
  arm.bench.arm.state.joint[0].velocity = 0.5;
  arm.bench.controller.request({Request::Kind::kStop, LawKind::kFloat});
  arm.cycle();
  arm.cycle();  // the first torque of the stop acts
  double energy = arm.kinetic();
  while (true) {
    arm.cycle();
    if (arm.bench.state() != kStopping) {
      break;
    }
    EXPECT_LE(arm.kinetic(), energy);
    energy = arm.kinetic();
  }
  EXPECT_EQ(arm.bench.state(), kLowering);
  EXPECT_LT(std::abs(arm.get()[2]), 0.05);
  EXPECT_LT(std::abs(arm.get()[3]), 0.05);
}

}  // namespace
}  // namespace geodesic::control
