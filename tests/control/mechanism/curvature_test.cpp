// Curvature by Gauss' equation against its definition with derivatives of the connection by
// differences, against its symmetries and both Bianchi identities, and against known spaces.
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

std::vector<MatrixXd> second_kind(const Mechanism& m, Workspace& w, const VectorXd& q) {
  Christoffel symbols(m);
  EXPECT_TRUE(christoffel_second_kind(m, w, q, symbols));
  std::vector<MatrixXd> slices;
  for (int k = 0; k < m.dof(); ++k) {
    slices.push_back(symbols.slice(k));
  }
  return slices;
}

/// R(E_k, E_l) as a matrix of endomorphisms, (i, j) -> component i of R E_j; number k n + l.
std::vector<MatrixXd> curvature_matrices(const Mechanism& m, Workspace& w, const VectorXd& q) {
  RiemannTensor tensor(m);
  EXPECT_TRUE(riemann_tensor(m, w, q, tensor));
  const MatrixXd inverse = *metric_inverse(m, w, q);
  const int n = m.dof();
  std::vector<MatrixXd> result;
  for (int k = 0; k < n; ++k) {
    for (int l = 0; l < n; ++l) {
      MatrixXd lowered(n, n);
      for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) {
          lowered(i, j) = tensor(i, j, k, l);
        }
      }
      result.push_back(inverse * lowered);
    }
  }
  return result;
}

/// A list of matrices side by side, so that it can be differentiated.
MatrixXd side_by_side(const std::vector<MatrixXd>& list) {
  MatrixXd result(list.front().rows(),
                  list.front().cols() * static_cast<Eigen::Index>(list.size()));
  for (std::size_t i = 0; i < list.size(); ++i) {
    result.middleCols(static_cast<Eigen::Index>(i) * list[i].cols(), list[i].cols()) = list[i];
  }
  return result;
}

TEST(MechanismCurvature, IsTheCurvatureOfTheConnection) {
  // R(E_k, E_l) = E_k G_l - E_l G_k + [G_k, G_l] - c_kl^m G_m with G_k = (nabla_Ek E_j)_i.
  on_random_cases(
      [](RandomCase& c) {
        const Mechanism& m = c.mechanism;
        const int n = m.dof();
        const auto at = [](int i) { return static_cast<std::size_t>(i); };
        const std::vector<MatrixXd> g = second_kind(m, c.workspace, c.q);
        std::vector<MatrixXd> dg;  // side by side: derivative of every G_l along E_k
        for (int k = 0; k < n; ++k) {
          dg.push_back(rate([&](double t) {
            return side_by_side(second_kind(m, c.workspace, c.moved(VectorXd::Unit(n, k), t)));
          }));
        }
        const std::vector<MatrixXd> found = curvature_matrices(m, c.workspace, c.q);
        for (int k = 0; k < n; ++k) {
          for (int l = 0; l < n; ++l) {
            VectorXd structure(n);
            frame_bracket(m, VectorXd::Unit(n, k), VectorXd::Unit(n, l), structure);
            MatrixXd expected = dg[at(k)].middleCols(l * n, n) - dg[at(l)].middleCols(k * n, n) +
                                g[at(k)] * g[at(l)] - g[at(l)] * g[at(k)];
            double scale = 1.0 + (g[at(k)] * g[at(l)]).norm();
            for (int p = 0; p < n; ++p) {
              expected -= structure[p] * g[at(p)];
            }
            EXPECT_LE((found[at(k * n + l)] - expected).norm(), 1e-7 * scale) << k << " " << l;
          }
        }
      },
      9, 32);
}

TEST(MechanismCurvature, TheTensorHasItsSymmetriesAndTheFirstBianchiIdentity) {
  on_random_cases(
      [](RandomCase& c) {
        const Mechanism& m = c.mechanism;
        const int n = m.dof();
        RiemannTensor r(m);
        ASSERT_TRUE(riemann_tensor(m, c.workspace, c.q, r));
        double worst = 0.0, largest = 0.0;
        for (int i = 0; i < n; ++i) {
          for (int j = 0; j < n; ++j) {
            for (int k = 0; k < n; ++k) {
              for (int l = 0; l < n; ++l) {
                const double entry = r(i, j, k, l);
                largest = std::max(largest, std::abs(entry));
                worst = std::max({worst, std::abs(entry + r(i, j, l, k)),
                                  std::abs(entry + r(j, i, k, l)), std::abs(entry - r(k, l, i, j)),
                                  std::abs(entry + r(i, k, l, j) + r(i, l, j, k))});
              }
            }
          }
        }
        EXPECT_LE(worst, 1e-11 * (1.0 + largest));
        // The covector of three fields is the tensor contracted.
        const VectorXd x = c.v, y = c.a, z = c.random.vector(n);
        VectorXd contracted = VectorXd::Zero(n);
        for (int i = 0; i < n; ++i) {
          for (int j = 0; j < n; ++j) {
            for (int k = 0; k < n; ++k) {
              for (int l = 0; l < n; ++l) {
                contracted[i] += r(i, j, k, l) * z[j] * x[k] * y[l];
              }
            }
          }
        }
        expect_near(*curvature_covector(m, c.workspace, c.q, x, y, z), contracted, 1e-10);
      },
      14);
}

