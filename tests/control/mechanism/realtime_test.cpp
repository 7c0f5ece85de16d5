// No function that calls itself real-time goes to the heap.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "control/mechanism/dynamics.hpp"
#include "rt/heap_counter.hpp"
#include "tests/control/mechanism/random_tree.hpp"

namespace geodesic::control {
namespace {

void expect_no_heap_calls(unsigned seed) {
  const Mechanism m = testing::random_mechanism(seed);
  testing::RandomArm random(seed);
  Workspace w(m);
  Christoffel symbols(m);
  Eigen::VectorXd q = random.configuration(m);
  const Eigen::VectorXd v = random.vector(m.dof());
  const Eigen::VectorXd a = random.vector(m.dof());
  // Plain memory as the controller holds it; a Map is taken without a copy.
  std::array<double, 64> plain{};
  std::copy(v.begin(), v.end(), plain.begin());
  const Eigen::Map<const Eigen::VectorXd> mapped(plain.data(), m.dof());
  const int tip = static_cast<int>(m.links().size()) - 1;

  const std::uint64_t before = rt::heap_calls();
  double sum = gravity(m, w, q).sum() + bias(m, w, q, mapped).sum();
  sum += inverse_dynamics(m, w, q, v, a).sum() + metric(m, w, q).sum();
  sum += forward_dynamics(m, w, q, mapped, a)->sum() + metric_inverse(m, w, q)->sum();
  sum += coriolis_matrix(m, w, q, v).sum() + metric_rate(m, w, q, mapped).sum();
  sum += jacobian(m, w, q, tip).sum() + link_pose(m, q, tip).translation.sum();
  sum += kinetic_energy(m, w, q, v) + potential_energy(m, w, q);
  sum += centroidal_momentum(m, w, q, v).angular.sum() + centre_of_mass(m, w, q).sum();
  christoffel_symbols(m, w, q, symbols);
  displace(m, q, mapped, 1e-3, q);
  const std::uint64_t after = rt::heap_calls();

  EXPECT_EQ(after - before, 0U) << "seed " << seed;
  EXPECT_TRUE(std::isfinite(sum));
}

TEST(MechanismRealtime, NothingAllocates) {
  for (unsigned seed = 0; seed < 24; ++seed) {
    expect_no_heap_calls(seed);
  }
}

TEST(MechanismRealtime, TheCounterCounts) {
  const std::uint64_t before = rt::heap_calls();
  const Eigen::VectorXd on_heap = Eigen::VectorXd::Ones(40);
  EXPECT_GT(rt::heap_calls() - before, 0U) << on_heap.sum();
}

}  // namespace
}  // namespace geodesic::control
