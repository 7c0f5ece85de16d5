// Flattens trees for the peers, and makes chains up.
#include "tests/bench/robots.hpp"

#include <algorithm>
#include <map>
#include <numbers>
#include <stdexcept>

#include "config/urdf.hpp"

namespace geodesic::bench {
namespace {

using RowMajor = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

void set_pose(const Eigen::Matrix3d& rotation, const Eigen::Vector3d& translation, PeerBody& body) {
  Eigen::Map<RowMajor>(body.rotation) = rotation;
  Eigen::Map<Eigen::Vector3d>(body.translation) = translation;
}

}  // namespace

PeerRobot FlatRobot::robot() const {
  return {body.data(),
          static_cast<int>(body.size()),
          nq,
          dof,
          {gravity[0], gravity[1], gravity[2]},
          compiled.empty() ? nullptr : compiled.c_str()};
}

FlatRobot as_written(const control::TreeDescription& tree, const control::Mechanism& mechanism) {
  FlatRobot flat;
  flat.nq = mechanism.nq();
  flat.dof = mechanism.dof();
  std::map<std::string, const control::JointDescription*> joint_of;
  std::map<std::string, const control::LinkDescription*> link_of;
  for (const auto& joint : tree.joints) {
    joint_of[joint.child_link] = &joint;
  }
  for (const auto& link : tree.links) {
    link_of[link.name] = &link;
  }
  std::map<std::string, int> index_of;  // the mechanism lists links depth first
  for (const control::LinkFrame& link : mechanism.links()) {
    const auto found = joint_of.find(link.name);
    PeerBody body{};
    if (found == joint_of.end()) {
      if (!mechanism.floating()) {
        index_of[link.name] = -1;
        continue;
      }
      body.parent = -1;
      body.kind = PeerBody::kFree;
      set_pose(Eigen::Matrix3d::Identity(), Eigen::Vector3d::Zero(), body);
    } else {
      const control::JointDescription& joint = *found->second;
      if (joint.mimic) {
        throw std::runtime_error("joint '" + joint.name +
                                 "' mimics another, which no peer knows: take <mimic> out first");
      }
      body.parent = index_of.at(joint.parent_link);
      body.kind = joint.kind == control::JointKind::kFixed       ? PeerBody::kFixed
                  : joint.kind == control::JointKind::kPrismatic ? PeerBody::kPrismatic
                                                                 : PeerBody::kRevolute;
      set_pose(joint.parent_from_joint.linear(), joint.parent_from_joint.translation(), body);
      Eigen::Map<Eigen::Vector3d>(body.axis) = joint.axis;
    }
    const control::LinkInertia& inertia = link_of.at(link.name)->inertia;
    body.mass = inertia.mass_kg;
    Eigen::Map<Eigen::Vector3d>(body.com) = inertia.com_m;
    Eigen::Map<RowMajor>(body.inertia) = inertia.inertia_kg_m2;
    index_of[link.name] = static_cast<int>(flat.body.size());
    flat.body.push_back(body);
  }
  return flat;
}

FlatRobot merged(const control::Mechanism& mechanism) {
  FlatRobot flat;
  flat.nq = mechanism.nq();
  flat.dof = mechanism.dof();
  for (const control::Body& from : mechanism.bodies()) {
    PeerBody body{};
    body.parent = from.parent;
    body.kind = from.motion == control::Motion::kFree          ? PeerBody::kFree
                : from.motion == control::Motion::kTranslation ? PeerBody::kPrismatic
                                                               : PeerBody::kRevolute;
    set_pose(from.parent_from_joint.rotation, from.parent_from_joint.translation, body);
    body.axis[2] = 1.0;
    body.mass = from.inertia.mass;
    const Eigen::Vector3d com = from.inertia.first_moment / std::max(from.inertia.mass, 1e-300);
    Eigen::Map<Eigen::Vector3d>(body.com) = com;
    Eigen::Map<RowMajor>(body.inertia) =
        from.inertia.rotational - control::shifted(com, (0.5 * body.mass) * com);
    flat.body.push_back(body);
  }
  return flat;
}

control::TreeDescription read_tree(const std::string& file) {
  config::UrdfResult result = config::load_urdf(file, false);
  if (!result.ok) {
    std::string all;
    for (const auto& message : result.messages) {
      all += config::to_string(message) + "\n";
    }
    throw std::runtime_error(all);
  }
  return std::move(result.tree);
}

control::TreeDescription chain(int joints) {
  control::TreeDescription tree;
  tree.name = "chain";
  tree.root_link = "link0";
  tree.links.push_back({"link0", {}});
  for (int i = 1; i <= joints; ++i) {
    const double mass =
        5.0 - 4.8 * static_cast<double>(i - 1) / std::max(1.0, static_cast<double>(joints - 1));
    control::LinkDescription link;
    link.name = "link" + std::to_string(i);
    link.inertia.mass_kg = mass;
    link.inertia.com_m = {0.01, -0.02, 0.1};
    link.inertia.inertia_kg_m2 =
        Eigen::Vector3d(0.004 * mass, 0.004 * mass, 0.001 * mass).asDiagonal();
    tree.links.push_back(link);
    control::JointDescription joint;
    joint.name = (i < 10 ? "joint0" : "joint") + std::to_string(i);
    joint.kind = control::JointKind::kRevolute;
    joint.parent_link = tree.links[static_cast<std::size_t>(i - 1)].name;
    joint.child_link = link.name;
    joint.parent_from_joint.translation() = Eigen::Vector3d(0.0, 0.0, i == 1 ? 0.0 : 0.2);
    joint.axis = i % 2 == 1 ? Eigen::Vector3d::UnitZ() : Eigen::Vector3d::UnitY();
    joint.lower = -std::numbers::pi;
    joint.upper = std::numbers::pi;
    joint.effort = 1000.0;
    joint.velocity = 10.0;
    tree.joints.push_back(joint);
  }
  return tree;
}

}  // namespace geodesic::bench
