// No false contact: an arm moved at random by a law of its own, with masses and friction other than
// the observer believes. Minutes here; GEODESIC_RANDOM_MOTION_S=3600 makes it an hour.
#include <cstdlib>
#include <numbers>
#include <random>

#include <fmt/format.h>

#include "control/estimate.hpp"
#include "control/mechanism/metric.hpp"
#include "control/mechanism/newton_euler.hpp"
#include "control/safety/watch.hpp"
#include "tests/tools/watch_bench.hpp"

namespace geodesic::tools {
namespace {

using control::BitSet;
using control::kMaxJoints;

/// A sum of three sines a joint, never the same: smooth, within limits.
class Wander {
 public:
  Wander(const config::Robot& robot, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> part(0.0, 1.0);
    for (const control::JointTuning& joint : robot.controller.joints) {
      Joint one;
      const double low = std::max(joint.position_lower, -1.5) + 0.15 * span(joint);
      const double high = std::min(joint.position_upper, 1.5) - 0.15 * span(joint);
      one.middle = 0.5 * (low + high);
      for (std::size_t k = 0; k < 3; ++k) {
        one.amplitude[k] = 0.5 * (high - low) / 3.0;
        one.rate[k] = 2.0 * std::numbers::pi * (0.05 + 0.45 * part(random));
        one.phase[k] = 2.0 * std::numbers::pi * part(random);
      }
      joints_.push_back(one);
    }
  }

  void at(double t, std::size_t i, double& position, double& velocity, double& acceleration) const {
    const Joint& joint = joints_[i];
    position = joint.middle;
    velocity = 0.0;
    acceleration = 0.0;
    for (std::size_t k = 0; k < 3; ++k) {
      const double angle = joint.rate[k] * t + joint.phase[k];
      position += joint.amplitude[k] * std::sin(angle);
      velocity += joint.amplitude[k] * joint.rate[k] * std::cos(angle);
      acceleration -= joint.amplitude[k] * joint.rate[k] * joint.rate[k] * std::sin(angle);
    }
  }

