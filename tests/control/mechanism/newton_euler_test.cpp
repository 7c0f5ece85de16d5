// The fast recursions against the textbook's, on random trees of every kind and on axes that are
// parallel, nearly parallel and opposite; and against themselves, built for other registers.
#include <gtest/gtest.h>

#include <numbers>
#include <string>

#include "control/mechanism/dynamics.hpp"
#include "tests/control/mechanism/plain_gravity.hpp"
#include "tests/control/mechanism/plain_metric.hpp"
#include "tests/control/mechanism/plain_newton_euler.hpp"
#include "tests/control/mechanism/random_tree.hpp"

namespace geodesic::control {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using testing::plain_gravity;
using testing::plain_metric;
using testing::plain_newton_euler;
using testing::RandomArm;

constexpr double kTolerance = 1e-12;

void expect_near(const MatrixXd& found, const MatrixXd& expected, const char* what) {
  const double scale = std::max(1.0, expected.cwiseAbs().maxCoeff());
  EXPECT_LE((found - expected).cwiseAbs().maxCoeff(), kTolerance * scale) << what;
}

/// All that is computed on compact bodies, one after the other.
VectorXd everything(const Mechanism& mechanism, Registers registers, const VectorXd& q,
                    const VectorXd& v, const VectorXd& a) {
  Workspace workspace(mechanism);
  workspace.registers = registers;
  const Eigen::Index n = mechanism.dof();
  VectorXd all(3 * n + n * n);
  all << bias(mechanism, workspace, q, v), gravity(mechanism, workspace, q),
      inverse_dynamics(mechanism, workspace, q, v, a), metric(mechanism, workspace, q).reshaped();
  return all;
}

void expect_same(const Mechanism& mechanism, unsigned seed) {
  Workspace workspace(mechanism);
  RandomArm random(seed);
  const VectorXd zero = VectorXd::Zero(mechanism.dof());
  for (int state = 0; state < 10; ++state) {
    const VectorXd q = random.configuration(mechanism);
    const VectorXd v = random.vector(mechanism.dof(), 2.0);
    const VectorXd a = random.vector(mechanism.dof(), 5.0);
    expect_near(bias(mechanism, workspace, q, v), plain_newton_euler(mechanism, q, v, zero),
                "bias");
    expect_near(gravity(mechanism, workspace, q), plain_gravity(mechanism, q), "gravity");
    const VectorXd rotors = mechanism.rotor_inertia().cwiseProduct(a);
    expect_near(inverse_dynamics(mechanism, workspace, q, v, a),
                plain_newton_euler(mechanism, q, v, a) + rotors, "inverse dynamics");
    MatrixXd m = plain_metric(mechanism, q);
    m.diagonal() += mechanism.rotor_inertia();
    expect_near(metric(mechanism, workspace, q), m, "metric");
    EXPECT_EQ(workspace.metric, workspace.metric.transpose());
  }
  const VectorXd q = random.configuration(mechanism);
  const VectorXd v = random.vector(mechanism.dof(), 2.0);
  const VectorXd baseline = everything(mechanism, Registers::kBaseline, q, v, zero);
  for (int wider = 1; wider <= static_cast<int>(widest_registers()); ++wider) {
    EXPECT_EQ(everything(mechanism, static_cast<Registers>(wider), q, v, zero), baseline)
        << "other bits with registers " << wider;
  }
}

TEST(NewtonEuler, EqualsTheTextbookOnRandomTrees) {
  for (unsigned seed = 0; seed < 200; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    expect_same(testing::random_mechanism(seed), 5000 + seed);
  }
}

/// A chain whose axes lean against one another by `angle`, alternately about x and y, or always
/// about x; what is fixed to the last link forks off.
TreeDescription leaning(double angle, bool alternately) {
  TreeDescription tree;
  tree.name = "leaning";
  tree.root_link = "link0";
  tree.links.push_back({"link0", {}});
  RandomArm random(7);
  for (int i = 1; i <= 8; ++i) {
    LinkDescription link;
    link.name = "link" + std::to_string(i);
    link.inertia = random.inertia();
    tree.links.push_back(link);
    JointDescription joint;
    joint.name = "joint" + std::to_string(i);
    joint.kind = i == 4 ? JointKind::kPrismatic : JointKind::kContinuous;
    joint.parent_link = "link" + std::to_string(i == 8 ? 5 : i - 1);
    joint.child_link = link.name;
    // Some axes meet, some pass at a distance along the common normal, some anywhere.
    joint.parent_from_joint.translation() =
        i % 3 == 0 ? Eigen::Vector3d(0.0, 0.0, 0.2)
                   : Eigen::Vector3d(0.3, i % 3 == 1 ? -0.1 : 0.0, 0.2);
    joint.parent_from_joint.linear() =
        Eigen::AngleAxisd(angle, Eigen::Vector3d::Unit(alternately ? i % 2 : 0)).toRotationMatrix();
    joint.axis = Eigen::Vector3d::UnitZ();
    tree.joints.push_back(joint);
  }
  return tree;
}

TEST(NewtonEuler, EqualsTheTextbookWhereAxesAreParallelOrNearlySo) {
  const Eigen::Vector3d down(0.1, -0.2, -9.81);
  for (const double angle : {0.0, 1e-18, 1e-15, 5e-12, 1e-9, 1e-6, 1e-3, 0.5 * std::numbers::pi,
                             1.5707963267949, 0.5 * std::numbers::pi - 4.9e-12,
                             std::numbers::pi - 1e-9, std::numbers::pi, -std::numbers::pi, -1e-7}) {
    SCOPED_TRACE(std::to_string(angle));
    for (const bool alternately : {true, false}) {
      expect_same(Mechanism(leaning(angle, alternately), down), 11);
      expect_same(Mechanism(leaning(angle, alternately), down, {Base::kFloating, {}}), 12);
    }
  }
}

/// Which terms a mechanism's bodies have: where this fails, results stay right and speed is lost.
TEST(CompactTree, RightAnglesAndMeetingAxesCostNothing) {
  const Mechanism arm(leaning(1.5707963267949, false), Eigen::Vector3d(0.0, 0.0, -9.81));
  const auto& bodies = arm.compact_tree().bodies;
  EXPECT_EQ(bodies[2].tilt, Tilt::kQuarter);
  EXPECT_EQ(bodies[2].reach, Reach::kInPlane);
  EXPECT_EQ(bodies[2].step, Step::kQuarterReaching);
  EXPECT_TRUE(bodies[2].light && bodies[2].chained && !bodies[2].forks);
  EXPECT_TRUE(bodies[4].forks);
  EXPECT_FALSE(bodies[7].chained);
  const Mechanism truncated(leaning(1.57079632679, false), Eigen::Vector3d(0.0, 0.0, -9.81));
  EXPECT_EQ(truncated.compact_tree().bodies[2].tilt, Tilt::kAny);
}

}  // namespace
}  // namespace geodesic::control
