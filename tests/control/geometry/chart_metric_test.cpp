// Connection and curvature of metrics whose symbols and curvatures are known, and the identities
// that hold for any: symmetry, compatibility, Bianchi.
#include "control/geometry/chart_metric.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "control/geometry/lagrangian.hpp"

namespace geodesic::control {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Vector4d = Eigen::Matrix<double, 4, 1>;

/// diag(1 + q2^2, 1), the metric of the helicoid: its symbols fit on a line.
TEST(ChartMetric, OfTheHelicoid) {
  const auto system = lagrangian<2>([](const auto& q, const auto& v) {
    return 0.5 * ((1.0 + q[1] * q[1]) * v[0] * v[0] + v[1] * v[1]);
  });
  for (const double y : {-1.3, 0.0, 0.4, 2.0}) {
    const Vector2d q(0.7, y), v(1.2, -0.8);
    const double w = 1.0 + y * y;
    const auto first = system.christoffel_first_kind(q);
    const auto second = *system.christoffel_second_kind(q);
    const auto known_first = ChartTensor3<2>::of([&](int i, int j, int k) {
      return i == 0 && j != k ? y : i == 1 && j == 0 && k == 0 ? -y : 0.0;
    });
    for (int i = 0; i < 2; ++i) {
      for (int j = 0; j < 2; ++j) {
        for (int k = 0; k < 2; ++k) {
          EXPECT_NEAR(first(i, j, k), known_first(i, j, k), 1e-15);
          EXPECT_NEAR(second(i, j, k), known_first(i, j, k) / (i == 0 ? w : 1.0), 1e-15);
        }
      }
    }
    const Vector2d free(-2.0 * y / w * v[0] * v[1], y * v[0] * v[0]);
    EXPECT_LE((geodesic_acceleration<2>(second, v) - free).norm(), 1e-15);
    EXPECT_LE((*system.forward_dynamics(q, v, Vector2d::Zero()) - free).norm(), 1e-15);
    // A field along the curve that is the curve's velocity, without acceleration, is not parallel.
    EXPECT_LE((covariant_derivative<2>(second, v, v, free)).norm(), 1e-15);
    EXPECT_NEAR(*system.sectional_curvature(q, v, Vector2d(0.3, 1.0)), -1.0 / (w * w), 1e-15);
  }
}

TEST(ChartMetric, SpheresAreCurvedByOneOverRadiusSquared) {
  const double r = 1.7;
  const auto sphere2 = lagrangian<2>([=](const auto& q, const auto& v) {
    using std::sin;
    const auto east = sin(q[0]) * v[1];
    return 0.5 * r * r * (v[0] * v[0] + east * east);
  });
  EXPECT_NEAR(*sphere2.sectional_curvature({0.8, 2.0}, {1.0, 0.3}, {0.2, -1.0}), 1.0 / (r * r),
              1e-14);
  EXPECT_GT((*sphere2.riemann_curvature({0.8, 2.0}))(0, 1, 0, 1), 0.0);
  const auto sphere3 = lagrangian<3>([=](const auto& q, const auto& v) {
    using std::sin;
    const auto b = sin(q[0]) * v[1], c = sin(q[0]) * sin(q[1]) * v[2];
    return 0.5 * r * r * (v[0] * v[0] + b * b + c * c);
  });
  const Vector3d q(0.9, 1.3, -2.0);
  EXPECT_NEAR(*sphere3.sectional_curvature(q, {1.0, 0.3, -0.5}, {0.2, -1.0, 0.7}), 1.0 / (r * r),
              1e-13);
}

TEST(ChartMetric, HyperbolicSpaceIsCurvedByMinusOne) {
  const auto half_space =
      lagrangian<4>([](const auto& q, const auto& v) { return 0.5 * v.dot(v) / (q[3] * q[3]); });
  const Vector4d q(0.3, -1.0, 0.5, 0.8);
  EXPECT_NEAR(*half_space.sectional_curvature(q, {1.0, 0.3, -0.5, 0.9}, {0.2, -1.0, 0.7, 0.1}),
              -1.0, 1e-13);
}

TEST(ChartMetric, FlatSpaceIsFlatInSphericalCoordinates) {
  const auto space = lagrangian<3>([](const auto& q, const auto& v) {
    using std::sin;
    const auto b = q[0] * v[1], c = q[0] * sin(q[1]) * v[2];
    return 0.5 * (v[0] * v[0] + b * b + c * c);
  });
  const auto riemann = *space.riemann_curvature({1.4, 0.7, 2.2});
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      for (int k = 0; k < 3; ++k) {
        for (int l = 0; l < 3; ++l) EXPECT_NEAR(riemann(i, j, k, l), 0.0, 1e-14);
      }
    }
  }
}