TEST(MechanismCurvature, TheSecondBianchiIdentity) {
  // (nabla_m R)(k, l) + (nabla_k R)(l, m) + (nabla_l R)(m, k) = 0.
  on_random_cases(
      [](RandomCase& c) {
        const Mechanism& m = c.mechanism;
        const int n = m.dof();
        const auto at = [](int i) { return static_cast<std::size_t>(i); };
        const std::vector<MatrixXd> g = second_kind(m, c.workspace, c.q);
        const std::vector<MatrixXd> r = curvature_matrices(m, c.workspace, c.q);
        std::vector<MatrixXd> dr;
        for (int p = 0; p < n; ++p) {
          dr.push_back(rate([&](double t) {
            return side_by_side(
                curvature_matrices(m, c.workspace, c.moved(VectorXd::Unit(n, p), t)));
          }));
        }
        const auto derivative = [&](int p, int k, int l) -> MatrixXd {
          const auto kl = at(k * n + l);
          MatrixXd result =
              dr[at(p)].middleCols((k * n + l) * n, n) + g[at(p)] * r[kl] - r[kl] * g[at(p)];
          for (int s = 0; s < n; ++s) {
            result -= g[at(p)](s, k) * r[at(s * n + l)] + g[at(p)](s, l) * r[at(k * n + s)];
          }
          return result;
        };
        for (int p = 0; p < n; ++p) {
          for (int k = 0; k < p; ++k) {
            for (int l = 0; l < k; ++l) {
              const MatrixXd first = derivative(p, k, l);
              const MatrixXd sum = first + derivative(k, l, p) + derivative(l, p, k);
              EXPECT_LE(sum.norm(), 1e-6 * (1.0 + dr[at(p)].norm()));
            }
          }
        }
      },
      7, 32);
}

TEST(MechanismCurvature, SectionalCurvatureBelongsToThePlane) {
  on_random_cases([](RandomCase& c) {
    const Mechanism& m = c.mechanism;
    const double k = sectional_curvature(m, c.workspace, c.q, c.v, c.a);
    const double again =
        sectional_curvature(m, c.workspace, c.q, 0.7 * c.v - 1.3 * c.a, 0.4 * c.v + 2.1 * c.a);
    if (m.dof() == 1) {
      EXPECT_TRUE(std::isnan(k) && std::isnan(again));
      return;
    }
    EXPECT_NEAR(k, again, 1e-9 * (1.0 + std::abs(k)));
    EXPECT_TRUE(std::isnan(sectional_curvature(m, c.workspace, c.q, c.v, -3.0 * c.v)));
  });
}

JointDescription joint(const std::string& name, JointKind kind, const std::string& parent,
                       const std::string& child, const Vector3d& axis) {
  JointDescription result;
  result.name = name;
  result.kind = kind;
  result.parent_link = parent;
  result.child_link = child;
  result.axis = axis;
  return result;
}

TEST(MechanismCurvature, APointOnTwoCrossedAxesIsASphere) {
  TreeDescription tree;
  tree.root_link = "base";
  constexpr double kMass = 1.7, kLength = 0.6;
  tree.links = {{"base", {}},
                {"fork", {}},
                {"bob", {kMass, Vector3d(kLength, 0.0, 0.0), Eigen::Matrix3d::Zero()}}};
  tree.joints = {joint("a", JointKind::kContinuous, "base", "fork", Vector3d::UnitZ()),
                 joint("b", JointKind::kContinuous, "fork", "bob", Vector3d::UnitY())};
  const Mechanism m(tree, Vector3d(0.0, 0.0, -9.81));
  Workspace w(m);
  const double expected = 1.0 / (kMass * kLength * kLength);
  EXPECT_NEAR(sectional_curvature(m, w, Eigen::Vector2d(0.4, -0.9), Eigen::Vector2d(1.0, 0.0),
                                  Eigen::Vector2d(0.3, 1.0)),
              expected, 1e-13);
}

