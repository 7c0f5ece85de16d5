// One suite for every Lie group: its axioms, exp and log at every angle, Ad and ad, the Jacobians
// of exp, distance and interpolation. The reference is the power series of matrices in 64-bit
// mantissas, which knows nothing of any group.
#include "control/geometry/lie_group.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "control/geometry/product.hpp"
#include "control/geometry/r.hpp"
#include "control/geometry/se2.hpp"
#include "control/geometry/se3.hpp"
#include "control/geometry/so2.hpp"
#include "control/geometry/so3.hpp"

namespace geodesic::control {
namespace {

constexpr double kEps = std::numeric_limits<double>::epsilon();
constexpr double kPi = std::numbers::pi;

/// How many of a tangent's last numbers are angular.
template <class G>
constexpr int kAngular = 0;
template <>
constexpr int kAngular<SO2> = 1;
template <>
constexpr int kAngular<SE2> = 1;
template <>
constexpr int kAngular<PlanarJoint> = 1;
template <>
constexpr int kAngular<SO3> = 3;
template <>
constexpr int kAngular<SE3> = 3;
template <>
constexpr int kAngular<Product<R, SO3>> = 3;

template <int n>
using Long = Eigen::Matrix<long double, n, n>;

/// Sum of x^k / (k + shift)!: exp for 0; of ad it is the left Jacobian for 1.
template <int n>
Long<n> series(const Eigen::Matrix<double, n, n>& x, int shift) {
  const Long<n> a = x.template cast<long double>();
  Long<n> term = Long<n>::Identity();
  Long<n> sum = term;
  for (int k = 1; k < 80; ++k) {
    term = term * a / static_cast<long double>(k + shift);
    sum += term;
  }
  return sum;
}

/// Through zero, the switch to series, and pi from below.
constexpr double kAngles[] = {
    0.0,  1e-300, 1e-160,     1e-100,     1e-20,      1e-12,       1e-8,       1e-6,  1e-4,
    1e-2, 0.3,    0.83,       1.0,        1.0001,     1.999,       2.0,        2.001, 2.5,
    3.0,  3.1,    kPi - 1e-3, kPi - 1e-6, kPi - 1e-9, kPi - 1e-12, kPi - 1e-14};

template <class G>
class LieGroupTest : public ::testing::Test {
 protected:
  using Element = typename G::Element;
  using Tangent = typename G::Tangent;
  static constexpr int kN = G::kDimension;
  static constexpr int kRows = G::Algebra::RowsAtCompileTime;

  Tangent tangent(double angle) {
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    Tangent x;
    for (int i = 0; i < kN; ++i) {
      x[i] = uniform(engine_);
    }
    if constexpr (kAngular < G >> 0) {
      auto turn = x.template tail<kAngular<G>>();
      const double length = turn.norm();
      for (int i = 0; i < kAngular<G>; ++i) {
        turn[i] = angle * (turn[i] / length);
      }
    }
    return x;
  }
  static double angle_of(const Tangent& x) {
    if constexpr (kAngular < G >> 0) {
      return x.template tail<kAngular<G>>().stableNorm();
    } else {
      return 0.0;
    }
  }
  Element element() { return G::random(engine_); }