/// A product of manifolds has flat planes across its factors.
TEST(ChartMetric, ProductsAreFlatAcrossFactors) {
  const auto product = lagrangian<4>([](const auto& q, const auto& v) {
    using std::cosh;
    using std::sin;
    const auto a = sin(q[0]) * v[1], b = cosh(q[2]) * v[3];
    return 0.5 * (v[0] * v[0] + a * a + v[2] * v[2] + b * b);
  });
  const Vector4d q(0.9, 0.0, 0.4, 1.0);
  EXPECT_NEAR(*product.sectional_curvature(q, {1.0, 0.5, 0.0, 0.0}, {0.0, 0.0, 0.3, -1.0}), 0.0,
              1e-14);
  EXPECT_NEAR(*product.sectional_curvature(q, {1.0, 0.5, 0.0, 0.0}, {0.3, -1.0, 0.0, 0.0}), 1.0,
              1e-13);
  EXPECT_NEAR(*product.sectional_curvature(q, {0.0, 0.0, 1.0, 0.5}, {0.0, 0.0, 0.3, -1.0}), -1.0,
              1e-13);
}

/// A dense metric, J'J of a made-up map's derivative plus a constant.
struct Dense {
  template <class S>
  S operator()(const Eigen::Matrix<S, 4, 1>& q, const Eigen::Matrix<S, 4, 1>& v) const {
    using std::cos;
    using std::exp;
    using std::sin;
    const S a = sin(q[0] * q[3]) * v[1] + v[0] * cos(q[2]);
    const S b = exp(0.4 * q[1]) * v[2] - q[0] * v[3];
    const S c = (q[2] * q[3]) * v[0] + sin(q[1]) * v[3];
    return 0.5 * (v.dot(v) + a * a + b * b + c * c);
  }
};

TEST(ChartMetric, IdentitiesOfAnyMetric) {
  const auto system = lagrangian<4>(Dense{});
  const Vector4d q(0.5, -0.8, 1.1, 0.7);
  const auto at = system.chart_metric(q);
  const auto first = system.christoffel_first_kind(q);
  const auto second = *system.christoffel_second_kind(q);
  const auto r = *system.riemann_curvature(q);
  double largest = 0.0;
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) {
      for (int k = 0; k < 4; ++k) {
        EXPECT_NEAR(second(i, j, k), second(i, k, j), 1e-15) << "torsion";
        // D_k M_ij = dM_ij/dq_k - Gamma^m_ki M_mj - Gamma^m_kj M_im
        double compatibility = at.derivative(k, i, j);
        for (int m = 0; m < 4; ++m) {
          compatibility -= second(m, k, i) * at.metric(m, j) + second(m, k, j) * at.metric(i, m);
        }
        EXPECT_NEAR(compatibility, 0.0, 1e-14);
        EXPECT_NEAR(first(i, j, k) + first(j, i, k), at.derivative(k, i, j), 1e-15);
        for (int l = 0; l < 4; ++l) {
          EXPECT_NEAR(r(i, j, k, l), -r(j, i, k, l), 1e-13);
          EXPECT_NEAR(r(i, j, k, l), -r(i, j, l, k), 1e-13);
          EXPECT_NEAR(r(i, j, k, l), r(k, l, i, j), 1e-13);
          EXPECT_NEAR(r(i, j, k, l) + r(i, k, l, j) + r(i, l, j, k), 0.0, 1e-13) << "Bianchi";
          largest = std::max(largest, std::abs(r(i, j, k, l)));
        }
      }
    }
  }
  EXPECT_GT(largest, 0.1) << "a flat metric proves nothing";
}

/// R(X, Y) Z by its definition: covariant derivatives that do not commute, of symbols' differences.
TEST(ChartMetric, CurvatureIsWhatCovariantDerivativesDoNotCommuteBy) {
  const auto system = lagrangian<4>(Dense{});
  const Vector4d q(0.5, -0.8, 1.1, 0.7);
  const auto g = *system.christoffel_second_kind(q);
  const auto r = *system.riemann_curvature(q);
  const auto metric = system.metric(q);
  const double h = 1e-4;
  const auto slope = [&](int direction) {
    const Vector4d e = h * Vector4d::Unit(direction);
    const auto ahead = *system.christoffel_second_kind(q + e);
    const auto behind = *system.christoffel_second_kind(q - e);
    return ChartTensor3<4>::of(
        [&](int i, int j, int k) { return (ahead(i, j, k) - behind(i, j, k)) / (2.0 * h); });
  };
  for (int k = 0; k < 4; ++k) {
    for (int l = 0; l < 4; ++l) {
      const auto dk = slope(k), dl = slope(l);
      for (int j = 0; j < 4; ++j) {
        Vector4d vector;  // R(d_k, d_l) d_j
        for (int i = 0; i < 4; ++i) {
          vector[i] = dk(i, l, j) - dl(i, k, j);
          for (int m = 0; m < 4; ++m)
            vector[i] += g(i, k, m) * g(m, l, j) - g(i, l, m) * g(m, k, j);
        }
        const Vector4d lowered = metric * vector;
        for (int i = 0; i < 4; ++i) EXPECT_NEAR(r(i, j, k, l), lowered[i], 1e-6);
      }
    }
  }
}

TEST(ChartMetric, SingularMatricesHaveNoInverse) {
  Eigen::Matrix2d m;
  m << 1.0, 2.0, 2.0, 4.0;
  EXPECT_FALSE(invert<2>(m).has_value());
  m(0, 0) = std::nan("");
  EXPECT_FALSE(invert<2>(m).has_value());
  m << 1.0, 0.0, 0.0, -1.0;  // indefinite is no reason
  EXPECT_TRUE(invert<2>(m).has_value());
}

}  // namespace
}  // namespace geodesic::control
