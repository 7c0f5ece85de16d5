// Mechanisms whose equations fit on a line: the planar arm of the textbooks, mimic joints as a
// linear map, rotor inertia, a mechanism without mass at its tip.
#include <gtest/gtest.h>

#include <cmath>

#include "control/mechanism/dynamics.hpp"
#include "tests/control/mechanism/random_tree.hpp"

namespace geodesic::control {
namespace {

using Eigen::Matrix2d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kM1 = 1.3, kM2 = 0.9, kL1 = 0.5, kL2 = 0.4, kG = 9.81;

TreeDescription planar() {
  TreeDescription tree;
  tree.root_link = "base";
  const auto rod = [](double mass, double length) {
    const double i = mass * length * length / 12.0;
    return LinkInertia{mass, Vector3d(0.5 * length, 0.0, 0.0), Vector3d(0.0, i, i).asDiagonal()};
  };
  tree.links = {{"base", {}}, {"upper", rod(kM1, kL1)}, {"fore", rod(kM2, kL2)}};
  JointDescription shoulder;
  shoulder.name = "shoulder";
  shoulder.kind = JointKind::kRevolute;
  shoulder.parent_link = "base";
  shoulder.child_link = "upper";
  shoulder.axis = Vector3d::UnitZ();
  JointDescription elbow = shoulder;
  elbow.name = "elbow";
  elbow.parent_link = "upper";
  elbow.child_link = "fore";
  elbow.parent_from_joint.translation().x() = kL1;
  tree.joints = {elbow, shoulder};
  return tree;
}

TEST(MechanismClosedForm, PlanarArmOfTheTextbooks) {
  const Mechanism arm(planar(), Vector3d(0.0, -kG, 0.0));
  Workspace workspace(arm);
  const Vector2d q(0.7, -1.9);
  const Vector2d v(1.1, 0.6);
  const double half1 = 0.5 * kL1, half2 = 0.5 * kL2;
  const double i1 = kM1 * kL1 * kL1 / 12.0, i2 = kM2 * kL2 * kL2 / 12.0;
  const double coupling = kM2 * kL1 * half2;
  const double c2 = std::cos(q[1]), s2 = std::sin(q[1]);
  Matrix2d m;
  m(1, 1) = i2 + kM2 * half2 * half2;
  m(0, 1) = m(1, 0) = m(1, 1) + coupling * c2;
  m(0, 0) = i1 + kM1 * half1 * half1 + m(1, 1) + kM2 * kL1 * kL1 + 2.0 * coupling * c2;
  Matrix2d c;
  c << -coupling * s2 * v[1], -coupling * s2 * (v[0] + v[1]), coupling * s2 * v[0], 0.0;
  const double fore = kM2 * half2 * kG * std::cos(q[0] + q[1]);
  const Vector2d g((kM1 * half1 + kM2 * kL1) * kG * std::cos(q[0]) + fore, fore);
  EXPECT_LE((metric(arm, workspace, q) - m).norm(), 1e-15);
  EXPECT_LE((coriolis_matrix(arm, workspace, q, v) - c).norm(), 1e-15);
  EXPECT_LE((gravity(arm, workspace, q) - g).norm(), 1e-14);
  EXPECT_LE((bias(arm, workspace, q, v) - c * v - g).norm(), 1e-14);
}

TEST(MechanismClosedForm, RotorInertiaIsFeltAsMassOnTheDiagonal) {
  MechanismOptions options;
  options.rotor_inertia = Vector2d(0.3, 0.05);
  const Mechanism bare(planar(), Vector3d(0.0, -kG, 0.0));
  const Mechanism driven(planar(), Vector3d(0.0, -kG, 0.0), options);
  Workspace workspace(bare);
  const Vector2d q(0.7, -1.9), v(1.1, 0.6), a(2.0, -3.0);
  const Vector2d extra = options.rotor_inertia.cwiseProduct(a);
  const VectorXd tau = inverse_dynamics(bare, workspace, q, v, a);
  EXPECT_LE((inverse_dynamics(driven, workspace, q, v, a) - tau - extra).norm(), 1e-15);
  const MatrixXd m = metric(bare, workspace, q);
  EXPECT_LE((MatrixXd(metric(driven, workspace, q) - m).diagonal() - options.rotor_inertia).norm(),
            1e-15);
  const VectorXd carried = bias(bare, workspace, q, v);
  EXPECT_EQ(bias(driven, workspace, q, v), carried);
}

/// A mimic joint restricts the free tree to q = G r + c; everything follows from the free tree.
TEST(MechanismClosedForm, MimicJointsAreALinearMapOfTheFreeTree) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    testing::RandomArm random(seed);
    testing::RandomTreeOptions shape;
    shape.joints = 6;
    shape.mimic_joints = 5;
    const TreeDescription coupled_tree = random.tree(shape);
    TreeDescription free_tree = coupled_tree;
    for (auto& joint : free_tree.joints) joint.mimic.reset();
    MechanismOptions options;
    options.base = seed % 2 == 0 ? Base::kFixed : Base::kFloating;
    const Vector3d down(1.0, 2.0, -9.0);
    const Mechanism coupled(coupled_tree, down, options);
    const Mechanism loose(free_tree, down, options);
    const int base = coupled.first_joint_v();
    MatrixXd map = MatrixXd::Zero(loose.dof(), coupled.dof());
    VectorXd offset = VectorXd::Zero(loose.dof());
    map.topLeftCorner(base, base).setIdentity();
    for (const auto& joint : coupled_tree.joints) {
      const auto row = loose.find_joint(joint.name);
      if (!row) continue;
      const auto column = coupled.find_joint(joint.mimic ? joint.mimic->joint : joint.name);
      map(base + *row, base + *column) = joint.mimic ? joint.mimic->multiplier : 1.0;
      offset[base + *row] = joint.mimic ? joint.mimic->offset : 0.0;
    }
    const VectorXd q = random.configuration(coupled);
    const VectorXd v = random.vector(coupled.dof());
    const int q0 = coupled.first_joint_q();
    VectorXd q_free(loose.nq());
    q_free.head(q0) = q.head(q0);
    q_free.tail(loose.nq() - q0) = map.bottomRightCorner(loose.dof() - base, coupled.dof() - base) *
                                       q.tail(coupled.nq() - q0) +
                                   offset.tail(loose.dof() - base);
    const VectorXd v_free = map * v;
    Workspace w(coupled), w_free(loose);
    const MatrixXd m = map.transpose() * metric(loose, w_free, q_free) * map;
    const MatrixXd c = map.transpose() * coriolis_matrix(loose, w_free, q_free, v_free) * map;
    const VectorXd b = map.transpose() * bias(loose, w_free, q_free, v_free);
    const int tip = static_cast<int>(coupled.links().size()) - 1;
    EXPECT_LE((metric(coupled, w, q) - m).norm(), 1e-13 * (1.0 + m.norm()));
    EXPECT_LE((coriolis_matrix(coupled, w, q, v) - c).norm(), 1e-12 * (1.0 + c.norm()));
    EXPECT_LE((bias(coupled, w, q, v) - b).norm(), 1e-12 * (1.0 + b.norm()));
    const MatrixXd j = jacobian(loose, w_free, q_free, tip) * map;
    EXPECT_LE((jacobian(coupled, w, q, tip) - j).norm(), 1e-13 * (1.0 + j.norm()));
  }
}

