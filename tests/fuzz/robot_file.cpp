// Fuzz target: the robot's TOML as text, beside the URDFs of the robots that come with the project.
#include <cmath>
#include <memory>

#include "config/robot.hpp"
#include "control/controller.hpp"
#include "drivers/families.hpp"
#include "tests/fuzz/fuzz.hpp"
#include "tests/fuzz/messages.hpp"

namespace geodesic::fuzz {
namespace {

void provide_urdfs() {
  static const bool done = [] {
    write_scratch("planar2r.urdf", source_text("config/robots/planar2r/planar2r.urdf"));
    write_scratch("openarm.urdf", source_text("config/robots/openarm/openarm.urdf"));
    return true;
  }();
  expect(done, "the URDFs are there");
}

/// What is accepted can be run: the controller takes it, and every drive its options.
void check_robot(const config::Robot& robot) {
  expect(robot.period_ns > 0, "a period above 0");
  expect(robot.gravity.allFinite(), "gravity is finite");
  expect(!robot.arm.buses.empty() && robot.arm.buses.size() <= control::kMaxBuses, "1 to 8 buses");
  const std::size_t joints = robot.controller.joints.size();
  expect(joints >= 1 && joints <= control::kMaxJoints, "1 to 32 joints");
  expect(robot.arm.joints.size() == joints && robot.simulation.joints.size() == joints &&
             robot.simulation.pose.size() == joints,
         "every part speaks of the same joints");
  for (const double position : robot.simulation.pose) {
    expect(std::isfinite(position), "the simulated arm starts somewhere");
  }
  for (const drivers::JointOptions& joint : robot.arm.joints) {
    expect(joint.bus < robot.arm.buses.size(), "every joint is on a bus");
    const drivers::Family* family = drivers::find_family(joint.drive.family);
    expect(family != nullptr && family->check(joint.drive).empty(), "its drive is a good one");
  }
  for (const control::JointTuning& joint : robot.controller.joints) {
    expect(joint.position_lower < joint.position_upper, "lower limits are below upper ones");
    expect(std::isfinite(joint.torque_limit) && joint.torque_limit > 0.0, "a torque limit");
  }
  expect(control::check(robot.controller).empty(), "the controller takes these options");
  control::MechanismOptions options;
  options.rotor_inertia.resize(static_cast<Eigen::Index>(joints));
  for (std::size_t i = 0; i < joints; ++i) {
    options.rotor_inertia[static_cast<Eigen::Index>(i)] = robot.controller.joints[i].rotor_inertia;
  }
  const control::Mechanism mechanism(robot.tree, robot.gravity, options);
  expect(mechanism.dof() == static_cast<int>(joints), "one joint for each degree of freedom");
  static_cast<void>(std::make_unique<control::Controller>(mechanism, robot.controller));
}

}  // namespace

void robot_file(Bytes bytes) {
  provide_urdfs();
  const std::filesystem::path file = write_scratch("robot.toml", as_text(bytes));
  const config::LoadResult result = config::load_robot(file);
  check_messages(result.messages, result.ok);
  if (result.ok) check_robot(result.robot);
}

}  // namespace geodesic::fuzz
