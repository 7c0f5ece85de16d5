// Changes of coordinates: laws of transformation against the same quantities computed afresh in the
// new coordinates, under random smooth maps, for Lagrangians and for a mechanism.
#include "control/geometry/chart_change.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

#include "control/geometry/lagrangian.hpp"
#include "control/mechanism/dynamics.hpp"
#include "tests/control/mechanism/random_tree.hpp"

namespace geodesic::control {
namespace {

constexpr int kN = 3;
using Vector = ChartVector<kN>;
using Matrix = ChartMatrix<kN>;

template <class S>
using Point = Eigen::Matrix<S, kN, 1>;

/// A random smooth map with a smooth inverse: shears q_i += a sin(b q_j + c), i != j, each of which
/// is undone by itself, after a linear map.
class Diffeomorphism {
 public:
  explicit Diffeomorphism(unsigned seed) {
    std::mt19937 engine(seed);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    for (int i = 0; i < kN; ++i) {
      for (int j = 0; j < kN; ++j) linear_(i, j) = (i == j ? 2.0 : 0.0) + 0.6 * uniform(engine);
    }
    back_ = linear_.inverse();
    for (std::size_t n = 0; n < shears_.size(); ++n) {
      const int i = static_cast<int>(n) % kN;
      const int j = (i + 1 + static_cast<int>(n / kN) % (kN - 1)) % kN;
      shears_[n] = {i, j, 0.7 * uniform(engine), 1.5 * uniform(engine), 3.0 * uniform(engine)};
    }
  }

  template <class S>
  Point<S> forward(const Point<S>& q) const {
    Point<S> x = linear_ * q;
    for (const auto& shear : shears_) x[shear.i] += shear.of(x[shear.j]);
    return x;
  }

  template <class S>
  Point<S> backward(Point<S> x) const {
    for (auto shear = shears_.rbegin(); shear != shears_.rend(); ++shear) {
      x[shear->i] -= shear->of(x[shear->j]);
    }
    return back_ * x;
  }

 private:
  struct Shear {
    int i, j;
    double a, b, c;
    template <class S>
    S of(const S& y) const {
      using std::sin;
      return a * sin(b * y + c);
    }
  };

  Matrix linear_, back_;
  std::array<Shear, 6> shears_;
};

/// Some dense metric and potential.
struct System {
  template <class S>
  S operator()(const Point<S>& q, const Point<S>& v) const {
    using std::cos;
    using std::sin;
    const S a = v[0] + sin(q[1]) * v[2], b = (2.0 + cos(q[0])) * v[1] - q[2] * v[0];
    return 0.5 * (a * a + b * b + 0.4 * v.dot(v)) - sin(q[0] + q[2]) * q[1];
  }
};

template <int N>
double distance(const ChartTensor3<N>& a, const ChartTensor3<N>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < N; ++i) sum += (a.slice[i] - b.slice[i]).squaredNorm();
  return std::sqrt(sum);
}

double relative(const Vector& a, const Vector& b) {
  return (a - b).norm() / (1.0 + b.norm());
}

struct Draw {
  explicit Draw(unsigned seed) : map(seed) {
    testing::RandomArm random(seed + 1000);
    q = random.vector(kN);
    v = random.vector(kN);
    w = random.vector(kN);
    tau = random.vector(kN);
  }
  Diffeomorphism map;
  Vector q, v, w, tau;
};

TEST(ChartChange, LawsAgreeWithTheLagrangianWrittenInTheNewCoordinates) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const Draw d(seed);
    const auto forward = [&](const auto& q) { return d.map.forward(q); };
    const auto backward = [&](const auto& x) { return d.map.backward(x); };
    const auto old = lagrangian<kN>(System{});
    const auto fresh =
        lagrangian<kN>(LagrangianInChart<System, decltype(backward)>{System{}, backward});
    const auto change = *chart_change<kN>(forward, d.q);
    const Vector x = forward(d.q), v = change.velocity(d.v), w = change.velocity(d.w);
    EXPECT_LE(relative(backward(x), d.q), 1e-13);
    const Matrix m = old.metric(d.q);

