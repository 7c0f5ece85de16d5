// Implements random_tree.hpp.
#include "tests/control/mechanism/random_tree.hpp"

#include <string>

#include "control/geometry/so3.hpp"
#include "control/mechanism/configuration.hpp"
#include "control/mechanism/kinematics.hpp"

namespace geodesic::control::testing {

Eigen::VectorXd RandomArm::vector(int size, double magnitude) {
  Eigen::VectorXd result(size);
  for (Eigen::Index i = 0; i < size; ++i) {
    result[i] = uniform(-magnitude, magnitude);
  }
  return result;
}

Eigen::Isometry3d RandomArm::pose() {
  Eigen::Isometry3d result = Eigen::Isometry3d::Identity();
  result.linear() = exp(Eigen::Vector3d(vector(3, 2.0)));
  result.translation() = vector(3, 0.3);
  return result;
}

LinkInertia RandomArm::inertia() {
  // Second moments of a box of matter, so that the triangle inequality holds.
  const Eigen::Vector3d second(uniform(0.001, 0.02), uniform(0.001, 0.02), uniform(0.001, 0.02));
  const Eigen::Matrix3d turn = exp(Eigen::Vector3d(vector(3, 2.0)));
  LinkInertia result;
  result.mass_kg = uniform(0.2, 2.0);
  result.com_m = vector(3, 0.2);
  const Eigen::Matrix3d i = result.mass_kg * (second.sum() * Eigen::Matrix3d::Identity() -
                                              turn * second.asDiagonal() * turn.transpose());
  result.inertia_kg_m2 = 0.5 * (i + i.transpose());
  return result;
}

TreeDescription RandomArm::tree(const RandomTreeOptions& options) {
  TreeDescription tree;
  tree.name = "random";
  tree.root_link = "link0";
  tree.links.push_back({"link0", inertia()});
  const int moving = options.joints + options.mimic_joints;
  std::vector<int> independent;
  for (int made = 0; made < moving;) {
    JointDescription joint;
    const int number = static_cast<int>(tree.links.size());
    const int parent = uniform(0.0, 1.0) < options.branching ? below(number) : number - 1;
    joint.name = "joint" + std::to_string(number);
    joint.parent_link = "link" + std::to_string(parent);
    joint.child_link = "link" + std::to_string(number);
    joint.parent_from_joint = pose();
    joint.axis = Eigen::Vector3d(vector(3)).normalized();
    constexpr JointKind kKinds[] = {
        JointKind::kRevolute, JointKind::kContinuous, JointKind::kRevolute,  JointKind::kPrismatic,
        JointKind::kFixed,    JointKind::kPlanar,     JointKind::kSpherical, JointKind::kFloating};
    // The first is kept simple where something will have to be mimicked.
    const bool may_be_any = options.any_kind && made < options.joints &&
                            (options.mimic_joints == 0 || !independent.empty());
    joint.kind = kKinds[below(may_be_any ? 8 : 5)];
    tree.links.push_back({joint.child_link, inertia()});
    if (joint.kind != JointKind::kFixed) {
      ++made;
      if (made > options.joints) {
        const auto target = static_cast<std::size_t>(below(static_cast<int>(independent.size())));
        joint.mimic = MimicDescription{"joint" + std::to_string(independent[target]),
                                       uniform(-2.0, 2.0), uniform(-0.5, 0.5)};
      } else if (freedoms(joint.kind) == 1) {
        independent.push_back(number);
      }
    }
    tree.joints.push_back(joint);
  }
  return tree;
}

Eigen::VectorXd RandomArm::configuration(const Mechanism& mechanism) {
  Eigen::VectorXd q = neutral(mechanism);
  integrate(mechanism, q, vector(mechanism.dof(), 2.0), 1.0, q);
  return q;
}

Mechanism random_mechanism(unsigned seed) {
  constexpr int kSizes[] = {1, 2, 3, 6, 7, 12, 20, 32};
  RandomArm random(seed);
  RandomTreeOptions shape;
  shape.joints = kSizes[seed % 8];
  shape.any_kind = seed % 16 >= 8;
  shape.mimic_joints = seed % 3 == 1 ? std::min(shape.joints, 1 + random.below(6)) : 0;
  const TreeDescription tree = random.tree(shape);
  MechanismOptions options;
  options.base = seed % 4 == 3 ? Base::kFloating : Base::kFixed;
  if (seed % 5 == 2) {
    options.rotor_inertia = random.vector(shape.joints, 0.1).cwiseAbs();
    const Mechanism without(tree, Eigen::Vector3d::Zero());
    for (int i = 0; i < shape.joints; ++i) {
      if (freedoms(without.joint_kinds()[static_cast<std::size_t>(i)]) > 1) {
        options.rotor_inertia[i] = 0.0;
      }
    }
  }
  return {tree, Eigen::Vector3d(random.vector(3, 10.0)), options};
}

}  // namespace geodesic::control::testing
