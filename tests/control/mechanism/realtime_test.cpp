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

/// The connection and all that is built on it.
void expect_no_heap_calls_of_the_connection(unsigned seed) {
  const Mechanism m = testing::random_mechanism(seed);
  testing::RandomArm random(seed);
  Workspace w(m);
  const Eigen::Index n = m.dof();
  const Eigen::VectorXd q = random.configuration(m);
  const Eigen::VectorXd v = random.vector(m.dof());
  const Eigen::VectorXd a = random.vector(m.dof());
  Eigen::VectorXd xi(n);
  Eigen::MatrixXd derivative = Eigen::MatrixXd::Zero(n, n);
  Eigen::MatrixXd y(n, parameter_count(m));
  Christoffel symbols(m);
  const bool small = n <= 8;
  RiemannTensor tensor(testing::random_mechanism(small ? seed : 0));
  const VectorField field = [](const VectorIn& at, Eigen::Ref<Eigen::VectorXd> out) {
    out.setConstant(at[0]);
  };
  const int tip = static_cast<int>(m.links().size()) - 1;
  const std::array<ExternalWrench, 2> wrenches{
      {{tip, Frame::kLink, {}}, {tip, Frame::kWorldOrigin, {}}}};

  const std::uint64_t before = rt::heap_calls();
  double sum = flat(m, w, q, v).sum() + sharp(m, w, q, a)->sum();
  const Eigen::VectorXd* articulated = articulated_body_acceleration(m, w, q, v, a);
  sum += articulated != nullptr ? articulated->sum() : 0.0;
  sum += connection_covector(m, w, q, v, a).sum() + geodesic_acceleration(m, w, q, v)->sum();
  sum += covariant_derivative(m, w, q, v, a, v)->sum() + potential_gradient(m, w, q)->sum();
  frame_bracket(m, v, a, xi);
  metric_derivative(m, w, q, symbols);
  sum += christoffel_second_kind(m, w, q, symbols) ? 1.0 : 0.0;
  sum += curvature_covector(m, w, q, v, a, v)->sum();
  sum += n > 1 ? sectional_curvature(m, w, q, v, a) : 0.0;
  sum += small && riemann_tensor(m, w, q, tensor) ? 1.0 : 0.0;
  sum += external_torque(m, w, q, wrenches).sum() + inverse_dynamics(m, w, q, v, a, wrenches).sum();
  sum += jacobian_rate(m, w, q, v, tip).sum() + centroidal_momentum_matrix(m, w, q).sum();
  sum += spatial_momentum(m, w, q, v).force.sum();
  sum += rigid_motion(m, w, q, {}, xi) ? 1.0 : 0.0;
  field_derivative(m, w, q, field, derivative);
  sum += momentum_map(m, w, q, v, xi) + momentum_map_rate(m, w, q, v, a, xi, derivative);
  regressor(m, w, q, v, a, y);
  const std::uint64_t after = rt::heap_calls();

  EXPECT_EQ(after - before, 0U) << "seed " << seed;
  EXPECT_TRUE(std::isfinite(sum)) << "seed " << seed;
}

TEST(MechanismRealtime, NothingOfTheConnectionAllocates) {
  for (unsigned seed = 0; seed < 24; ++seed) {
    expect_no_heap_calls_of_the_connection(seed);
  }
}

void expect_no_heap_calls(unsigned seed) {
  const Mechanism m = testing::random_mechanism(seed);
  testing::RandomArm random(seed);
  Workspace w(m);
  Christoffel symbols(m);
  Eigen::VectorXd q = random.configuration(m);
  const Eigen::VectorXd v = random.vector(m.dof());
  const Eigen::VectorXd a = random.vector(m.dof());
  // Plain memory as the controller holds it; a Map is taken without a copy.
  std::array<double, 256> plain{};
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
  integrate(m, q, mapped, 1e-3, q);
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
