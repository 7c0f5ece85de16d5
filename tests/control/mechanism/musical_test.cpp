// The maps between velocities and momenta, and what they are made of: the sparse factorisation
// against Eigen's dense one, articulated bodies against both.
#include "tests/control/mechanism/random_case.hpp"

namespace geodesic::control {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using testing::condition;
using testing::expect_near;
using testing::on_random_cases;
using testing::RandomCase;

TEST(MechanismMusical, FlatIsTheMetricTimesTheVelocity) {
  on_random_cases([](RandomCase& c) {
    const VectorXd p = metric(c.mechanism, c.workspace, c.q) * c.v;
    expect_near(flat(c.mechanism, c.workspace, c.q, c.v), p, 1e-13);
    EXPECT_NEAR(0.5 * c.workspace.flat.dot(c.v), kinetic_energy(c.mechanism, c.workspace, c.q, c.v),
                1e-12 * (1.0 + p.norm()));
  });
}

TEST(MechanismMusical, SharpUndoesFlat) {
  on_random_cases([](RandomCase& c) {
    const VectorXd p = flat(c.mechanism, c.workspace, c.q, c.v);
    const VectorXd* v = sharp(c.mechanism, c.workspace, c.q, p);
    ASSERT_NE(v, nullptr);
    expect_near(*v, c.v, 1e-14 * condition(c.workspace.metric));
  });
}

TEST(MechanismMusical, TheSparseFactorSolvesAsEigensDenseOne) {
  on_random_cases([](RandomCase& c) {
    const MatrixXd m = metric(c.mechanism, c.workspace, c.q);
    const MatrixXd expected = m.ldlt().solve(MatrixXd::Identity(m.rows(), m.cols()));
    TreeCholesky factor(c.mechanism);
    ASSERT_TRUE(factor.factor(m));
    MatrixXd inverse = MatrixXd::Constant(m.rows(), m.cols(), 7.0);
    factor.inverse(inverse);
    const double tolerance = 1e-14 * condition(m);
    EXPECT_EQ(inverse, inverse.transpose());
    expect_near(inverse, expected, tolerance);
    expect_near(*metric_inverse(c.mechanism, c.workspace, c.q), expected, tolerance);
    VectorXd x = c.a;
    factor.solve(x);
    expect_near(x, m.ldlt().solve(c.a), tolerance);
  });
}

TEST(MechanismMusical, NothingFillsInOnATreeWithoutMimicJoints) {
  for (unsigned seed = 0; seed < 24; ++seed) {
    const Mechanism m = testing::random_mechanism(seed);
    const TreeCholesky factor(m);
    int freedom = 0;
    for (const Body& body : m.bodies()) {
      freedom += freedoms(body.motion);
    }
    if (freedom != m.dof()) {
      continue;
    }
    for (const Body& body : m.bodies()) {
      const int above =
          body.parent == kWorld
              ? -1
              : m.bodies()[static_cast<std::size_t>(body.parent)].dof +
                    freedoms(m.bodies()[static_cast<std::size_t>(body.parent)].motion) - 1;
      EXPECT_EQ(factor.parent(body.dof), above) << seed;
    }
  }
}

TEST(MechanismMusical, ArticulatedBodiesUndoInverseDynamics) {
  int checked = 0;
  on_random_cases([&](RandomCase& c) {
    const VectorXd tau = inverse_dynamics(c.mechanism, c.workspace, c.q, c.v, c.a);
    const VectorXd cholesky = *forward_dynamics(c.mechanism, c.workspace, c.q, c.v, tau);
    const double tolerance = 1e-14 * condition(metric(c.mechanism, c.workspace, c.q));
    expect_near(cholesky, c.a, tolerance);
    const VectorXd* found = articulated_body_acceleration(c.mechanism, c.workspace, c.q, c.v, tau);
    std::size_t freedom = 0;
    for (const Body& body : c.mechanism.bodies()) {
      freedom += static_cast<std::size_t>(freedoms(body.motion));
    }
    if (freedom != static_cast<std::size_t>(c.mechanism.dof())) {
      EXPECT_EQ(found, nullptr);  // mimic joints
      return;
    }
    ++checked;
    ASSERT_NE(found, nullptr);
    expect_near(*found, c.a, tolerance);
    const VectorXd acceleration = *found;
    const VectorXd again = metric(c.mechanism, c.workspace, c.q) * acceleration +
                           bias(c.mechanism, c.workspace, c.q, c.v);
    expect_near(again, tau, 1e-11);
  });
  EXPECT_GE(checked, 24);
}

TEST(MechanismMusical, AJointThatMeetsNoInertiaIsSaid) {
  TreeDescription tree;
  tree.root_link = "base";
  tree.links = {{"base", {}}, {"ghost", {}}};
  JointDescription joint;
  joint.name = "joint";
  joint.kind = JointKind::kRevolute;
  joint.parent_link = "base";
  joint.child_link = "ghost";
  tree.joints = {joint};
  const Mechanism m(tree, Eigen::Vector3d(0.0, 0.0, -9.81));
  Workspace w(m);
  const VectorXd one = VectorXd::Ones(1);
  EXPECT_EQ(sharp(m, w, one, one), nullptr);
  EXPECT_EQ(metric_inverse(m, w, one), nullptr);
  EXPECT_EQ(forward_dynamics(m, w, one, one, one), nullptr);
  EXPECT_EQ(articulated_body_acceleration(m, w, one, one, one), nullptr);
  EXPECT_EQ(geodesic_acceleration(m, w, one, one), nullptr);
  EXPECT_TRUE(std::isnan(sectional_curvature(m, w, one, one, one)));
}

}  // namespace
}  // namespace geodesic::control
