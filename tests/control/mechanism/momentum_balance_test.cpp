// Momentum and its drift against the matrices they are made without: M v, and C' v - g.
#include "control/mechanism/momentum_balance.hpp"

#include <gtest/gtest.h>

#include "control/mechanism/coriolis.hpp"
#include "control/mechanism/gravity.hpp"
#include "control/mechanism/metric.hpp"
#include "rt/heap_counter.hpp"
#include "tests/control/mechanism/random_tree.hpp"

namespace geodesic::control {
namespace {

TEST(MomentumBalance, EqualsTheMatricesOnRandomTrees) {
  for (unsigned seed = 0; seed < 60; ++seed) {
    const Mechanism m = testing::random_mechanism(seed);
    testing::RandomArm random(seed + 1000);
    Workspace w(m);
    for (int pose = 0; pose < 5; ++pose) {
      const Eigen::VectorXd q = random.configuration(m);
      const Eigen::VectorXd v = random.vector(m.dof(), 3.0);
      const Eigen::VectorXd momentum = metric(m, w, q) * v;
      const Eigen::VectorXd drift = coriolis_matrix(m, w, q, v).transpose() * v - gravity(m, w, q);
      const std::uint64_t heap = rt::heap_calls();
      momentum_balance(m, w, q, v);
      EXPECT_EQ(rt::heap_calls(), heap);
      EXPECT_LT((w.joint_momentum - momentum).norm(), 1e-11 * (1.0 + momentum.norm())) << seed;
      EXPECT_LT((w.momentum_drift - drift).norm(), 1e-11 * (1.0 + drift.norm())) << seed;
    }
  }
}

}  // namespace
}  // namespace geodesic::control
