// Orocos KDL's opinion on every robot with a fixed base and joints of one degree of freedom: its
// tree solvers on the whole tree, its chain solvers where the robot is a chain.
#include <gtest/gtest.h>

#include <kdl/chaindynparam.hpp>
#include <kdl/tree.hpp>
#include <kdl/treefksolverpos_recursive.hpp>
#include <kdl/treeidsolver_recursive_newton_euler.hpp>
#include <kdl/treejnttojacsolver.hpp>
#include <map>

#include "control/mechanism/dynamics.hpp"
#include "control/mechanism/tree_order.hpp"
#include "tests/cross/subjects.hpp"

namespace geodesic::cross {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

KDL::Vector vector(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

/// As kdl_parser makes it of a URDF: one segment a joint, the root's inertia left out.
KDL::Tree tree_of(const control::TreeDescription& description) {
  std::map<std::string, control::LinkInertia> inertia;
  for (const auto& link : description.links) {
    inertia[link.name] = link.inertia;
  }
  KDL::Tree tree(description.root_link);
  for (const control::JointDescription* joint : control::depth_first(description)) {
    const Eigen::Matrix3d r = joint->parent_from_joint.linear();
    const KDL::Frame frame(KDL::Rotation(r(0, 0), r(0, 1), r(0, 2), r(1, 0), r(1, 1), r(1, 2),
                                         r(2, 0), r(2, 1), r(2, 2)),
                           vector(joint->parent_from_joint.translation()));
    KDL::Joint kdl(joint->name, KDL::Joint::None);
    if (joint->kind != control::JointKind::kFixed) {
      kdl = KDL::Joint(joint->name, frame.p, frame.M * vector(joint->axis),
                       joint->kind == control::JointKind::kPrismatic ? KDL::Joint::TransAxis
                                                                     : KDL::Joint::RotAxis);
    }
    const control::LinkInertia& link = inertia.at(joint->child_link);
    const Eigen::Matrix3d& i = link.inertia_kg_m2;
    const KDL::RigidBodyInertia body(
        link.mass_kg, vector(link.com_m),
        KDL::RotationalInertia(i(0, 0), i(1, 1), i(2, 2), i(0, 1), i(0, 2), i(1, 2)));
    EXPECT_TRUE(
        tree.addSegment(KDL::Segment(joint->child_link, kdl, frame, body), joint->parent_link));
  }
  return tree;
}

/// The same tree where every joint is free to move, since KDL knows no mimic joints: q_all = map *
/// q + offset, and by the chain rule v_all = map * v, tau = map' * tau_all, M = map' M_all map.
/// Rows in the order of depth_first(), columns of the mechanism.
struct Unfolded {
  MatrixXd map;
  VectorXd offset;
};

Unfolded unfold(const Subject& subject, const control::Mechanism& mechanism) {
  std::vector<const control::JointDescription*> moving;
  for (const control::JointDescription* joint : control::depth_first(subject.tree)) {
    if (joint->kind != control::JointKind::kFixed) {
      moving.push_back(joint);
    }
  }
  const auto rows = static_cast<Eigen::Index>(moving.size());
  Unfolded result{MatrixXd::Zero(rows, mechanism.dof() - mechanism.first_joint_v()),
                  VectorXd::Zero(rows)};
  for (Eigen::Index row = 0; row < rows; ++row) {
    const control::JointDescription& joint = *moving[static_cast<std::size_t>(row)];
    const auto column = mechanism.find_joint(joint.mimic ? joint.mimic->joint : joint.name);
    result.map(row, column.value()) = joint.mimic ? joint.mimic->multiplier : 1.0;
    result.offset[row] = joint.mimic ? joint.mimic->offset : 0.0;
  }
  return result;
}

KDL::JntArray array(const VectorXd& v) {
  KDL::JntArray result(static_cast<unsigned>(v.size()));
  result.data = v;
  return result;
}

class Kdl : public testing::TestWithParam<Subject> {};

TEST_P(Kdl, AgreesOnTheTree) {
  const Subject& subject = GetParam();
  const Eigen::Vector3d gravity(1.2, -2.3, -9.0);
  const control::Mechanism mechanism(subject.tree, gravity);
  control::Workspace workspace(mechanism);
  const Unfolded all = unfold(subject, mechanism);
  const KDL::Tree tree = tree_of(subject.tree);
  ASSERT_EQ(static_cast<Eigen::Index>(tree.getNrOfJoints()), all.map.rows());
  KDL::TreeIdSolver_RNE with_gravity(tree, vector(gravity));
  KDL::TreeIdSolver_RNE without(tree, KDL::Vector::Zero());
  KDL::TreeFkSolverPos_recursive forward(tree);
  KDL::TreeJntToJacSolver jacobians(tree);
  const auto torque = [&](KDL::TreeIdSolver_RNE& solver, const VectorXd& q, const VectorXd& v,
                          const VectorXd& a, const KDL::WrenchMap& wrenches = {}) -> VectorXd {
    KDL::JntArray result(tree.getNrOfJoints());
    EXPECT_EQ(solver.CartToJnt(array(all.map * q + all.offset), array(all.map * v),
                               array(all.map * a), wrenches, result),
              0);
    return all.map.transpose() * result.data;
  };
  const int n = mechanism.dof();
  const VectorXd zero = VectorXd::Zero(n);
  control::testing::RandomArm random(1);
  for (int state = 0; state < 10; ++state) {
    SCOPED_TRACE("state " + std::to_string(state));
    const VectorXd q = random.vector(n, 3.0);
    const VectorXd v = random.vector(n, 2.0);
    const VectorXd a = random.vector(n, 2.0);
    expect_same(control::inverse_dynamics(mechanism, workspace, q, v, a),
                torque(with_gravity, q, v, a), kRounding, "inverse dynamics");
    expect_same(control::bias(mechanism, workspace, q, v), torque(with_gravity, q, v, zero),
                kRounding, "bias");
    expect_same(control::gravity(mechanism, workspace, q), torque(with_gravity, q, zero, zero),
                kRounding, "gravity");
    expect_same(control::coriolis_matrix(mechanism, workspace, q, v) * v,
                torque(without, q, v, zero), kRounding, "C v");
    const int pushed = 1 + state % (static_cast<int>(mechanism.links().size()) - 1);
    const control::Wrench push{random.vector(3, 20.0), random.vector(3, 5.0)};
    const control::ExternalWrench wrenches[] = {{pushed, control::Frame::kLink, push}};
    const KDL::WrenchMap pushes{{mechanism.links()[static_cast<std::size_t>(pushed)].name,
                                 KDL::Wrench(vector(push.force), vector(push.moment))}};
    expect_same(control::inverse_dynamics(mechanism, workspace, q, v, a, wrenches),
                torque(with_gravity, q, v, a, pushes), kRounding, "with an external wrench");
    MatrixXd mass(n, n);
    for (int k = 0; k < n; ++k) {
      mass.col(k) = torque(without, q, zero, VectorXd::Unit(n, k));
    }
    expect_same(control::metric(mechanism, workspace, q), mass, kRounding, "M");
    const KDL::JntArray everywhere = array(all.map * q + all.offset);
    for (int link = 1; link < static_cast<int>(mechanism.links().size()); link += 4) {
      const std::string& name = mechanism.links()[static_cast<std::size_t>(link)].name;
      KDL::Frame frame;
      ASSERT_EQ(forward.JntToCart(everywhere, frame, name), 0);
      const control::Pose pose = control::link_pose(mechanism, q, link);
      expect_same(pose.translation, Eigen::Map<const Eigen::Vector3d>(frame.p.data), kRounding,
                  "origin of a link");
      using RowMajor = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
      expect_same(pose.rotation, Eigen::Map<const RowMajor>(frame.M.data), kRounding,
                  "axes of a link");
      KDL::Jacobian jacobian(tree.getNrOfJoints());
      ASSERT_GE(jacobians.JntToJac(everywhere, jacobian, name), 0);
      expect_same(control::jacobian(mechanism, workspace, q, link), jacobian.data * all.map,
                  kRounding, "Jacobian of a link");
    }
  }
}

/// The link from whose root path no mass hangs off, if there is one: then KDL's chain is the robot.
std::string tip_of_a_chain(const control::TreeDescription& tree) {
  std::string tip = tree.root_link;
  std::map<std::string, int> joints_at;
  std::string at = tip;
  for (const control::JointDescription* joint : control::depth_first(tree)) {
    if (joint->mimic) {
      return "";
    }
    if (joint->kind == control::JointKind::kFixed) {
      continue;
    }
    if (joint->parent_link != at) {
      return "";
    }
    at = joint->child_link;
    tip = at;
  }
  for (const control::JointDescription& joint : tree.joints) {
    const bool massive = std::any_of(tree.links.begin(), tree.links.end(), [&](const auto& link) {
      return link.name == joint.child_link && link.inertia.mass_kg > 0.0;
    });
    if (joint.kind == control::JointKind::kFixed && massive) {
      return "";
    }
  }
  return tip;
}

class KdlChain : public testing::TestWithParam<Subject> {};

TEST_P(KdlChain, Agrees) {
  const Subject& subject = GetParam();
  const std::string tip = tip_of_a_chain(subject.tree);
  const control::Mechanism mechanism(subject.tree, {0.3, 0.4, -9.7});
  control::Workspace workspace(mechanism);
  KDL::Chain chain;
  ASSERT_TRUE(tree_of(subject.tree).getChain(subject.tree.root_link, tip, chain));
  KDL::ChainDynParam parameters(chain, vector(mechanism.gravity()));
  const int n = mechanism.dof();
  control::testing::RandomArm random(2);
  for (int state = 0; state < 10; ++state) {
    const VectorXd q = random.vector(n, 3.0);
    const VectorXd v = random.vector(n, 2.0);
    KDL::JntSpaceInertiaMatrix mass(n);
    KDL::JntArray coriolis(static_cast<unsigned>(n));
    KDL::JntArray gravity(static_cast<unsigned>(n));
    ASSERT_EQ(parameters.JntToMass(array(q), mass), 0);
    ASSERT_EQ(parameters.JntToCoriolis(array(q), array(v), coriolis), 0);
    ASSERT_EQ(parameters.JntToGravity(array(q), gravity), 0);
    expect_same(control::metric(mechanism, workspace, q), mass.data, kRounding, "M");
    expect_same(control::gravity(mechanism, workspace, q), gravity.data, kRounding, "gravity");
    expect_same(control::coriolis_matrix(mechanism, workspace, q, v) * v, coriolis.data, kRounding,
                "C v");
  }
}

std::vector<Subject> fixed_subjects() {
  std::vector<Subject> all = subjects();
  std::erase_if(all, [](const Subject& s) {
    return !control::Mechanism(s.tree, Eigen::Vector3d::Zero(), {s.base, {}}).one_chart();
  });
  return all;
}

std::vector<Subject> chains() {
  std::vector<Subject> all = fixed_subjects();
  std::erase_if(all, [](const Subject& s) { return tip_of_a_chain(s.tree).empty(); });
  return all;
}

INSTANTIATE_TEST_SUITE_P(Robots, Kdl, testing::ValuesIn(fixed_subjects()),
                         [](const auto& each) { return each.param.name; });
INSTANTIATE_TEST_SUITE_P(Robots, KdlChain, testing::ValuesIn(chains()),
                         [](const auto& each) { return each.param.name; });

}  // namespace
}  // namespace geodesic::cross