    // Numbers that are nobody's coordinates stay.
    EXPECT_NEAR(fresh.kinetic_energy(x, v), old.kinetic_energy(d.q, d.v), 1e-12);
    EXPECT_NEAR(fresh.potential_energy(x), old.potential_energy(d.q), 1e-13);
    EXPECT_NEAR(change.covector(d.tau).dot(v), d.tau.dot(d.v), 1e-13);
    const double k = *old.sectional_curvature(d.q, d.v, d.w);
    EXPECT_NEAR(*fresh.sectional_curvature(x, v, w), k, 1e-10 * (1.0 + std::abs(k)));

    EXPECT_LE((fresh.metric(x) - change.metric(m)).norm(), 1e-12);
    EXPECT_LE(relative(fresh.momentum(x, v), change.covector(old.momentum(d.q, d.v))), 1e-12);
    EXPECT_LE(
        relative(fresh.potential_differential(x), change.covector(old.potential_differential(d.q))),
        1e-12);
    const auto first = old.christoffel_first_kind(d.q);
    const auto second = *old.christoffel_second_kind(d.q);
    EXPECT_LE(
        distance<kN>(fresh.christoffel_first_kind(x), change.christoffel_first_kind(first, m)),
        1e-11);
    EXPECT_LE(
        distance<kN>(*fresh.christoffel_second_kind(x), change.christoffel_second_kind(second)),
        1e-11);
    const auto riemann = change.covariant(*old.riemann_curvature(d.q));
    const auto afresh = *fresh.riemann_curvature(x);
    for (std::size_t i = 0; i < kN; ++i) {
      EXPECT_LE(distance<kN>(afresh.slice[i], riemann.slice[i]), 1e-10);
    }

    // The same motion: equations of motion commute with the change.
    const Vector a = *old.forward_dynamics(d.q, d.v, d.tau);
    EXPECT_LE(relative(*fresh.forward_dynamics(x, v, change.covector(d.tau)),
                       change.acceleration(d.v, a)),
              1e-11);
    const Vector free = geodesic_acceleration<kN>(second, d.v);
    EXPECT_LE(relative(geodesic_acceleration<kN>(*fresh.christoffel_second_kind(x), v),
                       change.acceleration(d.v, free)),
              1e-11);
    EXPECT_LE(relative(fresh.euler_lagrange(x, v, change.acceleration(d.v, d.w)),
                       change.covector(old.euler_lagrange(d.q, d.v, d.w))),
              1e-11);
  }
}

TEST(ChartChange, BackAndForthIsNoChange) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const Draw d(seed);
    const auto forward = [&](const auto& q) { return d.map.forward(q); };
    const auto backward = [&](const auto& x) { return d.map.backward(x); };
    const auto change = *chart_change<kN>(forward, d.q);
    const auto back = *chart_change<kN>(backward, Vector(forward(d.q)));
    EXPECT_LE((back.jacobian - change.inverse().jacobian).norm(), 1e-12);
    EXPECT_LE(distance<kN>(back.hessian, change.inverse().hessian), 1e-11);
    const Vector a = change.acceleration(d.v, d.w);
    EXPECT_LE(relative(change.inverse().acceleration(change.velocity(d.v), a), d.w), 1e-12);
    const auto symbols = *lagrangian<kN>(System{}).christoffel_second_kind(d.q);
    EXPECT_LE(distance<kN>(
                  change.inverse().christoffel_second_kind(change.christoffel_second_kind(symbols)),
                  symbols),
              1e-12);
  }
}

