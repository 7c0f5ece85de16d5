// Rotations, rigid motions, wrenches and inertias against independent formulas.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "control/geometry/se3.hpp"
#include "control/geometry/so3.hpp"
#include "control/geometry/spatial.hpp"

namespace geodesic::control {
namespace {

using Eigen::Matrix3d;
using Eigen::Matrix4d;
using Eigen::Vector3d;

Pose some_pose() {
  return {exp(Vector3d(0.3, -1.1, 0.7)), Vector3d(0.2, -0.5, 1.3)};
}
Twist some_twist() {
  return {Vector3d(0.4, 1.2, -0.3), Vector3d(-0.8, 0.1, 0.9)};
}
Wrench some_wrench() {
  return {Vector3d(3.0, -1.0, 2.0), Vector3d(0.5, 0.7, -0.2)};
}

RigidInertia some_body() {
  RigidInertia body;
  body.mass = 2.0;
  body.first_moment = 2.0 * Vector3d(0.1, -0.2, 0.3);
  body.rotational = Vector3d(0.5, 0.6, 0.7).asDiagonal();
  body.rotational(0, 1) = body.rotational(1, 0) = 0.05;
  return body;
}

/// exp of a 4 x 4 matrix by its power series: right for small norms, slow, independent.
Matrix4d series_exp(const Twist& twist) {
  Matrix4d x = Matrix4d::Zero();
  x.topLeftCorner<3, 3>() = hat(twist.angular);
  x.topRightCorner<3, 1>() = twist.linear;
  Matrix4d sum = Matrix4d::Identity();
  Matrix4d term = Matrix4d::Identity();
  for (int k = 1; k < 60; ++k) {
    term = term * x / static_cast<double>(k);
    sum += term;
  }
  return sum;
}

void expect_near(const Twist& a, const Twist& b, double tolerance = 1e-14) {
  EXPECT_LE((a.linear - b.linear).norm(), tolerance);
  EXPECT_LE((a.angular - b.angular).norm(), tolerance);
}

void expect_near(const Wrench& a, const Wrench& b, double tolerance = 1e-14) {
  EXPECT_LE((a.force - b.force).norm(), tolerance);
  EXPECT_LE((a.moment - b.moment).norm(), tolerance);
}

TEST(GeometryRotation, HatIsTheCrossProductAndVeeItsInverse) {
  const Vector3d w(1.0, -2.0, 3.0);
  const Vector3d x(0.3, 0.2, -0.7);
  EXPECT_TRUE((hat(w) * x).isApprox(w.cross(x), 1e-15));
  EXPECT_EQ(vee(hat(w)), w);
}

TEST(GeometryRotation, ExpAgreesWithAxisAngleAtEveryScale) {
  const Vector3d axis = Vector3d(0.2, -0.5, 0.7).normalized();
  for (const double angle : {1e-300, 1e-160, 1e-12, 1e-8, 1e-4, 0.1, 1.0, 3.0, M_PI, 6.0}) {
    const Matrix3d r = exp(angle * axis);
    EXPECT_LE((r - Eigen::AngleAxisd(angle, axis).toRotationMatrix()).norm(), 2e-15) << angle;
    // What is above the identity keeps its relative accuracy.
    EXPECT_LE((vee(r) - std::sin(angle) * axis).norm(), 4e-16 * std::max(angle, 1e-300)) << angle;
  }
  EXPECT_EQ(exp(Vector3d::Zero().eval()), Matrix3d::Identity());
}

TEST(GeometryRigidMotion, ExpAgreesWithThePowerSeries) {
  for (const double scale : {0.0, 1e-9, 1e-3, 0.5, 0.828, 0.83, 1.0, 2.0}) {
    const Twist twist = scale * some_twist();
    const Pose pose = exp(twist);
    const Matrix4d expected = series_exp(twist);
    EXPECT_LE((pose.rotation - expected.topLeftCorner<3, 3>()).norm(), 1e-14) << scale;
    EXPECT_LE((pose.translation - expected.topRightCorner<3, 1>()).norm(), 1e-14) << scale;
  }
}

TEST(GeometryRigidMotion, InverseUndoes) {
  const Pose identity = some_pose() * inverse(some_pose());
  EXPECT_TRUE(identity.rotation.isIdentity(1e-15));
  EXPECT_LE(identity.translation.norm(), 1e-15);
}

TEST(GeometrySpatial, ATwistIsTheVelocityOfEveryPointOfTheBody) {
  // The point at the child's origin moves the same, seen from either frame.
  const Pose pose = some_pose();
  const Twist in_child = to_child(pose, some_twist());
  const Vector3d expected = some_twist().linear + some_twist().angular.cross(pose.translation);
  EXPECT_LE((pose.rotation * in_child.linear - expected).norm(), 1e-14);
}

TEST(GeometrySpatial, PowerDoesNotDependOnTheFrame) {
  const Pose pose = some_pose();
  EXPECT_NEAR(dot(some_wrench(), to_child(pose, some_twist())),
              dot(to_parent(pose, some_wrench()), some_twist()), 1e-13);
}

TEST(GeometrySpatial, TheBracketsAreDualAndCommuteWithPoses) {
  const Twist u = some_twist();
  const Twist w{Vector3d(0.1, 0.2, 0.3), Vector3d(0.6, -0.5, 0.4)};
  const Pose pose = some_pose();
  EXPECT_NEAR(dot(cross(u, some_wrench()), w), -dot(some_wrench(), cross(u, w)), 1e-14);
  expect_near(to_child(pose, cross(u, w)), cross(to_child(pose, u), to_child(pose, w)));
}

TEST(GeometrySpatial, InertiaTransformsAsMomentumDoes) {
  const Pose pose = some_pose();
  const Wrench carried = to_parent(pose, some_body() * to_child(pose, some_twist()));
  expect_near(to_parent(pose, some_body()) * some_twist(), carried, 1e-13);
}

TEST(GeometrySpatial, InertiaOfPointsIsTheirSum) {
  // Two particles, about the origin of a shifted and turned frame.
  const Pose pose = some_pose();
  RigidInertia sum;
  RigidInertia expected;
  for (const Vector3d& x : {Vector3d(0.3, 0.1, -0.2), Vector3d(-0.4, 0.5, 0.6)}) {
    const auto particle = [](const Vector3d& at) {
      RigidInertia body;
      body.mass = 0.7;
      body.first_moment = 0.7 * at;
      body.rotational = -0.7 * hat(at) * hat(at);
      return body;
    };
    sum += particle(x);
    expected += particle(pose.rotation * x + pose.translation);
  }
  const RigidInertia moved = to_parent(pose, sum);
  EXPECT_NEAR(moved.mass, expected.mass, 1e-15);
  EXPECT_LE((moved.first_moment - expected.first_moment).norm(), 1e-14);
  EXPECT_LE((moved.rotational - expected.rotational).norm(), 1e-14);
}

}  // namespace
}  // namespace geodesic::control
