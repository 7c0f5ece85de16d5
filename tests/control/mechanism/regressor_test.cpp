// Inverse dynamics as a linear function of the bodies' parameters; the parameters themselves.
#include "control/mechanism/inertia_check.hpp"
#include "tests/control/mechanism/random_case.hpp"

namespace geodesic::control {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using testing::expect_near;
using testing::on_random_cases;
using testing::RandomCase;

TEST(MechanismRegressor, TimesTheParametersIsInverseDynamics) {
  on_random_cases([](RandomCase& c) {
    const Mechanism& m = c.mechanism;
    MatrixXd y(m.dof(), parameter_count(m));
    regressor(m, c.workspace, c.q, c.v, c.a, y);
    expect_near(y * parameters(m), inverse_dynamics(m, c.workspace, c.q, c.v, c.a), 1e-12);
  });
}

TEST(MechanismRegressor, IsLinearInBodiesThatAreOthers) {
  // The same tree with other inertias: the regressor does not change, tau follows the parameters.
  for (unsigned seed = 0; seed < 12; ++seed) {
    testing::RandomArm random(seed);
    testing::RandomTreeOptions shape;
    shape.any_kind = seed % 2 == 1;
    shape.joints = 1 + static_cast<int>(seed);
    TreeDescription tree = random.tree(shape);
    const Vector3d gravity = random.vector(3, 10.0);
    const Mechanism one(tree, gravity);
    for (LinkDescription& link : tree.links) {
      link.inertia = random.inertia();
    }
    const Mechanism other(tree, gravity);
    Workspace w_one(one), w_other(other);
    const VectorXd q = random.configuration(one);
    const VectorXd v = random.vector(one.dof()), a = random.vector(one.dof());
    MatrixXd y(one.dof(), parameter_count(one)), again = y;
    regressor(one, w_one, q, v, a, y);
    regressor(other, w_other, q, v, a, again);
    EXPECT_EQ(y, again);
    expect_near(y * parameters(other), inverse_dynamics(other, w_other, q, v, a), 1e-12);
    const VectorXd sum =
        inverse_dynamics(one, w_one, q, v, a) + inverse_dynamics(other, w_other, q, v, a);
    expect_near(y * (parameters(one) + parameters(other)), sum, 1e-12);
  }
}

TEST(InertialParameters, GoToAndFro) {
  testing::RandomArm random(2);
  for (int i = 0; i < 20; ++i) {
    const LinkInertia link = random.inertia();
    const RigidInertia body = to_rigid_inertia(link);
    const LinkInertia back = to_link_inertia(body);
    EXPECT_NEAR(back.mass_kg, link.mass_kg, 1e-15);
    expect_near(back.com_m, link.com_m, 1e-15);
    expect_near(back.inertia_kg_m2, link.inertia_kg_m2, 1e-15);
    EXPECT_EQ(to_parameters(from_parameters(to_parameters(body))), to_parameters(body));
    expect_near(to_parameters(from_pseudo_inertia(pseudo_inertia(body))), to_parameters(body),
                1e-15);
  }
  EXPECT_EQ(to_link_inertia(RigidInertia{}).com_m, Vector3d::Zero().eval());
}

/// Parameters of matter in points, which are consistent by construction.
RigidInertia of_points(const std::vector<Vector3d>& points, double mass) {
  RigidInertia sum;
  for (const Vector3d& point : points) {
    sum += to_rigid_inertia({mass, point, Eigen::Matrix3d::Zero()});
  }
  return sum;
}

TEST(InertialParameters, AreConsistentExactlyWhereThePseudoInertiaIsPositive) {
  testing::RandomArm random(4);
  int consistent = 0;
  for (int i = 0; i < 200; ++i) {
    RigidInertia body = to_rigid_inertia(random.inertia());
    InertialParameters p = to_parameters(body);
    p += 0.3 * p.cwiseAbs().cwiseProduct(InertialParameters(random.vector(10)));
    body = from_parameters(p);
    const double least =
        Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d>(pseudo_inertia(body)).eigenvalues()[0];
    EXPECT_EQ(physically_consistent(body), least > 0.0) << least;
    EXPECT_EQ(physically_consistent(body), check_inertia(to_link_inertia(body)).physical) << least;
    consistent += least > 0.0 ? 1 : 0;
  }
  EXPECT_GT(consistent, 20);
  EXPECT_LT(consistent, 180);
}

TEST(InertialParameters, FourPointsAreABodyThreeAreAPlate) {
  const std::vector<Vector3d> three = {{0.1, 0.2, 0.3}, {0.4, -0.1, 0.2}, {-0.2, 0.5, 0.1}};
  std::vector<Vector3d> four = three;
  four.emplace_back(0.3, 0.3, -0.4);
  EXPECT_TRUE(physically_consistent(of_points(four, 0.5)));
  EXPECT_FALSE(physically_consistent(of_points(three, 0.5)));
  EXPECT_TRUE(check_inertia(to_link_inertia(of_points(three, 0.5))).physical);
  EXPECT_FALSE(physically_consistent(of_points(four, 0.5), 0.5));
  EXPECT_FALSE(physically_consistent(RigidInertia{}));
  EXPECT_FALSE(physically_consistent(of_points(four, -0.5)));
  RigidInertia broken = of_points(four, 0.5);
  broken.first_moment.x() = std::nan("");
  EXPECT_FALSE(physically_consistent(broken));
}

}  // namespace
}  // namespace geodesic::control
