// What must not depend on how a mechanism is written down: other link frames, another place in the
// world, joints counted backwards, another order. On random trees; nonlinear changes of coordinates
// are in geometry/chart_change_test.cpp.
#include <gtest/gtest.h>

#include <map>
#include <string>

#include "control/mechanism/dynamics.hpp"
#include "tests/control/mechanism/random_tree.hpp"

namespace geodesic::control {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using testing::RandomArm;

bool has_one_axis(const JointDescription& joint) {
  return joint.kind == JointKind::kRevolute || joint.kind == JointKind::kContinuous ||
         joint.kind == JointKind::kPrismatic || joint.kind == JointKind::kFixed;
}

TreeDescription random_description(unsigned seed) {
  constexpr int kSizes[] = {1, 2, 4, 7, 12, 32};
  RandomArm random(2000 + seed);
  testing::RandomTreeOptions shape;
  shape.joints = kSizes[seed % 6];
  shape.mimic_joints = seed % 3 == 2 ? 2 : 0;
  shape.any_kind = seed % 2 == 1;
  return random.tree(shape);
}

/// Everything of one state whose numbers are torques, metrics or energies.
struct Figures {
  MatrixXd metric, coriolis, rate;
  VectorXd torque, gravity;
  double kinetic, potential;

  Figures(const Mechanism& m, const VectorXd& q, const VectorXd& v, const VectorXd& a) {
    Workspace w(m);
    metric = control::metric(m, w, q);
    coriolis = coriolis_matrix(m, w, q, v);
    rate = metric_rate(m, w, q, v);
    torque = inverse_dynamics(m, w, q, v, a);
    gravity = control::gravity(m, w, q);
    kinetic = kinetic_energy(m, w, q, v);
    potential = potential_energy(m, w, q);
  }
};

void expect_near(const MatrixXd& found, const MatrixXd& expected, const char* what) {
  const double scale = std::max(1.0, expected.cwiseAbs().maxCoeff());
  EXPECT_LE((found - expected).cwiseAbs().maxCoeff(), 1e-12 * scale) << what;
}

/// `found` is `expected` under v = T v~, T constant.
void expect_same(const Figures& found, const Figures& expected, const MatrixXd& t) {
  expect_near(found.metric, t.transpose() * expected.metric * t, "M");
  expect_near(found.coriolis, t.transpose() * expected.coriolis * t, "C");
  expect_near(found.rate, t.transpose() * expected.rate * t, "dM/dt");
  expect_near(found.torque, t.transpose() * expected.torque, "inverse dynamics");
  expect_near(found.gravity, t.transpose() * expected.gravity, "gravity");
  EXPECT_NEAR(found.kinetic, expected.kinetic, 1e-12 * (1.0 + expected.kinetic));
}

template <class Check>
void on_random_trees(Check check) {
  for (unsigned seed = 0; seed < 18; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    check(random_description(seed), RandomArm(3000 + seed), seed);
  }
}

const Eigen::Vector3d kGravity(2.0, -3.0, -8.0);

TEST(MechanismInvariance, UnderTheChoiceOfLinkFrames) {
  on_random_trees([](const TreeDescription& tree, RandomArm random, unsigned seed) {
    // A link's frame may be turned at will, and moved along a joint's axis (by a slide: anywhere).
    TreeDescription other = tree;
    std::map<std::string, Eigen::Isometry3d> moved;
    for (const LinkDescription& link : tree.links) {
      moved[link.name].setIdentity();
    }
    for (const JointDescription& joint : tree.joints) {
      if (has_one_axis(joint)) {
        Eigen::Isometry3d& x = moved.at(joint.child_link);
        x = random.pose();
        if (joint.kind == JointKind::kRevolute || joint.kind == JointKind::kContinuous) {
          x.translation() = random.uniform(-0.3, 0.3) * joint.axis;
        }
      }
    }
    for (JointDescription& joint : other.joints) {
      const Eigen::Isometry3d& x = moved.at(joint.child_link);
      joint.parent_from_joint = moved.at(joint.parent_link).inverse() * joint.parent_from_joint * x;
      joint.axis = (x.linear().transpose() * joint.axis).normalized();
    }
    for (LinkDescription& link : other.links) {
      const Eigen::Isometry3d& x = moved.at(link.name);
      link.inertia.com_m = x.inverse() * link.inertia.com_m;
      const Eigen::Matrix3d turned =
          x.linear().transpose() * link.inertia.inertia_kg_m2 * x.linear();
      link.inertia.inertia_kg_m2 = 0.5 * (turned + turned.transpose());
    }
    const MechanismOptions options{seed % 3 == 0 ? Base::kFloating : Base::kFixed, {}};
    const Mechanism before(tree, kGravity, options);
    const Mechanism after(other, kGravity, options);
    const VectorXd q = random.configuration(before);
    const VectorXd v = random.vector(before.dof(), 2.0);
    const VectorXd a = random.vector(before.dof(), 2.0);
    const Figures expected(before, q, v, a);
    const Figures found(after, q, v, a);
    expect_same(found, expected, MatrixXd::Identity(v.size(), v.size()));
    EXPECT_NEAR(found.potential, expected.potential, 1e-12 * (1.0 + std::abs(expected.potential)));
  });
}

TEST(MechanismInvariance, UnderThePlaceInTheWorld) {
  on_random_trees([](TreeDescription tree, RandomArm random, unsigned) {
    const Eigen::Isometry3d place = random.pose();
    const Mechanism before(tree, kGravity);
    for (JointDescription& joint : tree.joints) {
      if (joint.parent_link == tree.root_link) {
        joint.parent_from_joint = place * joint.parent_from_joint;
      }
    }
    const Mechanism after(tree, place.linear() * kGravity);
    const VectorXd q = random.configuration(before);
    const VectorXd v = random.vector(before.dof(), 2.0);
    const VectorXd a = random.vector(before.dof(), 2.0);
    expect_same(Figures(after, q, v, a), Figures(before, q, v, a),
                MatrixXd::Identity(v.size(), v.size()));
  });
}

TEST(MechanismInvariance, UnderJointsCountedBackwardsAndInAnotherOrder) {
  on_random_trees([](const TreeDescription& tree, RandomArm random, unsigned) {
    TreeDescription other = tree;
    std::map<std::string, double> sign;
    for (JointDescription& joint : other.joints) {
      const bool alone = has_one_axis(joint) && !joint.mimic;
      sign[joint.name] = alone && random.below(2) == 0 ? -1.0 : 1.0;
      joint.axis *= sign[joint.name];
    }
    const auto renamed = [](const std::string& name) {  // siblings go by name: backwards now
      return std::to_string(9999 - std::stoi(name.substr(5))) + name;
    };
    for (JointDescription& joint : other.joints) {
      if (joint.mimic) {
        joint.mimic->multiplier *= sign.at(joint.mimic->joint);
        joint.mimic->joint = renamed(joint.mimic->joint);
      }
      joint.name = renamed(joint.name);
    }
    const Mechanism before(tree, kGravity);
    const Mechanism after(other, kGravity);
    MatrixXd t = MatrixXd::Zero(before.dof(), after.dof());
    const VectorXd q = random.configuration(before);
    VectorXd q_other(q.size());
    for (const Factor& own : before.factors()) {
      for (const Factor& theirs : after.factors()) {
        if (theirs.name == renamed(own.name)) {
          t.block(own.v, theirs.v, own.nv, own.nv) =
              sign.at(own.name) * MatrixXd::Identity(own.nv, own.nv);
          q_other.segment(theirs.q, own.nq) = sign.at(own.name) * q.segment(own.q, own.nq);
        }
      }
    }
    const VectorXd v = random.vector(before.dof(), 2.0);
    const VectorXd a = random.vector(before.dof(), 2.0);
    expect_same(Figures(after, q_other, t.transpose() * v, t.transpose() * a),
                Figures(before, q, v, a), t);
  });
}

}  // namespace
}  // namespace geodesic::control
