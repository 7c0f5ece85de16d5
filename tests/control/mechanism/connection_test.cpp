// The connection against its definition: Koszul's formula with derivatives of the metric by
// differences, its two laws, and the motions it describes.
#include "tests/control/mechanism/random_case.hpp"

namespace geodesic::control {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using testing::condition;
using testing::expect_near;
using testing::on_random_cases;
using testing::RandomCase;
using testing::rate;

VectorXd unit(const Mechanism& m, int i) {
  return VectorXd::Unit(m.dof(), i);
}

VectorXd bracket(const Mechanism& m, const VectorXd& x, const VectorXd& y) {
  VectorXd result(m.dof());
  frame_bracket(m, x, y, result);
  return result;
}

MatrixXd metric_rate_by_differences(RandomCase& c, const VectorXd& along) {
  return rate(
      [&](double t) -> MatrixXd { return metric(c.mechanism, c.workspace, c.moved(along, t)); });
}

TEST(MechanismConnection, KoszulsFormulaGivesTheChristoffelSymbols) {
  on_random_cases(
      [](RandomCase& c) {
        const Mechanism& m = c.mechanism;
        const int n = m.dof();
        Christoffel first(m), second(m), derivative(m);
        christoffel_symbols(m, c.workspace, c.q, first);
        metric_derivative(m, c.workspace, c.q, derivative);
        ASSERT_TRUE(christoffel_second_kind(m, c.workspace, c.q, second));
        const MatrixXd g = metric(m, c.workspace, c.q);
        std::vector<MatrixXd> dg;
        for (int k = 0; k < n; ++k) {
          dg.push_back(metric_rate_by_differences(c, unit(m, k)));
          expect_near(derivative.slice(k), dg.back(), 1e-9);
          EXPECT_EQ(derivative.slice(k), derivative.slice(k).transpose());
          expect_near(g * second.slice(k), first.slice(k), 1e-12 * condition(g));
        }
        std::vector<MatrixXd> brackets;  // row-lowered: (l, i) of number k is <[E_k, E_i], E_l>
        for (int k = 0; k < n; ++k) {
          brackets.emplace_back(n, n);
          for (int i = 0; i < n; ++i) {
            brackets.back().col(i) = g * bracket(m, unit(m, k), unit(m, i));
          }
        }
        double worst = 0.0;
        const auto at = [](int i) { return static_cast<std::size_t>(i); };
        for (int i = 0; i < n; ++i) {
          for (int j = 0; j < n; ++j) {
            for (int k = 0; k < n; ++k) {
              const double koszul =
                  0.5 * (dg[at(k)](i, j) + dg[at(j)](i, k) - dg[at(i)](j, k) +
                         brackets[at(k)](i, j) - brackets[at(k)](j, i) - brackets[at(j)](k, i));
              worst = std::max(worst, std::abs(koszul - first(i, j, k)));
            }
          }
        }
        EXPECT_LE(worst, 1e-9 * (1.0 + g.cwiseAbs().maxCoeff()));
      },
      30);
}

TEST(MechanismConnection, IsCompatibleWithTheMetricAndFreeOfTorsion) {
  on_random_cases([](RandomCase& c) {
    const Mechanism& m = c.mechanism;
    const VectorXd x = c.v, y = c.a, z = c.random.vector(m.dof(), 3.0);
    const VectorXd along_x_of_y = connection_covector(m, c.workspace, c.q, x, y);
    const VectorXd along_x_of_z = connection_covector(m, c.workspace, c.q, x, z);
    const VectorXd along_y_of_x = connection_covector(m, c.workspace, c.q, y, x);
    const double change = y.dot(metric_rate_by_differences(c, x) * z);
    EXPECT_NEAR(along_x_of_y.dot(z) + along_x_of_z.dot(y), change, 1e-9 * (1.0 + std::abs(change)));
    expect_near(along_x_of_y - along_y_of_x, flat(m, c.workspace, c.q, bracket(m, x, y)), 1e-12);
  });
}

TEST(MechanismConnection, TheRecursionIsTheCoriolisMatrix) {
  on_random_cases([](RandomCase& c) {
    const Mechanism& m = c.mechanism;
    const MatrixXd coriolis = coriolis_matrix(m, c.workspace, c.q, c.v);
    expect_near(connection_covector(m, c.workspace, c.q, c.v, c.a), coriolis * c.a, 1e-12);
    const VectorXd covector = bias(m, c.workspace, c.q, c.v) - gravity(m, c.workspace, c.q);
    expect_near(connection_covector(m, c.workspace, c.q, c.v, c.v), covector, 1e-12);
  });
}

TEST(MechanismConnection, FlatOfTheCovariantAccelerationIsTorqueLessGravity) {
  on_random_cases([](RandomCase& c) {
    const Mechanism& m = c.mechanism;
    const VectorXd tau = inverse_dynamics(m, c.workspace, c.q, c.v, c.a);
    const VectorXd g = gravity(m, c.workspace, c.q);
    const VectorXd* found = covariant_derivative(m, c.workspace, c.q, c.v, c.v, c.a);
    ASSERT_NE(found, nullptr);
    const VectorXd acceleration = *found;
    expect_near(flat(m, c.workspace, c.q, acceleration), tau - g, 1e-11);

    const double tolerance = 1e-13 * condition(metric(m, c.workspace, c.q));
    const VectorXd free = *forward_dynamics(m, c.workspace, c.q, c.v, g);
    expect_near(*geodesic_acceleration(m, c.workspace, c.q, c.v), free, tolerance);
    const VectorXd gradient = *potential_gradient(m, c.workspace, c.q);
    const VectorXd fall = *forward_dynamics(m, c.workspace, c.q, c.v, VectorXd::Zero(m.dof()));
    expect_near(free - gradient, fall, tolerance);
  });
}

TEST(MechanismConnection, ParallelFieldsKeepTheirProducts) {
  // d<Y, Z>/dt = <DY/dt, Z> + <Y, DZ/dt> along a curve with fields that change.
  on_random_cases([](RandomCase& c) {
    const Mechanism& m = c.mechanism;
    const VectorXd y = c.random.vector(m.dof()), dy = c.random.vector(m.dof());
    const VectorXd z = c.random.vector(m.dof()), dz = c.random.vector(m.dof());
    const MatrixXd expected = rate([&](double t) -> MatrixXd {
      const MatrixXd g = metric(m, c.workspace, c.moved(c.v, t));
      return (y + t * dy).transpose() * g * (z + t * dz);
    });
    const VectorXd along_y = *covariant_derivative(m, c.workspace, c.q, c.v, y, dy);
    const VectorXd along_z = *covariant_derivative(m, c.workspace, c.q, c.v, z, dz);
    const MatrixXd g = metric(m, c.workspace, c.q);
    const double found = along_y.dot(g * z) + y.dot(g * along_z);
    EXPECT_NEAR(found, expected(0, 0), 1e-9 * (1.0 + std::abs(found)));
  });
}

}  // namespace
}  // namespace geodesic::control
