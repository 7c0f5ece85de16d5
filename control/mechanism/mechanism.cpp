// Builds a Mechanism from a description: order, capacities, merging of fixed links.
#include "control/mechanism/mechanism.hpp"

#include <cmath>
#include <map>
#include <stdexcept>

#include "control/mechanism/tree_order.hpp"

namespace geodesic::control {
namespace {

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

/// One body for each motion that makes up the joint.
/// @return  body_from_joint of the last, at joint position 0
Pose add_bodies(const JointDescription& joint, const Factor& factor, int parent,
                const Pose& parent_from_joint, std::vector<Body>& bodies) {
  Body body;
  body.parent = parent;
  body.dof = factor.v;
  body.coordinate = factor.q;
  body.parent_from_joint = parent_from_joint;
  if (joint.kind == JointKind::kSpherical || joint.kind == JointKind::kFloating) {
    body.motion = joint.kind == JointKind::kFloating ? Motion::kFree : Motion::kSpherical;
    bodies.push_back(body);
    return {};
  }
  const Pose joint_from_axes{in_plane(joint.axis), Eigen::Vector3d::Zero()};
  body.parent_from_joint = parent_from_joint * joint_from_axes;
  if (joint.kind == JointKind::kPlanar) {
    // z runs along x, then along y, then along the normal: each time the axes change places.
    const Pose next{in_plane(Eigen::Vector3d::UnitX()), Eigen::Vector3d::Zero()};
    body.motion = Motion::kTranslation;
    body.parent_from_joint = body.parent_from_joint * next;
    for (int i = 0; i < 2; ++i) {
      bodies.push_back(body);
      body.parent = static_cast<int>(bodies.size()) - 1;
      body.parent_from_joint = next;
      ++body.dof;
      ++body.coordinate;
    }
    body.motion = Motion::kRotation;
  } else {
    body.motion = joint.kind == JointKind::kPrismatic ? Motion::kTranslation : Motion::kRotation;
  }
  if (joint.mimic) {
    body.ratio = joint.mimic->multiplier;
    body.offset = joint.mimic->offset;
  }
  bodies.push_back(body);
  return inverse(joint_from_axes);
}

void check_capacity(std::size_t found, int capacity, const char* what, const std::string& at) {
  if (found > static_cast<std::size_t>(capacity)) {
    throw std::invalid_argument("joint '" + at + "' is " + what + " number " +
                                std::to_string(found) + "; a mechanism holds at most " +
                                std::to_string(capacity));
  }
}

}  // namespace

Eigen::Matrix3d in_plane(const Eigen::Vector3d& normal) noexcept {
  Eigen::Index largest = 0;
  normal.cwiseAbs().maxCoeff(&largest);
  const Eigen::Vector3d helper = Eigen::Vector3d::Unit((largest + 1) % 3);
  Eigen::Matrix3d axes;
  axes.col(2) = normal.normalized();
  axes.col(0) = (helper - helper.dot(axes.col(2)) * axes.col(2)).normalized();
  axes.col(1) = axes.col(2).cross(axes.col(0));
  return axes;
}

Mechanism::Mechanism(const TreeDescription& tree, const Eigen::Vector3d& gravity,
                     const MechanismOptions& options)
    : name_(tree.name), base_(options.base), gravity_(gravity) {
  if (!gravity.allFinite()) {
    throw std::invalid_argument("gravity holds a number that is not finite");
  }
  check_tree(tree);
  assemble(tree);
  compact_ = compact(bodies_, gravity_);
  set_rotor_inertia(options.rotor_inertia);
}

void Mechanism::list_factors(const std::vector<const JointDescription*>& order) {
  const auto add = [this](const std::string& name, JointKind kind) {
    factors_.push_back({name, kind, nq_, coordinates(kind), dof_, freedoms(kind)});
    nq_ += coordinates(kind);
    dof_ += freedoms(kind);
  };
  if (floating()) {
    add(kBaseName, JointKind::kFloating);
  }
  std::size_t moving = 0;
  for (const JointDescription* joint : order) {
    if (joint->kind == JointKind::kFixed) {
      continue;
    }
    check_capacity(++moving, kMaxMovingJoints, "moving joint", joint->name);
    if (joint->mimic) {
      continue;
    }
    add(joint->name, joint->kind);
    joint_names_.push_back(joint->name);
    joint_kinds_.push_back(joint->kind);
    joint_limits_.push_back({joint->lower, joint->upper, joint->effort, joint->velocity});
    check_capacity(joint_names_.size(), kMaxMechanismJoints, "independent joint", joint->name);
  }
}

void Mechanism::assemble(const TreeDescription& tree) {
  const std::vector<const JointDescription*> order = depth_first(tree);
  // The target of a mimic joint may come later in the order, so the factors are named first.
  list_factors(order);
  std::map<std::string, const Factor*> factor_of_joint;
  for (const Factor& factor : factors_) {
    factor_of_joint[factor.name] = &factor;
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
    const Factor& factor = *factor_of_joint.at(joint->mimic ? joint->mimic->joint : joint->name);
    const Pose body_from_joint =
        add_bodies(*joint, factor, parent.body, parent_from_joint, bodies_);
    add_link(joint->child_link, static_cast<int>(bodies_.size()) - 1, body_from_joint);
  }
}

void Mechanism::set_rotor_inertia(const Eigen::VectorXd& rotor_inertia) {
  rotor_inertia_ = Eigen::VectorXd::Zero(dof_);
  if (rotor_inertia.size() == 0) {
    return;
  }
  if (static_cast<std::size_t>(rotor_inertia.size()) != joint_names_.size()) {
    throw std::invalid_argument(
        "rotor inertia is given for " + std::to_string(rotor_inertia.size()) +
        " joints; the mechanism has " + std::to_string(joint_names_.size()));
  }
  const std::size_t first = floating() ? 1 : 0;
  for (std::size_t i = 0; i < joint_names_.size(); ++i) {
    const double value = rotor_inertia[static_cast<Eigen::Index>(i)];
    const Factor& factor = factors_[first + i];
    if (!std::isfinite(value) || value < 0.0) {
      throw std::invalid_argument("joint '" + factor.name + "': its rotor inertia is " +
                                  std::to_string(value) + "; expected a finite number >= 0");
    }
    if (factor.nv > 1 && value > 0.0) {
      throw std::invalid_argument("joint '" + factor.name + "': its rotor inertia is " +
                                  std::to_string(value) + ", but it is " + kind_name(factor.kind) +
                                  "; only a joint with one degree of freedom can have a rotor");
    }
    rotor_inertia_[factor.v] = value;
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
