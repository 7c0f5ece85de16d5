// Small random trees for the tests of compiled models: chains and branches of turning and sliding
// joints, axes along coordinate axes or anywhere, parallel ones, mimic joints. No test here.
#pragma once

#include <Eigen/Geometry>
#include <random>
#include <string>

#include "control/mechanism/mechanism.hpp"

namespace geodesic::tools::compile {

inline control::TreeDescription random_tree(unsigned seed) {
  std::mt19937 dice(1000 + seed);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const auto vector = [&](double scale) {
    return Eigen::Vector3d(scale * uniform(dice), scale * uniform(dice), scale * uniform(dice));
  };
  control::TreeDescription tree;
  tree.name = "random \"" + std::to_string(seed) + "\"";
  tree.root_link = "l0";
  const int links = 3 + static_cast<int>(seed % 6);
  for (int i = 0; i < links; ++i) {
    control::LinkDescription link;
    link.name = "l" + std::to_string(i);
    link.inertia.mass_kg = 1.5 + uniform(dice);
    link.inertia.com_m = vector(0.3);
    const Eigen::Vector3d lengths = 0.05 * (vector(0.5) + Eigen::Vector3d::Ones());
    const Eigen::Matrix3d turn =
        Eigen::AngleAxisd(uniform(dice), vector(1.0).normalized()).toRotationMatrix();
    // Moments of a box, which a body can have.
    const Eigen::Vector3d squares = lengths.cwiseProduct(lengths);
    const Eigen::Vector3d moments(squares.y() + squares.z(), squares.x() + squares.z(),
                                  squares.x() + squares.y());
    link.inertia.inertia_kg_m2 = turn * moments.asDiagonal() * turn.transpose();
    tree.links.push_back(link);
    if (i == 0) continue;
    control::JointDescription joint;
    joint.name = "j" + std::to_string(i);
    const bool branches = i > 2 && uniform(dice) > 0.5;
    joint.parent_link = "l" + std::to_string(branches ? i - 2 : i - 1);
    joint.child_link = link.name;
    joint.kind = uniform(dice) > 0.5   ? control::JointKind::kPrismatic
                 : uniform(dice) > 0.7 ? control::JointKind::kPlanar
                                       : control::JointKind::kRevolute;
    joint.parent_from_joint.translation() = vector(0.5);
    const double kind = uniform(dice);
    joint.axis = Eigen::Vector3d::Unit(static_cast<int>(dice() % 3));
    if (kind > 0.3) {
      joint.axis = vector(1.0).normalized();
      joint.parent_from_joint.linear() =
          Eigen::AngleAxisd(uniform(dice), vector(1.0).normalized()).toRotationMatrix();
    } else if (kind > -0.3) {
      // Nearly, but not quite, a quarter turn: what a URDF with five digits says.
      joint.parent_from_joint.linear() =
          Eigen::AngleAxisd(1.5708, Eigen::Vector3d::UnitX()).toRotationMatrix();
    } else {
      joint.axis = (dice() % 2 == 0 ? 1.0 : -1.0) * Eigen::Vector3d::UnitY();
    }
    if (i == links - 1 && joint.kind == control::JointKind::kRevolute &&
        tree.joints.front().kind == control::JointKind::kRevolute) {
      joint.mimic = control::MimicDescription{"j1", -0.7, 0.2};
    }
    tree.joints.push_back(joint);
  }
  return tree;
}

inline control::Mechanism random_mechanism(unsigned seed, bool floats) {
  control::MechanismOptions options;
  options.base = floats ? control::Base::kFloating : control::Base::kFixed;
  return {random_tree(seed), Eigen::Vector3d(1.0, -2.0, -9.0), options};
}

}  // namespace geodesic::tools::compile
