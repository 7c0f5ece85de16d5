// Noether: momenta of symmetries stay along integrated motions, and what is no symmetry is told.
#include "tests/control/mechanism/random_case.hpp"

namespace geodesic::control {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using testing::expect_near;
using testing::on_random_cases;
using testing::RandomCase;
using testing::rate;

/// dq/dt of the numbers q, quaternions included.
VectorXd coordinate_rate(const Mechanism& m, const VectorXd& q, const VectorXd& v) {
  VectorXd result(m.nq());
  for (const Factor& factor : m.factors()) {
    if (factor.nq == factor.nv) {
      result.segment(factor.q, factor.nq) = v.segment(factor.v, factor.nv);
      continue;
    }
    const int at = factor.q + factor.nq - 4;
    const Eigen::Quaterniond turn(q[at + 3], q[at], q[at + 1], q[at + 2]);
    const Vector3d w = v.segment<3>(factor.v + factor.nv - 3);
    if (factor.nv == 6) {
      result.segment<3>(factor.q) = turn.normalized() * Vector3d(v.segment<3>(factor.v));
    }
    result.segment<4>(at) = 0.5 * (turn * Eigen::Quaterniond(0.0, w.x(), w.y(), w.z())).coeffs();
  }
  return result;
}

/// Free motion, gravity compensated, by the classical Runge-Kutta method on the numbers of q and v.
void follow(RandomCase& c, double time, int steps) {
  const Mechanism& m = c.mechanism;
  const double h = time / steps;
  struct Slope {
    VectorXd q, v;
  };
  const auto slope = [&](const VectorXd& q, const VectorXd& v) -> Slope {
    return {coordinate_rate(m, q, v), *geodesic_acceleration(m, c.workspace, q, v)};
  };
  for (int step = 0; step < steps; ++step) {
    const Slope a = slope(c.q, c.v);
    const Slope b = slope(c.q + 0.5 * h * a.q, c.v + 0.5 * h * a.v);
    const Slope d = slope(c.q + 0.5 * h * b.q, c.v + 0.5 * h * b.v);
    const Slope e = slope(c.q + h * d.q, c.v + h * d.v);
    c.q += h / 6.0 * (a.q + 2.0 * b.q + 2.0 * d.q + e.q);
    c.v += h / 6.0 * (a.v + 2.0 * b.v + 2.0 * d.v + e.v);
  }
}

Twist twist(const VectorXd& six) {
  return {six.head<3>(), six.tail<3>()};
}

VectorField motion_of_space(RandomCase& c, const Twist& xi) {
  return [&c, xi](const VectorIn& q, Eigen::Ref<VectorXd> out) {
    EXPECT_TRUE(rigid_motion(c.mechanism, c.workspace, q, xi, out));
  };
}

TEST(MechanismNoether, RigidMotionsOfAFloatingMechanismAreSymmetries) {
  int checked = 0;
  on_random_cases(
      [&](RandomCase& c) {
        const Mechanism& m = c.mechanism;
        if (!m.floating()) {
          return;
        }
        ++checked;
        const Twist xi = twist(c.random.vector(6));
        const VectorField field = motion_of_space(c, xi);
        VectorXd components(m.dof());
        field(c.q, components);
        const double momentum = momentum_map(m, c.workspace, c.q, c.v, components);
        const Wrench spatial = spatial_momentum(m, c.workspace, c.q, c.v);
        EXPECT_NEAR(momentum, dot(spatial, xi), 1e-12 * (1.0 + std::abs(momentum)));
        MatrixXd derivative(m.dof(), m.dof());
        field_derivative(m, c.workspace, c.q, field, derivative);
        const MatrixXd lie = lie_derivative_of_metric(m, c.workspace, c.q, components, derivative);
        EXPECT_LE(lie.cwiseAbs().maxCoeff(), 1e-9 * (1.0 + c.workspace.metric.norm()));
      },
      60);
  EXPECT_GE(checked, 6);
}

TEST(MechanismNoether, FreeMotionKeepsEveryMomentumAndTheEnergy) {
  for (const unsigned seed : {3U, 11U, 19U, 27U}) {
    RandomCase c(seed);
    const Mechanism& m = c.mechanism;
    ASSERT_TRUE(m.floating());
    c.v *= 0.5;
    const Wrench before = spatial_momentum(m, c.workspace, c.q, c.v);
    const double energy = kinetic_energy(m, c.workspace, c.q, c.v);
    const VectorXd q = c.q;
    follow(c, 0.4, 400);
    EXPECT_GT((c.q - q).norm(), 0.1);
    const Wrench after = spatial_momentum(m, c.workspace, c.q, c.v);
    EXPECT_LE((after.force - before.force).norm(), 1e-8) << seed;
    EXPECT_LE((after.moment - before.moment).norm(), 1e-8) << seed;
    EXPECT_NEAR(kinetic_energy(m, c.workspace, c.q, c.v), energy, 1e-8 * (1.0 + energy)) << seed;
  }
}

TEST(MechanismNoether, TheBalanceHoldsForAnyFieldTorqueAndMotion) {
  on_random_cases(
      [](RandomCase& c) {
        const Mechanism& m = c.mechanism;
        const int n = m.dof();
        // A field that is no symmetry: components vary with the first body's pose and all angles.
        const MatrixXd mix = MatrixXd::NullaryExpr(
            n, m.nq(), [&](Eigen::Index, Eigen::Index) { return c.random.uniform(-1.0, 1.0); });
        const VectorField field = [&](const VectorIn& q, Eigen::Ref<VectorXd> out) {
          out = (mix * q).array().sin();
        };
        VectorXd xi(n);
        field(c.q, xi);
        MatrixXd derivative(n, n);
        field_derivative(m, c.workspace, c.q, field, derivative);
        const VectorXd tau = inverse_dynamics(m, c.workspace, c.q, c.v, c.a);
        const double found = momentum_map_rate(m, c.workspace, c.q, c.v, tau, xi, derivative);
        // Through q with velocity v and acceleration a; odd terms of higher order do not matter.
        const MatrixXd expected = rate(
            [&](double t) -> MatrixXd {
              const VectorXd q = c.moved(c.v + 0.5 * t * c.a, t);
              VectorXd at(n);
              field(q, at);
              return MatrixXd::Constant(1, 1, momentum_map(m, c.workspace, q, c.v + t * c.a, at));
            },
            0.5e-3);
        const double scale = 1.0 + tau.norm() * xi.norm() + std::abs(found);
        EXPECT_NEAR(found, expected(0, 0), 1e-7 * scale);
      },
      40);
}

TEST(MechanismNoether, AnArmTurnsAboutItsFirstAxisOnly) {
  testing::RandomArm random(11);
  testing::RandomTreeOptions shape;
  shape.branching = 0.0;
  TreeDescription tree = random.tree(shape);
  for (JointDescription& joint : tree.joints) {
    joint.kind = JointKind::kRevolute;
  }
  const Mechanism m(tree, Vector3d::Zero());
  Workspace w(m);
  const VectorXd q = random.configuration(m), v = random.vector(m.dof());
  update_poses(m, w, q);
  const Pose first = w.world_from_body[0];
  const Vector3d axis = first.rotation.col(2);
  const Twist about_axis{first.translation.cross(axis), axis};
  VectorXd xi(m.dof());
  ASSERT_TRUE(rigid_motion(m, w, q, about_axis, xi));
  expect_near(xi, VectorXd::Unit(m.dof(), 0), 1e-12);
  const Wrench spatial = spatial_momentum(m, w, q, v);
  EXPECT_NEAR(momentum_map(m, w, q, v, xi), dot(spatial, about_axis), 1e-13);
  EXPECT_NEAR(flat(m, w, q, v)[0], dot(spatial, about_axis), 1e-13);
  const MatrixXd constant = MatrixXd::Zero(m.dof(), m.dof());
  EXPECT_LE(lie_derivative_of_metric(m, w, q, xi, constant).cwiseAbs().maxCoeff(), 1e-14);
  const Twist beside{first.translation.cross(axis) + Vector3d(0.1, 0.0, 0.0), axis};
  EXPECT_FALSE(rigid_motion(m, w, q, beside, xi));
  const VectorXd second = VectorXd::Unit(m.dof(), 1);
  EXPECT_GT(lie_derivative_of_metric(m, w, q, second, constant).cwiseAbs().maxCoeff(), 1e-3);
}

TEST(MechanismNoether, APlanarBaseKeepsTheMomentaOfSe2) {
  TreeDescription tree;
  testing::RandomArm random(7);
  tree.root_link = "floor";
  tree.links = {{"floor", {}}, {"cart", random.inertia()}, {"arm", random.inertia()}};
  JointDescription base;
  base.name = "a";
  base.kind = JointKind::kPlanar;
  base.parent_link = "floor";
  base.child_link = "cart";
  base.axis = Vector3d::UnitZ();
  JointDescription elbow = base;
  elbow.name = "b";
  elbow.kind = JointKind::kContinuous;
  elbow.parent_link = "cart";
  elbow.child_link = "arm";
  elbow.parent_from_joint.translation() = Vector3d(0.4, 0.1, 0.0);
  tree.joints = {base, elbow};
  const Mechanism m(tree, Vector3d(0.0, 0.0, -9.81));
  Workspace w(m);
  const VectorXd q = random.configuration(m), v = random.vector(m.dof());
  const Wrench spatial = spatial_momentum(m, w, q, v);
  for (int i = 0; i < 6; ++i) {
    const Twist xi = twist(VectorXd::Unit(6, i));
    VectorXd components(m.dof());
    const bool in_plane = i == 0 || i == 1 || i == 5;
    ASSERT_EQ(rigid_motion(m, w, q, xi, components), in_plane) << i;
    if (in_plane) {
      EXPECT_NEAR(momentum_map(m, w, q, v, components), dot(spatial, xi), 1e-13);
    }
  }
}

TEST(MechanismNoether, TheCentroidalMomentumMatrixMakesCentroidalMomentum) {
  on_random_cases([](RandomCase& c) {
    const Mechanism& m = c.mechanism;
    const CentroidalMomentum expected = centroidal_momentum(m, c.workspace, c.q, c.v);
    const VectorXd h = centroidal_momentum_matrix(m, c.workspace, c.q) * c.v;
    expect_near(h.head<3>(), expected.linear, 1e-12);
    expect_near(h.tail<3>(), expected.angular, 1e-12);
    const Wrench spatial = spatial_momentum(m, c.workspace, c.q, c.v);
    expect_near(spatial.force, expected.linear, 1e-12);
    expect_near(spatial.moment, expected.angular + expected.centre_of_mass.cross(expected.linear),
                1e-12);
  });
}

}  // namespace
}  // namespace geodesic::control
