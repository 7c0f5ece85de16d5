// What the product is named after, in closed loop: an arm whose gravity is compensated moves, once
// pushed, along a geodesic of its kinetic-energy metric. MuJoCo moves the arm.
#include "control/mechanism/energy.hpp"
#include "control/mechanism/munthe_kaas.hpp"
#include "tests/tools/watch_bench.hpp"

namespace geodesic::tools {
namespace {

/// Nothing but inertia: no friction, neither in the joints nor compensated.
config::Robot frictionless(double coriolis) {
  config::Robot robot = test::load("planar2r");
  for (control::JointTuning& joint : robot.controller.joints) {
    joint.coulomb_friction = 0.0;
    joint.viscous_friction = 0.0;
    joint.damping = 0.0;
  }
  for (config::SimulatedJoint& joint : robot.simulation.joints) {
    joint.coulomb_friction = 0.0;
    joint.viscous_friction = 0.0;
    joint.rotor_inertia = 0.0;
  }
  for (control::JointTuning& joint : robot.controller.joints) {
    joint.rotor_inertia = 0.0;
  }
  robot.controller.coriolis = coriolis;
  return robot;
}

struct Coasting {
  Eigen::Vector2d q0, v0;  ///< just after the push
  Eigen::Vector2d q, v;    ///< kCoast later
};

constexpr double kCoast = 0.8;  // [s]

Coasting coast(double coriolis) {
  const config::Robot robot = frictionless(coriolis);
  test::WatchLoop loop(robot, robot);
  EXPECT_TRUE(loop.run_until_authority(1.0));
  loop.cell.on_stand = false;
  loop.run(0.5);  // until the spring that carries the arm through its check at arm-up has gone
  const auto state = [&](Eigen::Vector2d& q, Eigen::Vector2d& v) {
    for (std::size_t i = 0; i < 2; ++i) {
      q[static_cast<Eigen::Index>(i)] = loop.cell.physics.position(i);
      v[static_cast<Eigen::Index>(i)] = loop.cell.physics.velocity(i);
    }
  };
  Coasting result;
  state(result.q0, result.v0);
  result.v0 = {-0.6, 1.9};
  loop.cell.physics.set_state({result.q0.data(), 2}, {result.v0.data(), 2});
  loop.run(kCoast);
  state(result.q, result.v);
  for (const control::FaultEvent& event : loop.events) {
    EXPECT_EQ(event.fault, control::Fault::kContact) << control::policy(event.fault).name;
  }
  return result;
}

/// Where the geodesic from the same state is after the same time.
Coasting geodesic(Coasting from) {
  const config::Robot robot = frictionless(0.0);
  const control::Mechanism weightless(robot.tree, Eigen::Vector3d::Zero());
  control::MuntheKaasIntegrator integrator(weightless);
  integrator.start(from.q0, from.v0);
  for (int i = 0; i < 800; ++i) {
    EXPECT_TRUE(integrator.step(kCoast / 800));
  }
  from.q = integrator.q();
  from.v = integrator.velocity();
  return from;
}

TEST(Geodesic, AnArmWithoutWeightFollowsOne) {
  const Coasting found = coast(0.0);
  const Coasting expected = geodesic(found);
  // The way is 1.5 rad long and bends by half a radian; drives report 12 bits of velocity.
  EXPECT_GT((expected.q - (found.q0 + kCoast * found.v0)).norm(), 0.1);
  EXPECT_LT((found.q - expected.q).norm(), 0.01);
  EXPECT_LT((found.v - expected.v).norm(), 0.03);
}

TEST(Geodesic, WithCoriolisCompensatedItGoesStraightInJointSpace) {
  const Coasting found = coast(1.0);
  EXPECT_LT((found.v - found.v0).norm(), 0.03);
  EXPECT_LT((found.q - (found.q0 + kCoast * found.v0)).norm(), 0.01);
}

}  // namespace
}  // namespace geodesic::tools