TEST(MechanismCurvature, ThePlanarArmOfTheTextbooks) {
  // Brioschi's formula on M = [a + 2 b cos q2, d + b cos q2; ., d] gives
  // K = b cos q2 (a d - d^2 - b^2) / (a d - d^2 - b^2 cos^2 q2)^2.
  TreeDescription tree;
  tree.root_link = "base";
  const auto rod = [](double mass, double length) {
    const double i = mass * length * length / 12.0;
    return LinkInertia{mass, Vector3d(0.5 * length, 0.0, 0.0), Vector3d(0.0, i, i).asDiagonal()};
  };
  constexpr double kM1 = 1.3, kM2 = 0.9, kL1 = 0.5, kL2 = 0.4;
  tree.links = {{"base", {}}, {"upper", rod(kM1, kL1)}, {"fore", rod(kM2, kL2)}};
  tree.joints = {joint("a", JointKind::kRevolute, "base", "upper", Vector3d::UnitZ()),
                 joint("b", JointKind::kRevolute, "upper", "fore", Vector3d::UnitZ())};
  tree.joints[1].parent_from_joint.translation().x() = kL1;
  const Mechanism m(tree, Vector3d(0.0, -9.81, 0.0));
  Workspace w(m);
  const double d = kM2 * kL2 * kL2 / 3.0;
  const double b = 0.5 * kM2 * kL1 * kL2;
  const double a = kM1 * kL1 * kL1 / 3.0 + kM2 * kL1 * kL1 + d;
  for (const double q2 : {-2.5, -1.0, 0.0, 0.8, 1.5707, 3.0}) {
    const double cosine = std::cos(q2);
    const double area = a * d - d * d - b * b * cosine * cosine;
    const double expected = b * cosine * (a * d - d * d - b * b) / (area * area);
    EXPECT_NEAR(sectional_curvature(m, w, Eigen::Vector2d(0.3, q2), Eigen::Vector2d(1.0, 0.2),
                                    Eigen::Vector2d(-0.5, 1.0)),
                expected, 1e-12 * (1.0 + std::abs(expected)));
  }
}

TEST(MechanismCurvature, ARigidBodyAboutAPointIsMilnorsLeftInvariantMetric) {
  // Milnor 1976, "Curvatures of left invariant metrics on Lie groups", theorem 4.3: orthonormal
  // e_i with [e_1, e_2] = lambda_3 e_3 and so on, mu_i = (sum of lambda) / 2 - lambda_i, then
  // K(e_1, e_2) = lambda_3 mu_3 - mu_1 mu_2; 1/(4 I) for equal moments.
  const Vector3d moments(0.8, 1.1, 1.5);
  TreeDescription tree;
  tree.root_link = "base";
  tree.links = {{"base", {}}, {"top", {2.0, Vector3d::Zero(), moments.asDiagonal()}}};
  tree.joints = {joint("ball", JointKind::kSpherical, "base", "top", Vector3d::UnitZ())};
  const Mechanism m(tree, Vector3d::Zero());
  Workspace w(m);
  testing::RandomArm random(3);
  const VectorXd q = random.configuration(m);
  const Vector3d lambda = moments / std::sqrt(moments.prod());
  const Vector3d mu = Vector3d::Constant(0.5 * lambda.sum()) - lambda;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    const double expected = lambda[k] * mu[k] - mu[i] * mu[j];
    EXPECT_NEAR(sectional_curvature(m, w, q, Vector3d::Unit(i), Vector3d::Unit(j)), expected,
                1e-13);
  }
}

TEST(MechanismCurvature, SlidesAndTranslationsAreFlat) {
  TreeDescription tree;
  tree.root_link = "base";
  tree.links = {{"base", {}}};
  testing::RandomArm random(5);
  std::string last = "base";
  for (const char* name : {"x", "y", "z", "w"}) {
    tree.links.push_back({name, random.inertia()});
    tree.joints.push_back(
        joint(name, JointKind::kPrismatic, last, name, random.vector(3).normalized()));
    tree.joints.back().parent_from_joint = random.pose();
    last = name;
  }
  // The last slides beside the first, so that M is regular whatever the axes.
  tree.joints.back().parent_link = "base";
  const Mechanism slides(tree, Vector3d::Zero());
  Workspace w(slides);
  RiemannTensor tensor(slides);
  ASSERT_TRUE(riemann_tensor(slides, w, random.vector(4), tensor));
  for (int i = 0; i < 256; ++i) {
    EXPECT_NEAR(tensor(i / 64, i / 16 % 4, i / 4 % 4, i % 4), 0.0, 1e-14);
  }
  // A free body is R3 x SO(3), the planes between them flat (in the frame of its centre of mass).
  TreeDescription stone;
  stone.root_link = "stone";
  stone.links = {{"stone", random.inertia()}};
  stone.links[0].inertia.com_m.setZero();
  const Mechanism free(stone, Vector3d::Zero(), {Base::kFloating, {}});
  Workspace w_free(free);
  const VectorXd q = random.configuration(free);
  VectorXd shift = VectorXd::Zero(6), other = VectorXd::Zero(6), turn = VectorXd::Zero(6);
  shift.head<3>() = random.vector(3);
  other.head<3>() = random.vector(3);
  turn.tail<3>() = random.vector(3);
  EXPECT_NEAR(sectional_curvature(free, w_free, q, shift, turn), 0.0, 1e-13);
  EXPECT_NEAR(sectional_curvature(free, w_free, q, shift, other), 0.0, 1e-13);
}

}  // namespace
}  // namespace geodesic::control
