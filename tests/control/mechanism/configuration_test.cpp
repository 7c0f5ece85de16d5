// The configuration space of whole mechanisms: steps and differences undo each other for joints of
// every kind, distances are distances, samples are uniform; and a planar, a spherical and a free
// joint move as the joints they could be assembled from.
#include "control/mechanism/configuration.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "control/mechanism/dynamics.hpp"
#include "rt/heap_counter.hpp"
#include "tests/control/mechanism/random_tree.hpp"

namespace geodesic::control {
namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using Eigen::VectorXd;
using testing::RandomArm;

constexpr double kPi = std::numbers::pi;

/// base - joint of that kind - stone - hinge - tail
TreeDescription one_joint(JointKind kind, RandomArm& random) {
  TreeDescription tree;
  tree.root_link = "base";
  tree.links = {{"base", {}}, {"stone", random.inertia()}, {"tail", random.inertia()}};
  JointDescription joint;
  joint.name = "joint";
  joint.kind = kind;
  joint.parent_link = "base";
  joint.child_link = "stone";
  joint.parent_from_joint = random.pose();
  joint.axis = Vector3d(random.vector(3)).normalized();
  JointDescription hinge = joint;
  hinge.name = "next";
  hinge.kind = JointKind::kContinuous;
  hinge.parent_link = "stone";
  hinge.child_link = "tail";
  hinge.parent_from_joint = random.pose();
  tree.joints = {joint, hinge};
  return tree;
}

/// Whether two lists of numbers are the same point of Q.
void expect_same_point(const Mechanism& m, const VectorXd& found, const VectorXd& expected,
                       double tolerance) {
  EXPECT_LE(distance(m, found, expected), tolerance);
  for (int link = 0; link < static_cast<int>(m.links().size()); ++link) {
    const Pose a = link_pose(m, found, link);
    const Pose b = link_pose(m, expected, link);
    EXPECT_LE((a.rotation - b.rotation).norm(), 8.0 * tolerance);
    EXPECT_LE((a.translation - b.translation).norm(), 8.0 * tolerance);
  }
}

constexpr JointKind kKinds[] = {JointKind::kRevolute, JointKind::kContinuous, JointKind::kPrismatic,
                                JointKind::kPlanar,   JointKind::kSpherical,  JointKind::kFloating};

TEST(Configuration, IntegrateAndDifferenceUndoEachOtherForEveryKind) {
  for (const JointKind kind : kKinds) {
    SCOPED_TRACE(kind_name(kind));
    RandomArm random(3);
    std::mt19937 engine(4);
    const Mechanism m(one_joint(kind, random), Vector3d::Zero());
    VectorXd v(m.dof());
    VectorXd found(m.nq());
    VectorXd again(m.dof());
    for (int i = 0; i < 200; ++i) {
      const VectorXd q0 = random_configuration(m, engine);
      const VectorXd q1 = random_configuration(m, engine);
      difference(m, q0, q1, v);
      integrate(m, q0, v, 1.0, found);
      expect_same_point(m, found, q1, 4e-15);
      // The other way round: steps of less than half a turn come back number by number.
      v = random.vector(m.dof(), std::pow(10.0, -i % 17) * 1.7);
      integrate(m, q0, v, 1.0, found);
      difference(m, q0, found, again);
      EXPECT_LE((again - v).norm(), 8e-15);
    }
  }
}

TEST(Configuration, HalfTurnsAndTurnedRoundQuaternions) {
  RandomArm random(5);
  const Mechanism m(one_joint(JointKind::kFloating, random), Vector3d::Zero());
  std::mt19937 engine(6);
  VectorXd v(m.dof());
  VectorXd found(m.nq());
  for (int i = 0; i < 100; ++i) {
    const VectorXd q0 = random_configuration(m, engine);
    v = random.vector(m.dof(), 1.0);
    v.segment<3>(3) *= (kPi - (i % 2 == 0 ? 0.0 : 1e-9)) / v.segment<3>(3).norm();
    VectorXd q1 = q0;
    integrate(m, q0, v, 1.0, q1);
    if (i % 3 == 0) {
      q1.segment<4>(3) *= -2.0;  // the same rotation, and not of unit length
    }
    difference(m, q0, q1, v);
    EXPECT_LE(v.segment<3>(3).norm(), kPi + 1e-15);
    integrate(m, q0, v, 1.0, found);
    expect_same_point(m, found, q1, 8e-15);
  }
}

TEST(Configuration, WholeMechanismsOfEveryKind) {
  for (unsigned seed = 0; seed < 48; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Mechanism m = testing::random_mechanism(seed);
    std::mt19937 engine(seed);
    const VectorXd q0 = random_configuration(m, engine);
    const VectorXd q1 = random_configuration(m, engine);
    VectorXd v(m.dof());
    VectorXd found(m.nq());
    VectorXd part(m.dof());
    const std::uint64_t heap = rt::heap_calls();
    difference(m, q0, q1, v);
    integrate(m, q0, v, 1.0, found);
    const double rest = distance(m, found, q1);
    interpolate(m, q0, q1, 0.25, found);
    difference(m, q0, found, part);
    normalise(m, found);
    EXPECT_EQ(rt::heap_calls(), heap);
    EXPECT_LE(rest, 2e-14);
    EXPECT_LE((part - 0.25 * v).norm(), 1e-13);
    EXPECT_LE((neutral(m) -
               [&] {
                 VectorXd q = neutral(m);
                 integrate(m, q, VectorXd::Zero(m.dof()), 1.0, q);
                 return q;
               }())
                  .norm(),
              0.0);
  }
}

TEST(Configuration, JointsWithLimitsGoThroughAllAnglesContinuousOnesTheShorterWay) {
  RandomArm random(9);
  TreeDescription tree = one_joint(JointKind::kRevolute, random);
  tree.joints[0].lower = -3.0;
  tree.joints[0].upper = 3.0;
  const Mechanism m(tree, Vector3d::Zero());  // "next" is continuous
  VectorXd v(2);
  difference(m, Eigen::Vector2d(-3.0, -3.0), Eigen::Vector2d(3.0, 3.0), v);
  EXPECT_EQ(v[0], 6.0);
  EXPECT_NEAR(v[1], 6.0 - 2.0 * kPi, 1e-15);
  EXPECT_NEAR(distance(m, Eigen::Vector2d(-3.0, -3.0), Eigen::Vector2d(3.0, 3.0), 0.5),
              0.5 * std::hypot(6.0, 6.0 - 2.0 * kPi), 1e-14);
  VectorXd q = Eigen::Vector2d(2.5, 10.0 * kPi + 0.25);
  normalise(m, q);
  EXPECT_EQ(q[0], 2.5);
  EXPECT_NEAR(q[1], 0.25, 1e-14);
}

TEST(Configuration, NormaliseKeepsThePointAndMakesUnitQuaternions) {
  RandomArm random(10);
  const Mechanism m(one_joint(JointKind::kSpherical, random), Vector3d::Zero());
  std::mt19937 engine(11);
  VectorXd q = random_configuration(m, engine);
  const VectorXd before = q;
  q.head<4>() *= -1e-200;
  normalise(m, q);
  EXPECT_NEAR(q.head<4>().norm(), 1.0, 1e-15);
  EXPECT_GE(q[3], 0.0);
  expect_same_point(m, q, before, 4e-15);
  q.head<4>().setZero();
  normalise(m, q);
  EXPECT_EQ(VectorXd(q.head<4>()), VectorXd(Eigen::Vector4d(0.0, 0.0, 0.0, 1.0)));
}

TEST(Configuration, SamplesKeepLimitsAndFillThem) {
  RandomArm random(12);
  TreeDescription tree = one_joint(JointKind::kPrismatic, random);
  tree.joints[0].lower = 0.2;
  tree.joints[0].upper = 0.3;
  const Mechanism m(tree, Vector3d::Zero(), {Base::kFloating, {}});
  std::mt19937 engine(13);
  double lowest = 1.0;
  double highest = 0.0;
  double mean = 0.0;
  constexpr int kSamples = 2000;
  for (int i = 0; i < kSamples; ++i) {
    const VectorXd q = random_configuration(m, engine);
    EXPECT_NEAR(q.segment<4>(3).norm(), 1.0, 1e-14);
    lowest = std::min(lowest, q[7]);
    highest = std::max(highest, q[7]);
    mean += q[7] / kSamples;
    EXPECT_LE(std::abs(q[8]), kPi);
  }
  EXPECT_GE(lowest, 0.2);
  EXPECT_LE(highest, 0.3);
  EXPECT_NEAR(mean, 0.25, 4.0 * 0.1 / std::sqrt(12.0 * kSamples));
}

/// A planar joint is x, y and the angle about the normal, each along the axes of in_plane(axis).
TEST(Configuration, APlanarJointMovesInItsPlane) {
  for (unsigned seed = 0; seed < 10; ++seed) {
    RandomArm random(seed);
    const TreeDescription tree = one_joint(JointKind::kPlanar, random);
    const Mechanism m(tree, Vector3d(0.0, 0.0, -9.81));
    const JointDescription& joint = tree.joints[0];
    VectorXd q = random.vector(4, 1.5);
    const Matrix3d axes = in_plane(joint.axis);
    const Pose base{joint.parent_from_joint.linear(), joint.parent_from_joint.translation()};
    const Pose expected =
        base * Pose{exp(Vector3d(q[2] * joint.axis)), axes.col(0) * q[0] + axes.col(1) * q[1]};
    const Pose found = link_pose(m, q, *m.find_link("stone"));
    EXPECT_LE((found.rotation - expected.rotation).norm(), 4e-15);
    EXPECT_LE((found.translation - expected.translation).norm(), 4e-15);
    EXPECT_LE((axes.transpose() * axes - Matrix3d::Identity()).norm(), 1e-15);
    EXPECT_LE((axes.col(2) - joint.axis).norm(), 1e-15);
  }
}

/// A free joint and a spherical one with a base that stands still carry the same arm as three and
/// six one-dof joints do: same poses, same energy, same generalised force after a change of basis.
TEST(Configuration, FreeJointsCarryAsTheirOneDegreeJointsDo) {
  for (const JointKind kind : {JointKind::kSpherical, JointKind::kFloating}) {
    RandomArm random(21);
    const TreeDescription tree = one_joint(kind, random);
    TreeDescription chain;
    chain.root_link = "base";
    chain.links = {{"base", {}}};
    const auto add = [&chain](const std::string& name, JointKind of, const Vector3d& axis,
                              const Eigen::Isometry3d& at) {
      JointDescription joint;
      joint.name = name;
      joint.kind = of;
      joint.parent_link = chain.links.back().name;
      joint.child_link = "after " + name;
      joint.axis = axis;
      joint.parent_from_joint = at;
      chain.links.push_back({joint.child_link, {}});
      chain.joints.push_back(joint);
    };
    Eigen::Isometry3d at = tree.joints[0].parent_from_joint;
    const int slides = kind == JointKind::kFloating ? 3 : 0;
    for (int i = 0; i < slides; ++i) {
      add("slide" + std::to_string(i), JointKind::kPrismatic, Vector3d::Unit(i), at);
      at.setIdentity();
    }
    for (int i = 0; i < 3; ++i) {
      add("turn" + std::to_string(i), JointKind::kContinuous, Vector3d::Unit(i), at);
      at.setIdentity();
    }
    chain.links.back().inertia = tree.links[1].inertia;
    add("next", JointKind::kContinuous, tree.joints[1].axis, tree.joints[1].parent_from_joint);
    chain.links.back().inertia = tree.links[2].inertia;

    const Vector3d down(0.4, -1.0, -9.7);
    const Mechanism one(tree, down);
    const Mechanism many(chain, down);
    Workspace w_one(one), w_many(many);
    const VectorXd q_many = random.vector(many.nq(), 1.2);
    const VectorXd v_many = random.vector(many.dof(), 2.0);
    const VectorXd a_many = random.vector(many.dof(), 3.0);
    // q and v of the one joint from those of the many; G maps rates, v = G dq.
    const auto point = [&](const VectorXd& q) {
      VectorXd result(one.nq());
      const Quaterniond turn = quaternion_exp(Vector3d(q[slides], 0.0, 0.0)) *
                               quaternion_exp(Vector3d(0.0, q[slides + 1], 0.0)) *
                               quaternion_exp(Vector3d(0.0, 0.0, q[slides + 2]));
      result.head(slides) = q.head(slides);
      result.segment<4>(slides) = turn.coeffs();
      result[slides + 4] = q[slides + 3];
      return result;
    };
    const auto map = [&](const VectorXd& q) {
      Eigen::MatrixXd g = Eigen::MatrixXd::Zero(one.dof(), many.dof());
      const Matrix3d third = exp(Vector3d(0.0, 0.0, q[slides + 2]));
      const Matrix3d second = exp(Vector3d(0.0, q[slides + 1], 0.0)) * third;
      const Matrix3d first = exp(Vector3d(q[slides], 0.0, 0.0)) * second;
      if (slides > 0) {
        g.topLeftCorner<3, 3>() = first.transpose();
      }
      g.block<3, 1>(slides, slides) = second.transpose().col(0);
      g.block<3, 1>(slides, slides + 1) = third.transpose().col(1);
      g(slides + 2, slides + 2) = 1.0;
      g(slides + 3, slides + 3) = 1.0;
      return g;
    };
    constexpr double kStep = 1e-5;
    const Eigen::MatrixXd g = map(q_many);
    const Eigen::MatrixXd g_rate =
        (map(q_many + kStep * v_many) - map(q_many - kStep * v_many)) / (2.0 * kStep);
    const VectorXd q = point(q_many);
    const VectorXd v = g * v_many;
    const VectorXd a = g * a_many + g_rate * v_many;
    const int tail = *one.find_link("tail");
    const int tail_of_many = static_cast<int>(many.links().size()) - 1;
    EXPECT_LE(
        (link_pose(one, q, tail).rotation - link_pose(many, q_many, tail_of_many).rotation).norm(),
        1e-14);
    EXPECT_LE(
        (link_pose(one, q, tail).translation - link_pose(many, q_many, tail_of_many).translation)
            .norm(),
        1e-14);
    EXPECT_NEAR(kinetic_energy(one, w_one, q, v), kinetic_energy(many, w_many, q_many, v_many),
                1e-13);
    EXPECT_LE(
        (jacobian(one, w_one, q, tail) * g - jacobian(many, w_many, q_many, tail_of_many)).norm(),
        1e-13);
    const VectorXd weight = g.transpose() * gravity(one, w_one, q);
    EXPECT_LE((weight - gravity(many, w_many, q_many)).norm(), 1e-13 * (1.0 + weight.norm()));
    const Eigen::MatrixXd m = g.transpose() * metric(one, w_one, q) * g;
    EXPECT_LE((m - metric(many, w_many, q_many)).norm(), 1e-13 * (1.0 + m.norm()));
    const VectorXd tau = g.transpose() * inverse_dynamics(one, w_one, q, v, a);
    EXPECT_LE((tau - inverse_dynamics(many, w_many, q_many, v_many, a_many)).norm(),
              1e-8 * (1.0 + tau.norm()))
        << "the rate of G is a finite difference";
  }
}

}  // namespace
}  // namespace geodesic::control
