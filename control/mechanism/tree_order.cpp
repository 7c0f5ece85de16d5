// Implements tree_order.hpp.
#include "control/mechanism/tree_order.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <stdexcept>
#include <string>

namespace geodesic::control {
namespace {

using JointsByName = std::map<std::string, const JointDescription*>;

[[noreturn]] void refuse(const std::string& text) {
  throw std::invalid_argument(text);
}

std::string link_text(const std::string& name) {
  return "link '" + name + "'";
}
std::string joint_text(const std::string& name) {
  return "joint '" + name + "'";
}

void check_numbers(const LinkDescription& link) {
  const LinkInertia& inertia = link.inertia;
  if (!std::isfinite(inertia.mass_kg) || !inertia.com_m.allFinite() ||
      !inertia.inertia_kg_m2.allFinite()) {
    refuse(link_text(link.name) + ": its inertia holds a number that is not finite");
  }
  if (inertia.mass_kg < 0.0) {
    refuse(link_text(link.name) + ": its mass is negative (" + std::to_string(inertia.mass_kg) +
           " kg)");
  }
  const Eigen::Matrix3d& i = inertia.inertia_kg_m2;
  if (!(i - i.transpose()).isZero(1e-12 * (1.0 + i.norm()))) {
    refuse(link_text(link.name) + ": its inertia matrix is not symmetric");
  }
}

void check_axis(const JointDescription& joint) {
  if (!joint.axis.allFinite()) {
    refuse(joint_text(joint.name) + ": its axis holds a number that is not finite");
  }
  if (joint.axis.isZero(0.0)) {
    refuse(joint_text(joint.name) + ": its axis is zero; expected a unit vector");
  }
  if (std::abs(joint.axis.norm() - 1.0) > 1e-9) {
    refuse(joint_text(joint.name) + ": its axis has length " + std::to_string(joint.axis.norm()) +
           "; expected a unit vector");
  }
}

void check_numbers(const JointDescription& joint) {
  const Eigen::Matrix3d rotation = joint.parent_from_joint.linear();
  if (!rotation.allFinite() || !joint.parent_from_joint.translation().allFinite()) {
    refuse(joint_text(joint.name) + ": its origin holds a number that is not finite");
  }
  const Eigen::Matrix3d gram = rotation.transpose() * rotation;
  if (!gram.isIdentity(1e-9) || rotation.determinant() < 0.0) {
    refuse(joint_text(joint.name) + ": its origin's rotation is not a rotation matrix");
  }
  if (joint.kind == JointKind::kFixed) {
    return;
  }
  if (coordinates(joint.kind) == freedoms(joint.kind)) {
    check_axis(joint);
  }
  if (std::isnan(joint.lower) || std::isnan(joint.upper) || std::isnan(joint.effort) ||
      std::isnan(joint.velocity)) {
    refuse(joint_text(joint.name) + ": a limit is not a number");
  }
  if (joint.lower > joint.upper) {
    refuse(joint_text(joint.name) + ": its lower limit " + std::to_string(joint.lower) +
           " is above its upper limit " + std::to_string(joint.upper));
  }
  if (joint.mimic &&
      (!std::isfinite(joint.mimic->multiplier) || !std::isfinite(joint.mimic->offset))) {
    refuse(joint_text(joint.name) + ": mimic multiplier or offset is not finite");
  }
}

void check_mimic(const JointDescription& joint, const JointsByName& joints) {
  if (joint.kind == JointKind::kFixed || !joint.mimic) {
    return;
  }
  if (freedoms(joint.kind) != 1) {
    refuse(joint_text(joint.name) + " is " + kind_name(joint.kind) +
           " and mimics another; only a joint with one degree of freedom can");
  }
  const std::string text = joint_text(joint.name) + " mimics ";
  if (joint.mimic->joint == joint.name) {
    refuse(text + "itself");
  }
  const auto target = joints.find(joint.mimic->joint);
  if (target == joints.end()) {
    refuse(text + joint_text(joint.mimic->joint) + ", which does not exist");
  }
  if (target->second->kind == JointKind::kFixed) {
    refuse(text + joint_text(target->first) +
           ", which is fixed; make the mimicking joint fixed too, or free its target");
  }
  if (freedoms(target->second->kind) != 1) {
    refuse(text + joint_text(target->first) + ", which is " + kind_name(target->second->kind) +
           "; only a joint with one degree of freedom can be mimicked");
  }
  if (target->second->mimic) {
    refuse(text + joint_text(target->first) +
           ", which itself mimics another; name the independent joint directly");
  }
}

/// Every link but the root hangs on exactly one joint, and following it upwards ends at the root.
void check_connections(const TreeDescription& tree) {
  std::set<std::string> links;
  for (const auto& link : tree.links) {
    if (!links.insert(link.name).second) {
      refuse(link_text(link.name) + " is described twice");
    }
  }
  if (tree.root_link.empty()) {
    refuse("the tree names no root link");
  }
  if (links.count(tree.root_link) == 0) {
    refuse("the root " + link_text(tree.root_link) + " is not among the links");
  }
  std::map<std::string, const JointDescription*> above;
  for (const auto& joint : tree.joints) {
    for (const auto* name : {&joint.parent_link, &joint.child_link}) {
      if (links.count(*name) == 0) {
        refuse(joint_text(joint.name) + " connects to " + link_text(*name) +
               ", which does not exist");
      }
    }
    const auto [other, is_first] = above.emplace(joint.child_link, &joint);
    if (!is_first) {
      refuse(link_text(joint.child_link) + " has two parents, by " +
             joint_text(other->second->name) + " and " + joint_text(joint.name));
    }
  }
  std::set<std::string> rooted;  // links already known to lead to the root
  for (const auto& link : tree.links) {
    std::vector<std::string> path;
    std::string at = link.name;
    while (rooted.count(at) == 0) {
      path.push_back(at);
      const auto joint = above.find(at);
      if (joint == above.end()) {
        if (at != tree.root_link) {
          refuse(link_text(at) + " hangs on no joint though the root is " +
                 link_text(tree.root_link) + "; a tree has one root");
        }
        break;
      }
      if (path.size() > tree.links.size()) {
        refuse("the joints form a cycle through " + link_text(at));
      }
      at = joint->second->parent_link;
    }
    rooted.insert(path.begin(), path.end());
  }
}

}  // namespace

void check_tree(const TreeDescription& tree) {
  JointsByName joints;
  for (const auto& link : tree.links) {
    check_numbers(link);
  }
  for (const auto& joint : tree.joints) {
    if (!joints.emplace(joint.name, &joint).second) {
      refuse(joint_text(joint.name) + " is described twice");
    }
    check_numbers(joint);
  }
  check_connections(tree);
  for (const auto& joint : tree.joints) {
    check_mimic(joint, joints);
  }
}

std::vector<const JointDescription*> depth_first(const TreeDescription& tree) {
  std::map<std::string, std::vector<const JointDescription*>> below;
  for (const auto& joint : tree.joints) {
    below[joint.parent_link].push_back(&joint);
  }
  for (auto& [link, siblings] : below) {
    // Descending, since the last of the stack is visited first.
    std::sort(siblings.begin(), siblings.end(),
              [](const auto* a, const auto* b) { return a->name > b->name; });
  }
  std::vector<const JointDescription*> order;
  std::vector<const JointDescription*> stack = below[tree.root_link];
  while (!stack.empty()) {
    const JointDescription* joint = stack.back();
    stack.pop_back();
    order.push_back(joint);
    const auto& siblings = below[joint->child_link];
    stack.insert(stack.end(), siblings.begin(), siblings.end());
  }
  return order;
}

}  // namespace geodesic::control