TEST(MechanismClosedForm, AMasslessTipIsAllowedAndForwardDynamicsSaysSo) {
  TreeDescription tree = planar();
  tree.links[2].inertia = {};
  const Mechanism arm(tree, Vector3d(0.0, -kG, 0.0));
  Workspace workspace(arm);
  const Vector2d q(0.7, -1.9), v(1.1, 0.6), tau(1.0, 0.0);
  EXPECT_EQ(forward_dynamics(arm, workspace, q, v, tau), nullptr);
  EXPECT_EQ(metric_inverse(arm, workspace, q), nullptr);
  EXPECT_TRUE(bias(arm, workspace, q, v).allFinite());
}

TEST(MechanismClosedForm, WhatIsFixedToTheWorldCountsInNoEnergy) {
  TreeDescription tree = planar();
  tree.links[0].inertia = tree.links[1].inertia;
  const Mechanism heavy(tree, Vector3d(0.0, -kG, 0.0));
  const Mechanism light(planar(), Vector3d(0.0, -kG, 0.0));
  Workspace workspace(heavy);
  const Vector2d q(0.7, -1.9);
  const double energy = potential_energy(light, workspace, q);
  EXPECT_EQ(potential_energy(heavy, workspace, q), energy);
  EXPECT_EQ(heavy.moving_mass(), light.moving_mass());
}

TEST(MechanismClosedForm, AFreeBodyTumblesByEuler) {
  TreeDescription tree;
  tree.root_link = "stone";
  const Vector3d moments(0.1, 0.2, 0.25);
  tree.links = {{"stone", {2.0, Vector3d::Zero(), moments.asDiagonal()}}};
  MechanismOptions options;
  options.base = Base::kFloating;
  const Mechanism stone(tree, Vector3d(0.0, 0.0, -kG), options);
  ASSERT_EQ(stone.dof(), 6);
  ASSERT_EQ(stone.nq(), 7);
  Workspace workspace(stone);
  VectorXd v = VectorXd::Zero(6);
  const Vector3d w(0.3, -0.4, 2.0);
  v.tail<3>() = w;
  const VectorXd* a = forward_dynamics(stone, workspace, neutral(stone), v, VectorXd::Zero(6));
  ASSERT_NE(a, nullptr);
  const Vector3d torque = -w.cross(moments.cwiseProduct(w));
  EXPECT_LE((a->tail<3>() - torque.cwiseQuotient(moments)).norm(), 1e-14);
  EXPECT_LE((a->head<3>() - Vector3d(0.0, 0.0, -kG)).norm(), 1e-14);
}

TEST(MechanismClosedForm, AStepAlongAVelocityIsTheFlowOfItsTwist) {
  testing::RandomArm random(3);
  MechanismOptions options;
  options.base = Base::kFloating;
  const Mechanism arm(planar(), Vector3d(0.0, -kG, 0.0), options);
  const VectorXd q = random.configuration(arm);
  const VectorXd v = random.vector(arm.dof(), 2.0);
  VectorXd once(arm.nq()), twice(arm.nq());
  integrate(arm, q, v, 0.8, once);
  integrate(arm, q, v, 0.3, twice);
  integrate(arm, twice, v, 0.5, twice);
  EXPECT_LE((once - twice).norm(), 1e-14);
  const Pose flow = link_pose(arm, q, 0) * exp(0.8 * Twist{v.head<3>(), v.segment<3>(3)});
  EXPECT_LE((link_pose(arm, once, 0).rotation - flow.rotation).norm(), 1e-14);
  EXPECT_LE((link_pose(arm, once, 0).translation - flow.translation).norm(), 1e-14);
  EXPECT_LE((once.tail<2>() - q.tail<2>() - 0.8 * v.tail<2>()).norm(), 1e-15);
}

}  // namespace
}  // namespace geodesic::control