 private:
  struct Joint {
    double middle = 0.0;
    std::array<double, 3> amplitude{};
    std::array<double, 3> rate{};
    std::array<double, 3> phase{};
  };
  static double span(const control::JointTuning& joint) {
    return std::min(joint.position_upper, 1.5) - std::max(joint.position_lower, -1.5);
  }
  std::vector<Joint> joints_;
};

double duration_s(double usual) {
  const char* asked = std::getenv("GEODESIC_RANDOM_MOTION_S");
  return asked != nullptr ? std::strtod(asked, nullptr) : usual;
}

struct Findings {
  std::vector<double> largest;
  std::vector<double> fastest;
  BitSet touched = 0;
  BitSet vibrating = 0;
  BitSet stuck = 0;
};

/// Computed torque by the believed model moves the real arm; the watch looks on.
Findings wander(const config::Robot& believed, const config::Robot& real, double seconds,
                unsigned seed) {
  const control::Mechanism mechanism = test::mechanism_of(believed);
  const std::size_t joints = believed.controller.joints.size();
  const auto size = static_cast<Eigen::Index>(joints);
  const control::ControllerOptions& options = believed.controller;
  control::Workspace workspace(mechanism);
  control::Estimator estimator(options);
  control::Watch watch(mechanism);
  test::Cell cell(real);
  const Wander path(believed, seed);
  std::vector<double> start(joints);
  std::vector<double> speed(joints);
  for (std::size_t i = 0; i < joints; ++i) {
    double unused = 0.0;
    path.at(0.0, i, start[i], speed[i], unused);
  }
  cell.physics.set_state(start, speed);
  control::ArmCommand command;
  command.joints = joints;
  for (std::size_t i = 0; i < joints; ++i) command.joint[i].mode = control::DriveMode::kEnable;

  Findings result{std::vector<double>(joints), std::vector<double>(joints)};
  std::array<double, kMaxJoints> model{};
  std::array<double, kMaxJoints> authority{};
  authority.fill(1.0);
  Eigen::VectorXd wanted(size);
  const double period_s = static_cast<double>(believed.period_ns) * 1e-9;
  const auto cycles = static_cast<std::int64_t>(seconds / period_s);
  for (std::int64_t cycle = 0; cycle < cycles; ++cycle) {
    cell.answer(command);
    const control::Estimate& estimate = estimator.update(cell.state, believed.period_ns);
    // The first answers come before any torque: nothing to look at yet.
    const BitSet on = cycle > 1000 ? control::first(joints) : 0;
    watch.observe(options, mechanism, workspace,
                  {cell.state, estimate, command, model, authority, on, on, believed.period_ns});
    if (on != 0) {
      control::Flags flags;
      watch.add_to(flags);
      const auto raised = [&](control::Fault fault) {
        return flags.present[static_cast<std::size_t>(fault)];
      };
      result.touched |= raised(control::Fault::kContact);
      result.vibrating |= raised(control::Fault::kVibration);
      result.stuck |= raised(control::Fault::kEncoderStuck);
      for (std::size_t i = 0; i < joints; ++i) {
        result.largest[i] = std::max(result.largest[i], std::abs(watch.external_torque()[i]));
        result.fastest[i] = std::max(result.fastest[i], std::abs(cell.physics.velocity(i)));
      }
    }
    const double t = static_cast<double>(cycle + 1) * period_s;
    for (std::size_t i = 0; i < joints; ++i) {
      double position = 0.0;
      double velocity = 0.0;
      double acceleration = 0.0;
      path.at(t, i, position, velocity, acceleration);
      constexpr double kCorner = 15.0;
      wanted[static_cast<Eigen::Index>(i)] = acceleration +
                                             kCorner * kCorner * (position - estimate.position[i]) +
                                             1.4 * kCorner * (velocity - estimate.velocity[i]);
    }
    const Eigen::VectorXd& torque = control::inverse_dynamics(
        mechanism, workspace, Eigen::Map<const Eigen::VectorXd>(estimate.position.data(), size),
        Eigen::Map<const Eigen::VectorXd>(estimate.velocity.data(), size), wanted);
    for (std::size_t i = 0; i < joints; ++i) {
      command.joint[i].torque = torque[static_cast<Eigen::Index>(i)];
    }
    cell.move();
  }
  return result;
}

void expect_silence(const char* name, double usual_s) {
  const config::Robot believed = test::load(name);
  config::Robot real = believed;
  real.simulation.floor = false;
  // Masses wrong by 10 % to either side, link by link; friction by half, joint by joint.
  test::scale_masses(real, [](std::size_t i) { return i % 2 == 0 ? 1.1 : 0.9; });
  for (std::size_t i = 0; i < real.simulation.joints.size(); ++i) {
    real.simulation.joints[i].coulomb_friction *= i % 2 == 0 ? 1.5 : 0.5;
    real.simulation.joints[i].viscous_friction *= i % 2 == 0 ? 0.5 : 1.5;
  }
  const double seconds = duration_s(usual_s);
  const Findings found = wander(believed, real, seconds, 1);
  for (std::size_t i = 0; i < found.largest.size(); ++i) {
    const control::JointTuning& joint = believed.controller.joints[i];
    fmt::print(
        "{:<24} {:.0f} s: external torque up to {:6.3f}, contact from {:6.3f}, up to {:.2f} "
        "rad/s\n",
        joint.name, seconds, found.largest[i], control::kContactLevel * joint.contact_torque,
        found.fastest[i]);
  }
  EXPECT_EQ(found.touched, 0U);
  EXPECT_EQ(found.vibrating, 0U);
  EXPECT_EQ(found.stuck, 0U);
}

TEST(RandomMotion, WrongMassesAndFrictionAreNoContactPlanar) {
  expect_silence("planar2r", 360.0);
}

TEST(RandomMotion, WrongMassesAndFrictionAreNoContactOpenArm) {
  expect_silence("openarm", 60.0);
}

}  // namespace
}  // namespace geodesic::tools