TEST(ChartChange, JacobianAndHessianAgreeWithFiniteDifferences) {
  const Draw d(7);
  const auto forward = [&](const auto& q) { return d.map.forward(q); };
  const auto change = *chart_change<kN>(forward, d.q);
  const double h = 1e-4;
  for (int j = 0; j < kN; ++j) {
    const Vector e = h * Vector::Unit(j);
    const Vector ahead = forward(Vector(d.q + e)), behind = forward(Vector(d.q - e));
    EXPECT_LE((change.jacobian.col(j) - (ahead - behind) / (2.0 * h)).norm(), 1e-7);
    const Matrix bend = (chart_change<kN>(forward, d.q + e)->jacobian -
                         chart_change<kN>(forward, d.q - e)->jacobian) /
                        (2.0 * h);
    for (int a = 0; a < kN; ++a) {
      for (int k = 0; k < kN; ++k) EXPECT_NEAR(change.hessian(a, j, k), bend(a, k), 1e-7);
    }
  }
}

TEST(ChartChange, FoldsAreNoChangeOfCoordinates) {
  const auto fold = [](const auto& q) {
    auto x = q;
    x[1] = q[1] * q[1];
    return x;
  };
  EXPECT_FALSE(chart_change<kN>(fold, Vector(1.0, 0.0, 2.0)).has_value());
  EXPECT_TRUE(chart_change<kN>(fold, Vector(1.0, 0.1, 2.0)).has_value());
}

/// A tree's metric and symbols at a point, as numbers. What they become is checked against finite
/// differences of the transformed metric, and by integrating nothing: the tree's own forward
/// dynamics.
TEST(ChartChange, OfAMechanism) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    testing::RandomArm random(seed);
    testing::RandomTreeOptions shape;
    shape.joints = kN;
    const Mechanism tree(random.tree(shape), Eigen::Vector3d(0.3, 1.0, -9.7));
    ASSERT_EQ(tree.dof(), kN);
    ASSERT_EQ(tree.nq(), kN);
    Workspace workspace(tree);
    const Draw d(seed);
    const auto forward = [&](const auto& q) { return d.map.forward(q); };
    const auto change = *chart_change<kN>(forward, d.q);
    Christoffel numbers(tree);
    christoffel_symbols(tree, workspace, d.q, numbers);
    const auto first = ChartTensor3<kN>::of(numbers);
    const Matrix m = metric(tree, workspace, d.q), fresh = change.metric(m);
    const auto fresh_first = change.christoffel_first_kind(first, m);
    const Vector v = change.velocity(d.v);
    EXPECT_NEAR(0.5 * v.dot(fresh * v), kinetic_energy(tree, workspace, d.q, d.v), 1e-12);

    // The metric's change along x, by differences in the old coordinates: the symbols' sum.
    const double h = 1e-4;
    for (int k = 0; k < kN; ++k) {
      const auto metric_at = [&](double step) -> Matrix {
        const Vector q = d.map.backward(Vector(forward(d.q) + step * Vector::Unit(k)));
        return chart_change<kN>(forward, q)->metric(metric(tree, workspace, q));
      };
      const Matrix slope = (metric_at(h) - metric_at(-h)) / (2.0 * h);
      for (int i = 0; i < kN; ++i) {
        for (int j = 0; j < kN; ++j) {
          EXPECT_NEAR(fresh_first(i, j, k) + fresh_first(j, i, k), slope(i, j), 1e-6);
        }
      }
    }

    // Forward dynamics in the new numbers is forward dynamics in the old, changed.
    const Vector g = gravity(tree, workspace, d.q);
    const Vector a = *forward_dynamics(tree, workspace, d.q, d.v, d.tau);
    const Vector fresh_a = fresh.inverse() * (change.covector(d.tau) - change.covector(g) -
                                              coriolis_matrix<kN>(fresh_first, v) * v);
    EXPECT_LE(relative(fresh_a, change.acceleration(d.v, a)), 1e-10) << "seed " << seed;
  }
}

}  // namespace
}  // namespace geodesic::control
