// The tree's results from its Lagrangian alone: every quantity of a mechanism against automatic
// differentiation of T - V of the same description; and a model beside the tree, its joints
// elastic.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "control/geometry/lagrangian.hpp"
#include "control/mechanism/dynamics.hpp"
#include "tests/control/geometry/templated_tree.hpp"
#include "tests/control/mechanism/random_tree.hpp"
#include "tests/control/mechanism/urdf_for_tests.hpp"

namespace geodesic::control {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kTolerance = 1e-12;  // asked is 1e-10

void expect_near(const MatrixXd& ours, const MatrixXd& tree, const char* what) {
  EXPECT_LE((ours - tree).cwiseAbs().maxCoeff(),
            kTolerance * std::max(1.0, tree.cwiseAbs().maxCoeff()))
      << what;
}

template <int N>
void compare(const TreeDescription& description, const Vector3d& gravity_vector, unsigned seed,
             int states) {
  const Mechanism tree(description, gravity_vector);
  ASSERT_EQ(tree.dof(), N);
  Workspace w(tree);
  const auto own = lagrangian<N>(testing::TemplatedTree(description, gravity_vector));
  testing::RandomArm random(seed);
  for (int state = 0; state < states; ++state) {
    const ChartVector<N> q = random.vector(N, 3.0), v = random.vector(N, 2.0), a = random.vector(N);
    expect_near(own.metric(q), metric(tree, w, q), "M");
    expect_near(own.coriolis_matrix(q, v), coriolis_matrix(tree, w, q, v), "C");
    expect_near(own.potential_differential(q), gravity(tree, w, q), "g");
    expect_near(own.coriolis(q, v) + own.potential_differential(q), bias(tree, w, q, v), "bias");
    const VectorXd tau = inverse_dynamics(tree, w, q, v, a);
    expect_near(own.euler_lagrange(q, v, a), tau, "tau");
    const double stiff = 1e3;  // small inertias: an acceleration is known less well than a torque
    expect_near(*own.forward_dynamics(q, v, tau) / stiff, a / stiff, "forward dynamics");
    EXPECT_NEAR(own.kinetic_energy(q, v), kinetic_energy(tree, w, q, v), 1e-12);
    EXPECT_NEAR(own.potential_energy(q), potential_energy(tree, w, q), 1e-12);
    Christoffel symbols(tree);
    christoffel_symbols(tree, w, q, symbols);
    const auto first = own.christoffel_first_kind(q);
    for (int i = 0; i < N; ++i) {
      for (int j = 0; j < N; ++j) {
        for (int k = 0; k < N; ++k) {
          EXPECT_NEAR(first(i, j, k), symbols(i, j, k), kTolerance) << i << j << k;
        }
      }
    }
  }
}

TreeDescription oracle(const char* urdf) {
  return testing::read_urdf(std::filesystem::path(GEODESIC_TEST_DATA) / "oracles" / urdf);
}

TEST(LagrangianTree, Planar2r) {
  compare<2>(oracle("planar2r.urdf"), {0.0, -9.81, 0.0}, 1, 20);
}

TEST(LagrangianTree, OpenArm) {
  compare<7>(oracle("openarm.urdf"), {0.0, 0.0, -9.81}, 2, 2);
}

TEST(LagrangianTree, RandomTreesWithBranchesAndPrismaticJoints) {
  for (unsigned seed = 0; seed < 10; ++seed) {
    SCOPED_TRACE(seed);
    testing::RandomTreeOptions shape;
    shape.joints = 4;
    compare<4>(testing::RandomArm(seed).tree(shape), {0.5, -1.0, -9.7}, seed, 2);
  }
}

/// The tree has its curvature by Gauss' equation, of accelerations; here it is of fourth
/// derivatives of the Lagrangian.
TEST(LagrangianTree, Curvature) {
  for (unsigned seed = 0; seed < 4; ++seed) {
    testing::RandomArm random(seed);
    testing::RandomTreeOptions shape;
    shape.joints = 3;
    const TreeDescription description = random.tree(shape);
    const Mechanism tree(description, Vector3d::Zero());
    Workspace w(tree);
    const auto own = lagrangian<3>(testing::TemplatedTree(description, Vector3d::Zero()));
    const ChartVector<3> q = random.vector(3, 3.0), x = random.vector(3), y = random.vector(3);
    RiemannTensor tensor(tree);
    ASSERT_TRUE(riemann_tensor(tree, w, q, tensor));
    const auto riemann = *own.riemann_curvature(q);
    double scale = 1.0;
    for (const auto& slice : riemann.slice) {
      for (const auto& numbers : slice.slice) scale = std::max(scale, numbers.norm());
    }
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        for (int k = 0; k < 3; ++k) {
          for (int l = 0; l < 3; ++l) {
            EXPECT_NEAR(riemann(i, j, k, l), tensor(i, j, k, l), 1e-11 * scale)
                << "seed " << seed << ": " << i << j << k << l;
          }
        }
      }
    }
    const double ours = *own.sectional_curvature(q, x, y);
    EXPECT_NEAR(ours, sectional_curvature(tree, w, q, x, y), 1e-10 * (1.0 + std::abs(ours)));
  }
}

/// The tree's links, each behind a spring with a rotor at its other end: q = [links (2), rotors
/// (2)]. The user's Lagrangian takes the tree's and adds to it (Spong 1987).
struct ElasticJoints {
  testing::TemplatedTree tree;
  Eigen::Vector2d rotor, stiffness;

  template <class S>
  S operator()(const Eigen::Matrix<S, 4, 1>& q, const Eigen::Matrix<S, 4, 1>& v) const {
    const Eigen::Matrix<S, 2, 1> link = q.template head<2>(), link_rate = v.template head<2>();
    S result = tree(link, link_rate);
    for (int i = 0; i < 2; ++i) {
      const S stretch = q[2 + i] - q[i];
      result += 0.5 * rotor[i] * v[2 + i] * v[2 + i] - 0.5 * stiffness[i] * stretch * stretch;
    }
    return result;
  }
};

TEST(LagrangianTree, ElasticJointsBesideTheTree) {
  const TreeDescription description = oracle("planar2r.urdf");
  const Vector3d down(0.0, -9.81, 0.0);
  const Mechanism tree(description, down);
  Workspace w(tree);
  const Eigen::Vector2d rotor(0.03, 0.02), stiffness(300.0, 150.0);
  const auto elastic =
      lagrangian<4>(ElasticJoints{testing::TemplatedTree(description, down), rotor, stiffness});
  const Eigen::Vector4d q(0.7, -1.9, 0.75, -1.85), v(1.1, 0.6, -0.4, 2.0), tau(0.0, 0.0, 1.5, -0.5);
  const Eigen::Vector4d a = *elastic.forward_dynamics(q, v, tau);
  const Eigen::Vector2d spring = stiffness.cwiseProduct(q.tail<2>() - q.head<2>());
  // The links feel the springs as their motors, the rotors feel them back.
  const VectorXd links = *forward_dynamics(tree, w, q.head<2>(), v.head<2>(), spring);
  expect_near(a.head<2>(), links, "links");
  expect_near(a.tail<2>(), (tau.tail<2>() - spring).cwiseQuotient(rotor), "rotors");
}

}  // namespace
}  // namespace geodesic::control
