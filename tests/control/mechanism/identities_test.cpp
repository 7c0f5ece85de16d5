// What the equations of motion must satisfy for any tree, on random ones: symmetry, skewness, power
// balance, agreement with finite differences. Stored numbers are in oracle_test.cpp.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <functional>
#include <string>

#include "control/mechanism/dynamics.hpp"
#include "tests/control/mechanism/random_tree.hpp"

namespace geodesic::control {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using testing::RandomArm;

/// A mechanism, a place to compute in, and a state.
struct Case {
  Mechanism mechanism;
  Workspace workspace;
  VectorXd q, v, a;

  explicit Case(unsigned seed) : mechanism(testing::random_mechanism(seed)), workspace(mechanism) {
    RandomArm random(1000 + seed);
    q = random.configuration(mechanism);
    v = random.vector(mechanism.dof(), 2.0);
    a = random.vector(mechanism.dof(), 5.0);
  }

  /// The configuration after moving along v for a time.
  VectorXd moved(double time) const {
    VectorXd result = q;
    integrate(mechanism, q, v, time, result);
    return result;
  }
};

/// d/dt of a quantity at t = 0, central differences extrapolated once (Richardson).
MatrixXd rate(const std::function<MatrixXd(double)>& quantity) {
  const auto difference = [&](double h) -> MatrixXd {
    return (quantity(h) - quantity(-h)) / (2.0 * h);
  };
  constexpr double kStep = 1e-3;
  return (4.0 * difference(0.5 * kStep) - difference(kStep)) / 3.0;
}

void expect_near(const MatrixXd& found, const MatrixXd& expected, double tolerance) {
  ASSERT_EQ(found.rows(), expected.rows());
  ASSERT_EQ(found.cols(), expected.cols());
  const double scale = std::max(1.0, expected.cwiseAbs().maxCoeff());
  EXPECT_LE((found - expected).cwiseAbs().maxCoeff(), tolerance * scale);
}

/// Runs a check on trees of every size, kind and base.
template <class Check>
void on_random_trees(Check check) {
  for (unsigned seed = 0; seed < 48; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Case c(seed);
    check(c, c.mechanism, c.workspace);
  }
}

TEST(MechanismIdentities, MetricIsSymmetricAndPositive) {
  on_random_trees([](const Case& c, const Mechanism& m, Workspace& w) {
    const MatrixXd metric_of_q = metric(m, w, c.q);
    EXPECT_EQ(metric_of_q, metric_of_q.transpose());
    const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(metric_of_q);
    EXPECT_GT(solver.eigenvalues().minCoeff(), 0.0);
    const MatrixXd inverse = *metric_inverse(m, w, c.q);
    EXPECT_EQ(inverse, inverse.transpose());
    const double condition = solver.eigenvalues().maxCoeff() / solver.eigenvalues().minCoeff();
    EXPECT_LE((metric_of_q * inverse - MatrixXd::Identity(m.dof(), m.dof())).norm(),
              1e-14 * condition);
  });
}

TEST(MechanismIdentities, MetricIsTheQuadraticFormOfKineticEnergy) {
  on_random_trees([](const Case& c, const Mechanism& m, Workspace& w) {
    const double energy = kinetic_energy(m, w, c.q, c.v);
    EXPECT_NEAR(energy, 0.5 * c.v.dot(metric(m, w, c.q) * c.v), 1e-13 * (1.0 + energy));
  });
}

TEST(MechanismIdentities, MetricRateIsTheDerivativeOfTheMetric) {
  on_random_trees([](const Case& c, const Mechanism& m, Workspace& w) {
    const MatrixXd expected = rate([&](double t) -> MatrixXd { return metric(m, w, c.moved(t)); });
    expect_near(metric_rate(m, w, c.q, c.v), expected, 1e-8);
  });
}

TEST(MechanismIdentities, MetricRateLessTwiceCoriolisIsSkew) {
  on_random_trees([](const Case& c, const Mechanism& m, Workspace& w) {
    const MatrixXd coriolis = coriolis_matrix(m, w, c.q, c.v);
    const MatrixXd difference = metric_rate(m, w, c.q, c.v) - 2.0 * coriolis;
    expect_near(difference, -difference.transpose(), 1e-13);
    EXPECT_EQ(w.metric_rate, w.metric_rate.transpose());
  });
}

TEST(MechanismIdentities, BiasIsCoriolisPlusGravity) {
  on_random_trees([](const Case& c, const Mechanism& m, Workspace& w) {
    const VectorXd sum = coriolis_matrix(m, w, c.q, c.v) * c.v + gravity(m, w, c.q);
    expect_near(bias(m, w, c.q, c.v), sum, 1e-13);
  });
}

TEST(MechanismIdentities, InverseDynamicsIsMetricTimesAccelerationPlusBias) {
  on_random_trees([](const Case& c, const Mechanism& m, Workspace& w) {
    const VectorXd sum = metric(m, w, c.q) * c.a + bias(m, w, c.q, c.v);
    expect_near(inverse_dynamics(m, w, c.q, c.v, c.a), sum, 1e-13);
  });
}

TEST(MechanismIdentities, ForwardDynamicsUndoesInverseDynamics) {
  on_random_trees([](const Case& c, const Mechanism& m, Workspace& w) {
    const VectorXd tau = inverse_dynamics(m, w, c.q, c.v, c.a);
    const VectorXd* found = forward_dynamics(m, w, c.q, c.v, tau);
    ASSERT_NE(found, nullptr);
    const VectorXd again = metric(m, w, c.q) * *found + bias(m, w, c.q, c.v);
    expect_near(again, tau, 1e-12);
    const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(w.metric);
    const double condition = solver.eigenvalues().maxCoeff() / solver.eigenvalues().minCoeff();
    expect_near(*found, c.a, 1e-14 * condition);
  });
}

TEST(MechanismIdentities, GravityIsTheDerivativeOfPotentialEnergy) {
  on_random_trees([](const Case& c, const Mechanism& m, Workspace& w) {
    const MatrixXd expected = rate([&](double t) -> MatrixXd {
      return MatrixXd::Constant(1, 1, potential_energy(m, w, c.moved(t)));
    });
    const double scale = 1.0 + gravity(m, w, c.q).norm() * c.v.norm();
    EXPECT_NEAR(gravity(m, w, c.q).dot(c.v), expected(0, 0), 1e-9 * scale);
  });
}

TEST(MechanismIdentities, EnergyChangesByThePowerOfTheTorques) {
  on_random_trees([](const Case& c, const Mechanism& m, Workspace& w) {
    const VectorXd tau = inverse_dynamics(m, w, c.q, c.v, c.a);
    const MatrixXd energy_rate = rate([&](double t) -> MatrixXd {
      // To third order the path with acceleration a; odd errors above cancel in the extrapolation.
      VectorXd q = c.q;
      integrate(m, c.q, c.v + (0.5 * t) * c.a, t, q);
      const VectorXd v = c.v + t * c.a;
      return MatrixXd::Constant(1, 1, kinetic_energy(m, w, q, v) + potential_energy(m, w, q));
    });
    const double scale = 1.0 + tau.norm() * c.v.norm();
    EXPECT_NEAR(energy_rate(0, 0), c.v.dot(tau), 1e-6 * scale);
  });
}

TEST(MechanismIdentities, JacobianIsTheDerivativeOfThePose) {
  on_random_trees([](const Case& c, const Mechanism& m, Workspace& w) {
    for (int link = 0; link < static_cast<int>(m.links().size()); link += 5) {
      const VectorXd twist = jacobian(m, w, c.q, link) * c.v;
      const Eigen::Matrix3d turned = link_pose(m, c.q, link).rotation;
      const MatrixXd origin =
          rate([&](double t) -> MatrixXd { return link_pose(m, c.moved(t), link).translation; });
      const MatrixXd turning =
          rate([&](double t) -> MatrixXd { return link_pose(m, c.moved(t), link).rotation; });
      expect_near(twist.head<3>(), origin, 1e-8);
      expect_near(twist.tail<3>(), vee(turning * turned.transpose()), 1e-8);
    }
  });
}

TEST(MechanismIdentities, MomentumIsMassTimesVelocityOfTheCentre) {
  on_random_trees([](const Case& c, const Mechanism& m, Workspace& w) {
    const CentroidalMomentum momentum = centroidal_momentum(m, w, c.q, c.v);
    const MatrixXd velocity =
        rate([&](double t) -> MatrixXd { return centre_of_mass(m, w, c.moved(t)); });
    expect_near(momentum.velocity, velocity, 1e-8);
    expect_near(momentum.linear, m.moving_mass() * momentum.velocity, 1e-13);
    if (m.floating()) {
      // The base's rows of M v are the momentum about the base, in its axes.
      const Eigen::Matrix3d rotation = link_pose(m, c.q, 0).rotation;
      const VectorXd about_base = metric(m, w, c.q).topRows<6>() * c.v;
      const Eigen::Vector3d lever = momentum.centre_of_mass - c.q.head<3>();
      expect_near(rotation * about_base.head<3>(), momentum.linear, 1e-12);
      expect_near(rotation * about_base.tail<3>(), momentum.angular + lever.cross(momentum.linear),
                  1e-12);
    }
  });
}

TEST(MechanismIdentities, ChristoffelSymbolsMakeTheCoriolisMatrix) {
  on_random_trees([](const Case& c, const Mechanism& m, Workspace& w) {
    Christoffel symbols(m);
    christoffel_symbols(m, w, c.q, symbols);
    const MatrixXd expected = coriolis_matrix(m, w, c.q, c.v);
    MatrixXd found = MatrixXd::Zero(m.dof(), m.dof());
    double asymmetry = 0.0;
    for (int i = 0; i < m.dof(); ++i) {
      for (int j = 0; j < m.dof(); ++j) {
        for (int k = 0; k < m.dof(); ++k) {
          found(i, j) += symbols(i, j, k) * c.v[k];
          asymmetry = std::max(asymmetry, std::abs(symbols(i, j, k) - symbols(i, k, j)));
        }
      }
    }
    expect_near(found, expected, 1e-12);
    if (m.one_chart()) {
      EXPECT_LE(asymmetry, 1e-13 * (1.0 + metric(m, w, c.q).norm()));
    }
  });
}

}  // namespace
}  // namespace geodesic::control
