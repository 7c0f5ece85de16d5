// A random mechanism with a place to compute in and a state, and derivatives by differences: what
// the property tests of the metric and its connection share.
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <string>

#include "control/mechanism/dynamics.hpp"
#include "tests/control/mechanism/random_tree.hpp"

namespace geodesic::control::testing {

struct RandomCase {
  Mechanism mechanism;
  Workspace workspace;
  RandomArm random;
  Eigen::VectorXd q, v, a;

  explicit RandomCase(unsigned seed)
      : mechanism(random_mechanism(seed)), workspace(mechanism), random(1000 + seed) {
    q = random.configuration(mechanism);
    v = random.vector(mechanism.dof(), 2.0);
    a = random.vector(mechanism.dof(), 5.0);
  }

  /// The configuration after following a constant velocity for a time.
  Eigen::VectorXd moved(const Eigen::VectorXd& velocity, double time) const {
    Eigen::VectorXd result = q;
    integrate(mechanism, q, velocity, time, result);
    return result;
  }
};

/// d/dt at t = 0, central differences of sixth order. (Long chains move far in a hundredth of a
/// second.)
template <class Quantity>
Eigen::MatrixXd rate(Quantity quantity, double step = 0.003) {
  const Eigen::MatrixXd one = quantity(step) - quantity(-step);
  const Eigen::MatrixXd two = quantity(2.0 * step) - quantity(-2.0 * step);
  const Eigen::MatrixXd three = quantity(3.0 * step) - quantity(-3.0 * step);
  return (45.0 * one - 9.0 * two + three) / (60.0 * step);
}

/// Largest difference relative to the larger of 1 and the largest entry expected.
inline void expect_near(const Eigen::MatrixXd& found, const Eigen::MatrixXd& expected,
                        double tolerance) {
  ASSERT_EQ(found.rows(), expected.rows());
  ASSERT_EQ(found.cols(), expected.cols());
  const double scale = std::max(1.0, expected.cwiseAbs().maxCoeff());
  EXPECT_LE((found - expected).cwiseAbs().maxCoeff(), tolerance * scale);
}

/// Runs check(case) on mechanisms of every size up to `largest` degrees of freedom, kind and base.
template <class Check>
void on_random_cases(Check check, int largest = 1000, unsigned seeds = 48) {
  int checked = 0;
  for (unsigned seed = 0; seed < seeds; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    RandomCase c(seed);
    if (c.mechanism.dof() <= largest) {
      ++checked;
      check(c);
    }
  }
  EXPECT_GE(checked, 8);
}

inline double condition(const Eigen::MatrixXd& symmetric) {
  const Eigen::VectorXd values =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(symmetric).eigenvalues();
  return values.maxCoeff() / values.minCoeff();
}

}  // namespace geodesic::control::testing
