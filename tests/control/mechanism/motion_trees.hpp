// Small trees whose motion is known or easily judged, for the tests of the integrators.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <string>
#include <vector>

#include "control/mechanism/energy.hpp"
#include "control/mechanism/momentum.hpp"
#include "control/mechanism/tree.hpp"

namespace geodesic::control::testing {

inline LinkDescription rod(const std::string& name, double mass, double length) {
  LinkDescription link{name, {}};
  link.inertia.mass_kg = mass;
  link.inertia.com_m = {0.5 * length, 0.01, -0.02};
  const double across = mass * length * length / 12.0;
  link.inertia.inertia_kg_m2 = Eigen::Vector3d(0.05 * across, across, across).asDiagonal();
  return link;
}

inline JointDescription joint(const std::string& name, JointKind kind, const std::string& parent,
                              const std::string& child, const Eigen::Vector3d& axis, double x) {
  JointDescription result;
  result.name = name;
  result.kind = kind;
  result.parent_link = parent;
  result.child_link = child;
  result.axis = axis;
  result.parent_from_joint.translation().x() = x;
  return result;
}

/// A box with a chain of rods; each joint of the kind and axis given.
inline TreeDescription chain(const std::vector<JointKind>& kinds,
                             const std::vector<Eigen::Vector3d>& axes) {
  TreeDescription tree;
  tree.name = "chain";
  tree.root_link = "base";
  LinkDescription base{"base", {}};
  base.inertia.mass_kg = 4.0;
  base.inertia.com_m = {0.02, -0.03, 0.01};
  base.inertia.inertia_kg_m2 = Eigen::Vector3d(0.09, 0.12, 0.15).asDiagonal();
  tree.links.push_back(base);
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    const std::string number = std::to_string(i + 1);
    tree.links.push_back(rod("rod" + number, 1.0 - 0.1 * static_cast<double>(i), 0.4));
    tree.joints.push_back(joint("joint" + number, kinds[i],
                                i == 0 ? "base" : "rod" + std::to_string(i), "rod" + number,
                                axes[i], i == 0 ? 0.2 : 0.4));
  }
  return tree;
}

/// An arm of three revolute joints about three axes.
inline TreeDescription arm() {
  using Eigen::Vector3d;
  return chain({JointKind::kContinuous, JointKind::kContinuous, JointKind::kContinuous},
               {Vector3d::UnitZ(), Vector3d::UnitY(), Vector3d(0.0, 0.6, 0.8)});
}

/// A point of one kilogram on a unit rod without mass, on two crossed joints (azimuth, elevation):
/// the metric is the unit sphere's, diag(cos^2 q2, 1).
inline TreeDescription sphere() {
  TreeDescription tree;
  tree.name = "sphere";
  tree.root_link = "stand";
  tree.links = {{"stand", {}}, {"fork", {}}, {"point", {}}};
  tree.links[2].inertia.mass_kg = 1.0;
  tree.links[2].inertia.com_m = Eigen::Vector3d::UnitX();
  tree.joints = {
      joint("azimuth", JointKind::kContinuous, "stand", "fork", Eigen::Vector3d::UnitZ(), 0.0),
      joint("elevation", JointKind::kContinuous, "fork", "point", -Eigen::Vector3d::UnitY(), 0.0)};
  return tree;
}

inline Eigen::Vector3d on_sphere(const Eigen::VectorXd& q) {
  return {std::cos(q[1]) * std::cos(q[0]), std::cos(q[1]) * std::sin(q[0]), std::sin(q[1])};
}

/// Momentum of the whole mechanism about the world's origin: linear, then angular.
inline Eigen::Matrix<double, 6, 1> total_momentum(const Mechanism& mechanism, Workspace& workspace,
                                                  const Eigen::VectorXd& q,
                                                  const Eigen::VectorXd& v) {
  const CentroidalMomentum h = centroidal_momentum(mechanism, workspace, q, v);
  Eigen::Matrix<double, 6, 1> result;
  result << h.linear, h.angular + h.centre_of_mass.cross(h.linear);
  return result;
}

}  // namespace geodesic::control::testing
