// Implements inertia_check.hpp.
#include "control/mechanism/inertia_check.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace geodesic::control {
namespace {

constexpr double kTolerance = 1e-9;

bool finite(const LinkInertia& inertia) noexcept {
  return std::isfinite(inertia.mass_kg) && inertia.com_m.allFinite() &&
         inertia.inertia_kg_m2.allFinite();
}

struct Principal {
  Eigen::Vector3d moments;  ///< ascending
  Eigen::Matrix3d axes;
};

Principal principal(const Eigen::Matrix3d& inertia) noexcept {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(0.5 *
                                                              (inertia + inertia.transpose()));
  return {solver.eigenvalues(), solver.eigenvectors()};
}

/// Nearest point of the cone a + b >= c, b + c >= a, c + a >= b to an ascending triple: a face, an
/// edge or the apex, in that order.
Eigen::Vector3d project(const Eigen::Vector3d& moments) noexcept {
  const double missing = moments[2] - moments[0] - moments[1];
  if (missing <= 0.0) {
    return moments;
  }
  Eigen::Vector3d on_face = moments + (missing / 3.0) * Eigen::Vector3d(1.0, 1.0, -1.0);
  if (on_face[0] >= 0.0) {
    return on_face;
  }
  const double on_edge = std::max(0.0, 0.5 * (moments[1] + moments[2]));
  return {0.0, on_edge, on_edge};
}

const char* fault(const LinkInertia& inertia, const Eigen::Vector3d& moments) noexcept {
  const Eigen::Matrix3d& i = inertia.inertia_kg_m2;
  const double slack = kTolerance * moments.cwiseAbs().sum();
  if (inertia.mass_kg < 0.0) {
    return "the mass is negative";
  }
  if (inertia.mass_kg == 0.0) {
    return i.isZero(0.0) ? "" : "there is inertia without mass";
  }
  if (!(i - i.transpose()).isZero(std::max(slack, 1e-300))) {
    return "the inertia matrix is not symmetric";
  }
  if (moments[0] < -slack) {
    return "a principal moment of inertia is negative";
  }
  if (moments[0] + moments[1] < moments[2] - slack) {
    return "the principal moments break the triangle inequality A + B >= C";
  }
  return "";
}

}  // namespace

LinkInertia nearest_physical_inertia(const LinkInertia& inertia) noexcept {
  if (!finite(inertia) || !(inertia.mass_kg > 0.0)) {
    return {};
  }
  const Principal found = principal(inertia.inertia_kg_m2);
  LinkInertia nearest = inertia;
  const Eigen::Matrix3d i =
      found.axes * project(found.moments).asDiagonal() * found.axes.transpose();
  nearest.inertia_kg_m2 = 0.5 * (i + i.transpose());
  return nearest;
}

InertiaVerdict check_inertia(const LinkInertia& inertia) noexcept {
  InertiaVerdict verdict;
  if (!finite(inertia)) {
    verdict.reason = "a number is not finite";
    return verdict;
  }
  verdict.principal = principal(inertia.inertia_kg_m2).moments;
  verdict.reason = fault(inertia, verdict.principal);
  verdict.physical = *verdict.reason == '\0';
  verdict.nearest = verdict.physical ? inertia : nearest_physical_inertia(inertia);
  return verdict;
}

}  // namespace geodesic::control
