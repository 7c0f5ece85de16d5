// The expressions of `geodesic compile`, evaluated number by number, against the mechanism's own
// algorithms: no compiler takes part.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "config/urdf.hpp"
#include "control/mechanism/dynamics.hpp"
#include "tests/tools/compile_fixture.hpp"
#include "tools/compile/compose.hpp"

namespace geodesic::tools::compile {
namespace {

using Eigen::VectorXd;

/// What a program gives for these arrays.
VectorXd evaluate(const Program& program, const VectorXd& q, const VectorXd& v, const VectorXd& a) {
  const auto& nodes = program.graph->nodes();
  std::vector<double> value(nodes.size());
  const VectorXd* const arrays[] = {&q, &v, &a};
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const Node& node = nodes[i];
    const auto operand = [&](int which) { return value[static_cast<std::size_t>(which)]; };
    double angle = 0.0;
    if (node.op == Op::kSine || node.op == Op::kCosine) {
      for (const JointAngle& part : program.graph->angles()[static_cast<std::size_t>(node.a)]) {
        angle += part.rate * q[part.coordinate] + part.offset;
      }
    }
    switch (node.op) {
      case Op::kConstant:
        value[i] = node.value;
        break;
      case Op::kInput:
        value[i] = (*arrays[node.a])[node.b];
        break;
      case Op::kSine:
        value[i] = std::sin(angle);
        break;
      case Op::kCosine:
        value[i] = std::cos(angle);
        break;
      case Op::kAdd:
        value[i] = operand(node.a) + operand(node.b);
        break;
      case Op::kSubtract:
        value[i] = operand(node.a) - operand(node.b);
        break;
      case Op::kMultiply:
        value[i] = operand(node.a) * operand(node.b);
        break;
      case Op::kReciprocal:
        value[i] = 1.0 / operand(node.a);
        break;
    }
  }
  VectorXd result(static_cast<Eigen::Index>(program.outputs.size()));
  for (Eigen::Index i = 0; i < result.size(); ++i) {
    const Number& output = program.outputs[static_cast<std::size_t>(i)];
    const double x =
        output.is_constant() ? output.value() : value[static_cast<std::size_t>(output.node())];
    result[i] = output.negative() ? -x : x;
  }
  return result;
}

void expect_near(const VectorXd& found, const VectorXd& expected, const std::string& what) {
  ASSERT_EQ(found.size(), expected.size()) << what;
  const double scale = std::max(expected.cwiseAbs().maxCoeff(), 1e-3);
  EXPECT_LE((found - expected).cwiseAbs().maxCoeff(), 1e-12 * scale) << what;
}

void expect_same_dynamics(const control::Mechanism& mechanism, double snap,
                          const std::string& what) {
  const Emission emission = compose(mechanism, snap);
  control::Workspace workspace(mechanism);
  std::mt19937 dice(3);
  std::uniform_real_distribution<double> uniform(-3.0, 3.0);
  for (int k = 0; k < 4; ++k) {
    VectorXd q(mechanism.nq());
    VectorXd v(mechanism.dof());
    VectorXd a(mechanism.dof());
    for (VectorXd* vector : {&q, &v, &a}) {
      for (double& x : *vector) x = uniform(dice);
    }
    if (k == 0) v.setZero();
    expect_near(evaluate(emission.programs[0], q, v, a), control::bias(mechanism, workspace, q, v),
                what + " bias");
    expect_near(evaluate(emission.programs[1], q, v, a), control::gravity(mechanism, workspace, q),
                what + " gravity");
    expect_near(evaluate(emission.programs[2], q, v, a),
                control::metric(mechanism, workspace, q).reshaped(), what + " metric");
    expect_near(evaluate(emission.programs[3], q, v, a),
                control::inverse_dynamics(mechanism, workspace, q, v, a), what + " inverse");
  }
}

TEST(CompilePrograms, ArithmeticFoldsAndShares) {
  Graph graph;
  const Number x = graph.input(Array::kQ, 0);
  const Number y = graph.input(Array::kV, 0);
  EXPECT_TRUE((x * 0.0).is_zero());
  EXPECT_TRUE((x - x).is_zero());
  EXPECT_EQ((x * 1.0).node(), x.node());
  EXPECT_EQ((x + 0.0).node(), x.node());
  EXPECT_EQ((x * y).node(), (y * x).node());
  EXPECT_EQ((x - y).node(), (y - x).node());
  EXPECT_NE((x - y).negative(), (y - x).negative());
  EXPECT_EQ(((-x) * y).node(), (x * y).node());
  EXPECT_TRUE(((-x) * y).negative());
  EXPECT_EQ((2.0 * (3.0 * x)).node(), (6.0 * x).node());
  EXPECT_EQ((2.0 * x + 3.0 * x).node(), (5.0 * x).node());
  EXPECT_EQ((0.5 * (2.0 * x)).node(), x.node());
  EXPECT_EQ((Number(2.0) * Number(3.0)).value(), 6.0);
  const Cost cost = cost_of(graph, {x * y + x, x * y});
  EXPECT_EQ(cost.multiplications, 1);
  EXPECT_EQ(cost.additions, 1);
}

TEST(CompilePrograms, EveryArmOfTheOraclesAsTheMechanism) {
  for (const char* robot : {"planar2r", "ur5", "iiwa14", "openarm"}) {
    const config::UrdfResult urdf =
        config::load_urdf(std::string(GEODESIC_TEST_DATA "/oracles/") + robot + ".urdf", false);
    ASSERT_TRUE(urdf.ok) << robot;
    const control::Mechanism mechanism(urdf.tree, Eigen::Vector3d(0.3, -9.0, -4.0));
    expect_same_dynamics(mechanism, kSnaps[0], robot);
    expect_same_dynamics(mechanism, 0.0, std::string(robot) + " as it is");
  }
}

TEST(CompilePrograms, RandomTreesAsTheMechanism) {
  for (unsigned seed = 0; seed < 12; ++seed) {
    const bool floats = seed % 3 == 2;
    const control::Mechanism mechanism = random_mechanism(seed, floats);
    expect_same_dynamics(mechanism, kSnaps[seed % 3], "seed " + std::to_string(seed));
  }
}

TEST(CompilePrograms, AnArmNeedsFewOperations) {
  const config::UrdfResult urdf =
      config::load_urdf(GEODESIC_TEST_DATA "/oracles/openarm.urdf", false);
  const Emission emission =
      compose(control::Mechanism(urdf.tree, Eigen::Vector3d(0.0, 0.0, -9.81)), kSnaps[0]);
  // The recursion as it stands has about 56 and 52 a joint; the figures reached are in tests/bench.
  EXPECT_LE(emission.programs[0].cost().multiplications, 300);
  EXPECT_LE(emission.programs[0].cost().additions, 260);
  EXPECT_LE(emission.programs[1].cost().instructions(), 90);
  EXPECT_LE(emission.programs[2].cost().instructions(), 240);
}

TEST(CompilePrograms, TheSameMechanismGivesTheSameText) {
  const control::Mechanism mechanism = random_mechanism(5, false);
  const std::string text = emit(compose(mechanism, kSnaps[0]));
  EXPECT_EQ(text, emit(compose(random_mechanism(5, false), kSnaps[0])));
  EXPECT_NE(text.find(mechanism.joint_names().front()), std::string::npos);
}

TEST(CompilePrograms, WhatIsNotCompiledIsNamed) {
  control::TreeDescription tree = random_tree(1);
  tree.joints.front().kind = control::JointKind::kSpherical;
  for (control::JointDescription& joint : tree.joints) joint.mimic.reset();
  const control::Mechanism mechanism(tree, Eigen::Vector3d(0.0, 0.0, -9.81));
  EXPECT_NE(uncompilable(mechanism).find("spherical"), std::string::npos);
  EXPECT_THROW(compose(mechanism, 0.0), std::invalid_argument);
}

}  // namespace
}  // namespace geodesic::tools::compile
