// Implements inertial_parameters.hpp.
#include "control/mechanism/inertial_parameters.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>

namespace geodesic::control {
namespace {

Eigen::Matrix3d second_from_rotational(const Eigen::Matrix3d& rotational) noexcept {
  return 0.5 * rotational.trace() * Eigen::Matrix3d::Identity() - rotational;
}

Eigen::Matrix3d rotational_from_second(const Eigen::Matrix3d& second) noexcept {
  return second.trace() * Eigen::Matrix3d::Identity() - second;
}

}  // namespace

InertialParameters to_parameters(const RigidInertia& body) noexcept {
  const Eigen::Matrix3d& i = body.rotational;
  InertialParameters result;
  result << body.mass, body.first_moment, i(0, 0), i(0, 1), i(0, 2), i(1, 1), i(1, 2), i(2, 2);
  return result;
}

RigidInertia from_parameters(const InertialParameters& p) noexcept {
  RigidInertia body{p[0], p.segment<3>(1), {}};
  body.rotational << p[4], p[5], p[6], p[5], p[7], p[8], p[6], p[8], p[9];
  return body;
}

RigidInertia to_rigid_inertia(const LinkInertia& link) noexcept {
  return {link.mass_kg, link.mass_kg * link.com_m,
          link.inertia_kg_m2 + shifted(link.com_m, (0.5 * link.mass_kg) * link.com_m)};
}

LinkInertia to_link_inertia(const RigidInertia& body) noexcept {
  LinkInertia link;
  link.mass_kg = body.mass;
  if (body.mass != 0.0) {
    link.com_m = body.first_moment / body.mass;
  }
  link.inertia_kg_m2 = body.rotational - shifted(link.com_m, (0.5 * body.mass) * link.com_m);
  return link;
}

Eigen::Matrix4d pseudo_inertia(const RigidInertia& body) noexcept {
  Eigen::Matrix4d result;
  result.topLeftCorner<3, 3>() = second_from_rotational(body.rotational);
  result.topRightCorner<3, 1>() = body.first_moment;
  result.bottomLeftCorner<1, 3>() = body.first_moment.transpose();
  result(3, 3) = body.mass;
  return result;
}

RigidInertia from_pseudo_inertia(const Eigen::Matrix4d& pseudo) noexcept {
  return {pseudo(3, 3), pseudo.topRightCorner<3, 1>(),
          rotational_from_second(pseudo.topLeftCorner<3, 3>())};
}

bool physically_consistent(const RigidInertia& body, double margin) noexcept {
  if (!(body.mass > 0.0) || !body.first_moment.allFinite() || !body.rotational.allFinite()) {
    return false;
  }
  // The Schur complement of the mass in the pseudo-inertia: positive with it.
  const Eigen::Matrix3d second = second_from_rotational(body.rotational) -
                                 body.first_moment * body.first_moment.transpose() / body.mass;
  const Eigen::Vector3d moments = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(
                                      0.5 * (second + second.transpose()), Eigen::EigenvaluesOnly)
                                      .eigenvalues();
  // What rounding of the larger terms leaves of a plate is no thickness.
  constexpr double kRounding = 1e-14;
  const double scale = second_from_rotational(body.rotational).trace();
  return moments[0] > std::max(margin * moments.sum(), kRounding * scale);
}

}  // namespace geodesic::control
