// Wrenches at links against Jacobians, and the Jacobian's rate against differences.
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

TEST(MechanismExternalWrench, IsTheTransposedJacobianTimesTheWrench) {
  on_random_cases([](RandomCase& c) {
    const Mechanism& m = c.mechanism;
    std::vector<ExternalWrench> all;
    VectorXd expected = VectorXd::Zero(m.dof());
    for (int link = 0; link < static_cast<int>(m.links().size()); link += 3) {
      const Pose pose = link_pose(m, c.q, link);
      const VectorXd six = c.random.vector(6, 5.0);  // at the link's origin, world axes
      expected += jacobian(m, c.workspace, c.q, link).transpose() * six;
      const Vector3d force = six.head<3>(), moment = six.tail<3>();
      const Eigen::Matrix3d turned = pose.rotation.transpose();
      const Wrench written[] = {{turned * force, turned * moment},
                                {force, moment},
                                {force, moment + pose.translation.cross(force)}};
      constexpr Frame kFrames[] = {Frame::kLink, Frame::kLinkOrigin, Frame::kWorldOrigin};
      const int way = link / 3 % 3;
      all.push_back({link, kFrames[way], written[way]});
      const VectorXd once = external_torque(m, c.workspace, c.q, {&all.back(), 1});
      for (int other = 0; other < 3; ++other) {
        const ExternalWrench same{link, kFrames[other], written[other]};
        expect_near(external_torque(m, c.workspace, c.q, {&same, 1}), once, 1e-12);
      }
    }
    expect_near(external_torque(m, c.workspace, c.q, all), expected, 1e-12);
    const VectorXd without = inverse_dynamics(m, c.workspace, c.q, c.v, c.a);
    expect_near(inverse_dynamics(m, c.workspace, c.q, c.v, c.a, all), without - expected, 1e-12);
  });
}

TEST(MechanismJacobianRate, IsTheDerivativeOfTheJacobian) {
  on_random_cases([](RandomCase& c) {
    const Mechanism& m = c.mechanism;
    for (int link = 0; link < static_cast<int>(m.links().size()); link += 7) {
      const MatrixXd expected = rate(
          [&](double t) -> MatrixXd { return jacobian(m, c.workspace, c.moved(c.v, t), link); });
      expect_near(jacobian_rate(m, c.workspace, c.q, c.v, link), expected, 1e-9);
    }
  });
}

}  // namespace
}  // namespace geodesic::control