  std::mt19937 engine_{20261122};
};

template <class A, class B>
double apart(const Eigen::MatrixBase<A>& found, const Eigen::MatrixBase<B>& expected) {
  const auto difference =
      found.template cast<long double>() - expected.template cast<long double>();
  return static_cast<double>(difference.cwiseAbs().maxCoeff());
}

using Groups = ::testing::Types<R, R2, Translations<3>, SO2, SO3, SE2, SE3, PlanarJoint,
                                Product<R, SO3>, Product<SE3, SO2>>;
TYPED_TEST_SUITE(LieGroupTest, Groups);

TYPED_TEST(LieGroupTest, IsAGroup) {
  using G = TypeParam;
  for (int i = 0; i < 50; ++i) {
    const auto a = this->element();
    const auto b = this->element();
    const auto c = this->element();
    const auto ab = G::matrix(G::compose(a, b));
    EXPECT_LE(apart(ab, G::matrix(a) * G::matrix(b)), 8.0 * kEps);
    EXPECT_LE(apart(G::matrix(G::compose(G::compose(a, b), c)),
                    G::matrix(G::compose(a, G::compose(b, c)))),
              16.0 * kEps);
    EXPECT_LE(apart(G::matrix(G::compose(a, G::inverse(a))), G::Algebra::Identity()), 8.0 * kEps);
    EXPECT_LE(apart(G::matrix(G::compose(G::inverse(a), a)), G::Algebra::Identity()), 8.0 * kEps);
    EXPECT_EQ(apart(G::matrix(G::compose(a, G::identity())), G::matrix(a)), 0.0);
  }
  EXPECT_EQ(apart(G::matrix(G::identity()), G::Algebra::Identity()), 0.0);
}

TYPED_TEST(LieGroupTest, VeeUndoesHat) {
  using G = TypeParam;
  const auto x = this->tangent(1.3);
  EXPECT_EQ(apart(G::vee(G::hat(x)), x), 0.0);
}

TYPED_TEST(LieGroupTest, ExpIsThePowerSeriesOfTheMatrix) {
  using G = TypeParam;
  for (const double angle : kAngles) {
    const auto x = this->tangent(angle);
    EXPECT_LE(apart(G::matrix(G::exp(x)), series(G::hat(x), 0)), 6.0 * kEps) << angle;
  }
  for (const double angle : {kPi, 3.2, 3.25, 3.26, 4.0, 6.0}) {
    const auto x = this->tangent(angle);
    EXPECT_LE(apart(G::matrix(G::exp(x)), series(G::hat(x), 0)), 10.0 * kEps) << angle;
  }
}

TYPED_TEST(LieGroupTest, LogUndoesExpAtEveryAngle) {
  using G = TypeParam;
  for (const double angle : kAngles) {
    for (int i = 0; i < 20; ++i) {
      const auto x = this->tangent(angle);
      const auto found = G::log(G::exp(x));
      EXPECT_LE(apart(found, x), 12.0 * kEps) << angle;
      const double error = this->angle_of(found - x);
      EXPECT_LE(error, 4.0 * kEps * angle) << "relative to the angle " << angle;
    }
  }
}

TYPED_TEST(LieGroupTest, ExpUndoesLogAlsoAtHalfTurns) {
  using G = TypeParam;
  for (int i = 0; i < 200; ++i) {
    const auto g = i % 2 == 0 ? this->element() : G::exp(this->tangent(kPi));
    const auto x = G::log(g);
    EXPECT_LE(this->angle_of(x), kPi * (1.0 + 2.0 * kEps));
    EXPECT_LE(apart(G::matrix(G::exp(x)), G::matrix(g)), 12.0 * kEps);
  }
}

TYPED_TEST(LieGroupTest, AdIsConjugationAndAHomomorphism) {
  using G = TypeParam;
  for (int i = 0; i < 50; ++i) {
    const auto a = this->element();
    const auto b = this->element();
    const auto x = this->tangent(1.7);
    EXPECT_LE(apart(G::hat(G::Ad(a) * x), G::matrix(a) * G::hat(x) * G::matrix(G::inverse(a))),
              24.0 * kEps);
    EXPECT_LE(apart(G::Ad(G::compose(a, b)), G::Ad(a) * G::Ad(b)), 24.0 * kEps);
  }
}

TYPED_TEST(LieGroupTest, AdIsTheBracketAndSatisfiesJacobi) {
  using G = TypeParam;
  for (int i = 0; i < 50; ++i) {
    const auto x = this->tangent(1.0);
    const auto y = this->tangent(2.0);
    const auto z = this->tangent(0.5);
    EXPECT_LE(apart(G::hat(G::ad(x) * y), G::hat(x) * G::hat(y) - G::hat(y) * G::hat(x)),
              16.0 * kEps);
    EXPECT_LE(apart(G::ad(x) * y, -G::ad(y) * x), 8.0 * kEps);
    EXPECT_LE(apart(G::ad(x) * (G::ad(y) * z), G::ad(G::ad(x) * y) * z + G::ad(y) * (G::ad(x) * z)),
              32.0 * kEps);
  }
}

TYPED_TEST(LieGroupTest, AdOfExpIsExpOfAd) {
  using G = TypeParam;
  for (const double angle : kAngles) {
    const auto x = this->tangent(angle);
    EXPECT_LE(apart(G::Ad(G::exp(x)), series(G::ad(x), 0)), 16.0 * kEps) << angle;
  }
}

TYPED_TEST(LieGroupTest, JacobiansAreTheirSeriesAndTheInversesInvert) {
  using G = TypeParam;
  for (const double angle : kAngles) {
    const auto x = this->tangent(angle);
    const auto left = series(G::ad(x), 1);
    EXPECT_LE(apart(G::left_jacobian(x), left), 12.0 * kEps) << angle;
    EXPECT_LE(apart(G::left_jacobian_inverse(x), left.inverse()), 24.0 * kEps) << angle;
    const typename G::Tangent back = -x;
    const auto right = series(G::ad(back), 1);
    EXPECT_LE(apart(right_jacobian_of<G>(x), right), 12.0 * kEps) << angle;
    EXPECT_LE(apart(right_jacobian_inverse_of<G>(x), right.inverse()), 24.0 * kEps) << angle;
    EXPECT_LE(apart(G::left_jacobian(x), G::Ad(G::exp(x)) * right_jacobian_of<G>(x)), 32.0 * kEps);
  }
}

TYPED_TEST(LieGroupTest, LeftJacobianIsTheDerivativeOfExp) {
  using G = TypeParam;
  constexpr long double kStep = 1e-5L;
  for (const double angle : {1e-9, 0.4, 1.8, 3.0}) {
    const auto x = this->tangent(angle);
    const auto d = this->tangent(1.0);
    // Central difference of the matrices' series in long double: its error is about step^2.
    const auto moved = [&](long double by) {
      const auto m =
          (G::hat(x).template cast<long double>() + by * G::hat(d).template cast<long double>())
              .eval();
      auto term = m;
      term.setIdentity();
      auto sum = term;
      for (int k = 1; k < 80; ++k) {
        term = (term * m / static_cast<long double>(k)).eval();
        sum += term;
      }
      return sum;
    };
    const auto rate = ((moved(kStep) - moved(-kStep)) / (2.0L * kStep)).eval();
    const auto twist = (rate * moved(0.0L).inverse()).template cast<double>().eval();
    const typename G::Tangent predicted = G::left_jacobian(x) * d;
    EXPECT_LE(apart(G::hat(predicted), twist), 2e-9) << angle;
  }
}

TYPED_TEST(LieGroupTest, InterpolationRunsAtConstantSpeedFromEndToEnd) {
  using G = TypeParam;
  for (int i = 0; i < 20; ++i) {
    const auto a = this->element();
    const auto b = this->element();
    EXPECT_LE(apart(G::matrix(interpolate<G>(a, b, 0.0)), G::matrix(a)), 8.0 * kEps);
    EXPECT_LE(apart(G::matrix(interpolate<G>(a, b, 1.0)), G::matrix(b)), 24.0 * kEps);
    const auto whole = difference_of<G>(a, b);
    for (const double share : {0.1, 0.5, 0.85}) {
      const auto on_the_way = interpolate<G>(a, b, share);
      const auto next = interpolate<G>(a, b, share + 0.1);
      EXPECT_LE(apart(difference_of<G>(on_the_way, next), 0.1 * whole), 64.0 * kEps);
    }
  }
}

TYPED_TEST(LieGroupTest, DistanceIsAMetricThatMotionsFromTheLeftKeep) {
  using G = TypeParam;
  constexpr double kRadius = 0.4;
  for (int i = 0; i < 50; ++i) {
    const auto a = this->element();
    const auto b = this->element();
    const auto c = this->element();
    const double ab = G::distance(a, b, kRadius);
    EXPECT_GT(ab, 0.0);
    EXPECT_NEAR(G::distance(a, a, kRadius), 0.0, 8.0 * kEps);
    EXPECT_NEAR(G::distance(b, a, kRadius), ab, 16.0 * kEps);
    EXPECT_LE(ab, G::distance(a, c, kRadius) + G::distance(c, b, kRadius) + 16.0 * kEps);
    EXPECT_NEAR(G::distance(G::compose(c, a), G::compose(c, b), kRadius), ab, 32.0 * kEps);
  }
}

/// Kolmogorov and Smirnov's distance between samples and a distribution on [0, 1].
double misfit(std::vector<double> samples) {
  std::sort(samples.begin(), samples.end());
  double worst = 0.0;
  const auto n = static_cast<double>(samples.size());
  for (std::size_t i = 0; i < samples.size(); ++i) {
    worst = std::max({worst, std::abs(samples[i] - static_cast<double>(i) / n),
                      std::abs(samples[i] - static_cast<double>(i + 1) / n)});
  }
  return worst;
}

TEST(LieGroupRandom, RotationsAreSpreadByHaarsMeasure) {
  // Under it the angle t of a rotation has the distribution (t - sin t) / pi, and so it has after
  // any rotation from the left. A misfit of 1.95 / sqrt(n) happens once in a thousand.
  std::mt19937 engine(7);
  const Eigen::Quaterniond fixed = quaternion_exp(Eigen::Vector3d(0.4, -1.2, 0.9));
  std::vector<double> angle;
  std::vector<double> moved_angle;
  std::vector<double> circle;
  for (int i = 0; i < 20000; ++i) {
    const Eigen::Quaterniond q = SO3::random(engine);
    EXPECT_NEAR(q.norm(), 1.0, 4.0 * kEps);
    const double t = log(q).norm();
    const double moved = log(fixed * q).norm();
    angle.push_back((t - std::sin(t)) / kPi);
    moved_angle.push_back((moved - std::sin(moved)) / kPi);
    circle.push_back(0.5 + SO2::log(SO2::random(engine))[0] / (2.0 * kPi));
  }
  const double bound = 1.95 / std::sqrt(20000.0);
  EXPECT_LE(misfit(angle), bound);
  EXPECT_LE(misfit(moved_angle), bound);
  EXPECT_LE(misfit(circle), bound);
}

TEST(LieGroupRotation, LogOfTheMatrixIsThatOfTheQuaternion) {
  std::mt19937 engine(8);
  for (const double angle : {1e-300, 1e-9, 0.1, 1.0, 2.09, 2.1, 3.0, kPi - 1e-9, kPi - 1e-14}) {
    for (int i = 0; i < 20; ++i) {
      const Eigen::Vector3d w = angle * (random_rotation(engine) * Eigen::Vector3d::UnitZ());
      EXPECT_LE((log(exp(w)) - w).stableNorm(), 6.0 * kEps * angle) << angle;
      EXPECT_LE((log(quaternion_exp(w)) - w).stableNorm(), 4.0 * kEps * angle) << angle;
    }
  }
  // The half turns about the axes have matrices without a skew part at all.
  for (int i = 0; i < 3; ++i) {
    Eigen::Matrix3d half = -Eigen::Matrix3d::Identity();
    half(i, i) = 1.0;
    EXPECT_EQ(log(half), kPi * Eigen::Vector3d::Unit(i));
  }
  EXPECT_EQ(log(Eigen::Matrix3d::Identity().eval()), Eigen::Vector3d::Zero());
  const Eigen::Quaterniond other(-2.0 * quaternion_exp(Eigen::Vector3d(0.1, 0.2, 0.3)).coeffs());
  EXPECT_LE((log(other) - Eigen::Vector3d(0.1, 0.2, 0.3)).norm(), kEps) << "-2 q turns as q does";
}

TEST(LieGroupRotation, TheShorterWayRound) {
  EXPECT_NEAR(shortest_turn(3.0, -3.0), 2.0 * kPi - 6.0, 2.0 * kEps);
  EXPECT_EQ(shortest_turn(0.25, 0.75), 0.5);
  EXPECT_NEAR(shortest_turn(-20.0, 20.0), 40.0 - 12.0 * kPi, 1e-14);
}

}  // namespace
}  // namespace geodesic::control
