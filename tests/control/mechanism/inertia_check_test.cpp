// Inertias that bodies can and cannot have, and the nearest possible ones.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <limits>
#include <string>

#include "control/geometry/so3.hpp"
#include "control/mechanism/inertia_check.hpp"
#include "tests/control/mechanism/random_tree.hpp"

namespace geodesic::control {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

LinkInertia body(const Vector3d& principal) {
  const Matrix3d turn = exp(Vector3d(0.4, -0.9, 1.3));
  const Matrix3d i = turn * principal.asDiagonal() * turn.transpose();
  return {0.5, Vector3d(0.1, 0.2, 0.3), 0.5 * (i + i.transpose())};
}

/// [[S, h], [h', m]] about the link's origin, S the second moments: the pseudo-inertia.
double smallest_pseudo_eigenvalue(const LinkInertia& inertia) {
  const Matrix3d& i = inertia.inertia_kg_m2;
  const Vector3d h = inertia.mass_kg * inertia.com_m;
  Eigen::Matrix4d pseudo;
  pseudo.topLeftCorner<3, 3>() =
      0.5 * i.trace() * Matrix3d::Identity() - i + h * inertia.com_m.transpose();
  pseudo.topRightCorner<3, 1>() = h;
  pseudo.bottomLeftCorner<1, 3>() = h.transpose();
  pseudo(3, 3) = inertia.mass_kg;
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d>(pseudo).eigenvalues().minCoeff();
}

TEST(InertiaCheck, BodiesRodsPlatesPointsAndFramesPass) {
  for (const Vector3d& principal : {Vector3d(1.0, 1.5, 2.0), Vector3d(0.0, 1.0, 1.0),
                                    Vector3d(1.0, 1.0, 2.0), Vector3d(0.0, 0.0, 0.0)}) {
    const LinkInertia inertia = body(1e-3 * principal);
    const InertiaVerdict verdict = check_inertia(inertia);
    EXPECT_TRUE(verdict.physical) << verdict.reason;
    EXPECT_STREQ(verdict.reason, "");
    EXPECT_LE((verdict.principal - 1e-3 * principal).norm(), 1e-17);
    EXPECT_EQ(verdict.nearest.inertia_kg_m2, inertia.inertia_kg_m2);
  }
  EXPECT_TRUE(check_inertia(LinkInertia{}).physical);
}

TEST(InertiaCheck, TheFingersOfAPublishedHand) {
  LinkInertia finger;
  finger.mass_kg = 0.03602545343277134;
  finger.inertia_kg_m2 << 2.375e-6, 1e-6, 1e-6, 1e-6, 2.375e-6, 1e-6, 1e-6, 1e-6, 7.5e-7;
  const InertiaVerdict verdict = check_inertia(finger);
  EXPECT_FALSE(verdict.physical);
  EXPECT_NE(std::string(verdict.reason).find("triangle"), std::string::npos);
  EXPECT_LT(verdict.principal[0] + verdict.principal[1], verdict.principal[2]);
  EXPECT_TRUE(check_inertia(verdict.nearest).physical);
  EXPECT_EQ(verdict.nearest.mass_kg, finger.mass_kg);
}

TEST(InertiaCheck, WhatIsWrongIsSaid) {
  const auto reason = [](const LinkInertia& inertia) {
    const InertiaVerdict verdict = check_inertia(inertia);
    EXPECT_FALSE(verdict.physical);
    EXPECT_TRUE(check_inertia(verdict.nearest).physical);
    return std::string(verdict.reason);
  };
  LinkInertia inertia = body(Vector3d(1.0, 1.5, 2.0));
  inertia.mass_kg = -1.0;
  EXPECT_EQ(reason(inertia), "the mass is negative");
  inertia.mass_kg = 0.0;
  EXPECT_EQ(reason(inertia), "there is inertia without mass");
  inertia.mass_kg = std::numeric_limits<double>::infinity();
  EXPECT_EQ(reason(inertia), "a number is not finite");
  inertia = body(Vector3d(1.0, 1.5, 2.0));
  inertia.inertia_kg_m2(0, 1) += 0.1;
  EXPECT_EQ(reason(inertia), "the inertia matrix is not symmetric");
  EXPECT_EQ(reason(body(Vector3d(-0.1, 1.0, 1.0))), "a principal moment of inertia is negative");
}

TEST(InertiaCheck, NearestIsPhysicalAndNoSampleIsNearer) {
  testing::RandomArm random(7);
  for (int i = 0; i < 200; ++i) {
    const LinkInertia found = body(Vector3d(random.vector(3)));
    const LinkInertia nearest = nearest_physical_inertia(found);
    EXPECT_GE(smallest_pseudo_eigenvalue(nearest), -1e-12);
    EXPECT_TRUE(check_inertia(nearest).physical);
    const double distance = (nearest.inertia_kg_m2 - found.inertia_kg_m2).norm();
    for (int k = 0; k < 50; ++k) {
      // A physical inertia near the answer: second moments that are not negative, any axes.
      const Matrix3d step = exp(Vector3d(random.vector(3, 0.1)));
      const Matrix3d second_moments =
          0.5 * nearest.inertia_kg_m2.trace() * Matrix3d::Identity() - nearest.inertia_kg_m2;
      const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(second_moments);
      const Vector3d sample =
          (solver.eigenvalues() + Vector3d(random.vector(3, 0.1))).cwiseMax(0.0);
      const Matrix3d axes = step * solver.eigenvectors();
      const Matrix3d other =
          sample.sum() * Matrix3d::Identity() - axes * sample.asDiagonal() * axes.transpose();
      EXPECT_GE((other - found.inertia_kg_m2).norm(), distance - 1e-12);
    }
  }
}

}  // namespace
}  // namespace geodesic::control
