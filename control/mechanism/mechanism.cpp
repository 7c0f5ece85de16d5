// Builds a Mechanism from a description: order, capacities, merging of fixed links.
#include "control/mechanism/mechanism.hpp"

#include <cmath>
#include <map>
#include <stdexcept>

#include "control/mechanism/tree_order.hpp"

namespace geodesic::control {
namespace {

/// A rotation whose third column is `axis`; a permutation with signs where the axis is a coordinate
/// axis, so that zeros stay zeros.
Eigen::Matrix3d frame_with_z_along(const Eigen::Vector3d& axis) {
  Eigen::Index largest = 0;
  axis.cwiseAbs().maxCoeff(&largest);
  const Eigen::Vector3d helper = Eigen::Vector3d::Unit((largest + 1) % 3);
  Eigen::Matrix3d frame;
  frame.col(2) = axis.normalized();
  frame.col(0) = (helper - helper.dot(frame.col(2)) * frame.col(2)).normalized();
  frame.col(1) = frame.col(2).cross(frame.col(0));
  return frame;
}

RigidInertia rigid_inertia(const LinkInertia& link) {
  RigidInertia body;
  body.mass = link.mass_kg;
  body.first_moment = link.mass_kg * link.com_m;
  body.rotational = link.inertia_kg_m2 + shifted(link.com_m, (0.5 * link.mass_kg) * link.com_m);
  return body;
}

Pose to_pose(const Eigen::Isometry3d& isometry) {
  return {isometry.linear(), isometry.translation()};
}

void check_capacity(std::size_t found, int capacity, const char* what, const std::string& at) {
  if (found > static_cast<std::size_t>(capacity)) {
    throw std::invalid_argument("joint '" + at + "' is " + what + " number " +
                                std::to_string(found) + "; a mechanism holds at most " +
                                std::to_string(capacity));
  }
}

}  // namespace

Mechanism::Mechanism(const TreeDescription& tree, const Eigen::Vector3d& gravity,
                     const MechanismOptions& options)
    : name_(tree.name), base_(options.base), gravity_(gravity) {
  if (!gravity.allFinite()) {
    throw std::invalid_argument("gravity holds a number that is not finite");
  }
  check_tree(tree);
  assemble(tree);
  compact_ = compact(bodies_);
  set_rotor_inertia(options.rotor_inertia);
}

void Mechanism::assemble(const TreeDescription& tree) {
  const std::vector<const JointDescription*> order = depth_first(tree);

  // The target of a mimic joint may come later in the order, so degrees of freedom are named first.
  std::map<std::string, int> dof_of_joint;
  dof_ = first_joint_v();
  std::size_t moving = 0;
  for (const JointDescription* joint : order) {
    if (joint->kind == JointKind::kFixed) {
      continue;
    }
    check_capacity(++moving, kMaxMovingJoints, "moving joint", joint->name);
    if (joint->mimic) {
      continue;
    }
    dof_of_joint[joint->name] = dof_++;
    joint_names_.push_back(joint->name);
    joint_kinds_.push_back(joint->kind);
    joint_limits_.push_back({joint->lower, joint->upper, joint->effort, joint->velocity});
    check_capacity(joint_names_.size(), kMaxMechanismJoints, "independent joint", joint->name);
  }

  std::map<std::string, const LinkInertia*> inertia_of_link;
  for (const auto& link : tree.links) {
    inertia_of_link[link.name] = &link.inertia;
  }
  std::map<std::string, std::size_t> index_of_link;
  const auto add_link = [&](const std::string& name, int body, const Pose& body_from_link) {
    index_of_link[name] = links_.size();
    links_.push_back({name, body, body_from_link});
    if (body != kWorld) {
      bodies_[static_cast<std::size_t>(body)].inertia +=
          to_parent(body_from_link, rigid_inertia(*inertia_of_link.at(name)));
      moving_mass_ += inertia_of_link.at(name)->mass_kg;
    }
  };

  if (floating()) {
    Body base;
    base.motion = Motion::kFree;
    bodies_.push_back(base);
  }
  add_link(tree.root_link, floating() ? 0 : kWorld, Pose{});
  for (const JointDescription* joint : order) {
    const LinkFrame& parent = links_[index_of_link.at(joint->parent_link)];
    const Pose parent_from_joint = parent.body_from_link * to_pose(joint->parent_from_joint);
    if (joint->kind == JointKind::kFixed) {
      add_link(joint->child_link, parent.body, parent_from_joint);
      continue;
    }
    const Pose joint_from_body{frame_with_z_along(joint->axis), Eigen::Vector3d::Zero()};
    Body body;
    body.parent = parent.body;
    body.motion = joint->kind == JointKind::kPrismatic ? Motion::kTranslation : Motion::kRotation;
    body.dof = dof_of_joint.at(joint->mimic ? joint->mimic->joint : joint->name);
    if (joint->mimic) {
      body.ratio = joint->mimic->multiplier;
      body.offset = joint->mimic->offset;
    }
    body.parent_from_joint = parent_from_joint * joint_from_body;
    bodies_.push_back(body);
    add_link(joint->child_link, static_cast<int>(bodies_.size()) - 1, inverse(joint_from_body));
  }
}

void Mechanism::set_rotor_inertia(const Eigen::VectorXd& rotor_inertia) {
  rotor_inertia_ = Eigen::VectorXd::Zero(dof_);
  if (rotor_inertia.size() == 0) {
    return;
  }
  if (rotor_inertia.size() != dof_ - first_joint_v()) {
    throw std::invalid_argument(
        "rotor inertia is given for " + std::to_string(rotor_inertia.size()) +
        " joints; the mechanism has " + std::to_string(dof_ - first_joint_v()));
  }
  for (std::size_t i = 0; i < joint_names_.size(); ++i) {
    const double value = rotor_inertia[static_cast<Eigen::Index>(i)];
    if (!std::isfinite(value) || value < 0.0) {
      throw std::invalid_argument("joint '" + joint_names_[i] + "': its rotor inertia is " +
                                  std::to_string(value) + "; expected a finite number >= 0");
    }
    rotor_inertia_[first_joint_v() + static_cast<Eigen::Index>(i)] = value;
  }
}

std::optional<int> Mechanism::find_link(std::string_view link_name) const noexcept {
  for (std::size_t i = 0; i < links_.size(); ++i) {
    if (links_[i].name == link_name) {
      return static_cast<int>(i);
    }
  }
  return std::nullopt;
}

std::optional<int> Mechanism::find_joint(std::string_view joint_name) const noexcept {
  for (std::size_t i = 0; i < joint_names_.size(); ++i) {
    if (joint_names_[i] == joint_name) {
      return static_cast<int>(i);
    }
  }
  return std::nullopt;
}

}  // namespace geodesic::control
