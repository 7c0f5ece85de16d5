// The fast recursions against the textbook's, on random trees of every kind and on axes that are
// parallel, nearly parallel and opposite.
#include <gtest/gtest.h>

#include <numbers>
#include <string>

#include "control/mechanism/dynamics.hpp"
#include "tests/control/mechanism/plain_newton_euler.hpp"
#include "tests/control/mechanism/random_tree.hpp"

namespace geodesic::control {
namespace {

using Eigen::VectorXd;
using testing::plain_newton_euler;
using testing::RandomArm;

constexpr double kTolerance = 1e-12;

void expect_same(const Mechanism& mechanism, unsigned seed) {
  Workspace workspace(mechanism);
  RandomArm random(seed);
  const VectorXd zero = VectorXd::Zero(mechanism.dof());
  for (int state = 0; state < 10; ++state) {
    const VectorXd q = random.configuration(mechanism);
    const VectorXd v = random.vector(mechanism.dof(), 2.0);
    const VectorXd a = random.vector(mechanism.dof(), 5.0);
    const auto expect_near = [](const VectorXd& found, const VectorXd& expected) {
      const double scale = std::max(1.0, expected.cwiseAbs().maxCoeff());
      EXPECT_LE((found - expected).cwiseAbs().maxCoeff(), kTolerance * scale);
    };
    expect_near(bias(mechanism, workspace, q, v), plain_newton_euler(mechanism, q, v, zero));
    expect_near(gravity(mechanism, workspace, q), plain_newton_euler(mechanism, q, zero, zero));
    const VectorXd rotors = mechanism.rotor_inertia().cwiseProduct(a);
    expect_near(inverse_dynamics(mechanism, workspace, q, v, a),
                plain_newton_euler(mechanism, q, v, a) + rotors);
  }
}

TEST(NewtonEuler, EqualsTheTextbookOnRandomTrees) {
  for (unsigned seed = 0; seed < 200; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    expect_same(testing::random_mechanism(seed), 5000 + seed);
  }
}

/// A chain whose axes lean against one another by `angle`, alternately about x and y.
TreeDescription leaning(double angle) {
  TreeDescription tree;
  tree.name = "leaning";
  tree.root_link = "link0";
  tree.links.push_back({"link0", {}});
  RandomArm random(7);
  for (int i = 1; i <= 6; ++i) {
    LinkDescription link;
    link.name = "link" + std::to_string(i);
    link.inertia = random.inertia();
    tree.links.push_back(link);
    JointDescription joint;
    joint.name = "joint" + std::to_string(i);
    joint.kind = i == 4 ? JointKind::kPrismatic : JointKind::kContinuous;
    joint.parent_link = "link" + std::to_string(i - 1);
    joint.child_link = link.name;
    joint.parent_from_joint.translation() = Eigen::Vector3d(0.3, -0.1, 0.2);
    joint.parent_from_joint.linear() =
        Eigen::AngleAxisd(angle, Eigen::Vector3d::Unit(i % 2)).toRotationMatrix();
    joint.axis = Eigen::Vector3d::UnitZ();
    tree.joints.push_back(joint);
  }
  return tree;
}

TEST(NewtonEuler, EqualsTheTextbookWhereAxesAreParallelOrNearlySo) {
  const Eigen::Vector3d down(0.1, -0.2, -9.81);
  for (const double angle : {0.0, 1e-18, 5e-12, 1e-9, 1e-6, 1e-3, 0.5 * std::numbers::pi,
                             0.5 * std::numbers::pi - 4.9e-12, std::numbers::pi - 1e-9,
                             std::numbers::pi, -std::numbers::pi, -1e-7}) {
    SCOPED_TRACE(std::to_string(angle));
    expect_same(Mechanism(leaning(angle), down), 11);
    expect_same(Mechanism(leaning(angle), down, {Base::kFloating, {}}), 12);
  }
}

}  // namespace
}  // namespace geodesic::control
