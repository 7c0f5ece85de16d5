// [robot] lock: joints that are held at a position by something other than a drive become fixed.
#include <fmt/format.h>

#include <algorithm>

#include "config/checks.hpp"

namespace geodesic::config {
namespace {

using control::JointDescription;
using control::JointKind;

void fix_at(JointDescription& joint, double position) {
  if (joint.kind == JointKind::kPrismatic) {
    joint.parent_from_joint.translate(position * joint.axis);
  } else {
    joint.parent_from_joint.rotate(Eigen::AngleAxisd(position, joint.axis));
  }
  joint.kind = JointKind::kFixed;
  joint.mimic.reset();
}

}  // namespace

void apply_locks(Draft& draft) {
  if (!draft.urdf.ok) return;
  control::TreeDescription& tree = draft.urdf.tree;
  const std::vector<std::string> known = independent_joints(tree);
  for (const NamedNumber& lock : draft.file.robot.lock) {
    const auto found = std::find_if(tree.joints.begin(), tree.joints.end(),
                                    [&](const auto& joint) { return joint.name == lock.name; });
    if (found == tree.joints.end()) {
      draft.findings.error(lock.name_place,
                           fmt::format("lock: the URDF has no joint {}{}", quote(lock.name),
                                       did_you_mean(lock.name, known)));
      continue;
    }
    if (found->mimic) {
      draft.findings.error(lock.name_place,
                           fmt::format("lock: joint {} mimics {}; lock that one", quote(lock.name),
                                       quote(found->mimic->joint)));
      continue;
    }
    if (found->kind == JointKind::kFixed) {
      draft.findings.error(lock.name_place,
                           fmt::format("lock: joint {} is fixed already; remove it "
                                       "from the list",
                                       quote(lock.name)));
      continue;
    }
    if (lock.value < found->lower || lock.value > found->upper) {
      draft.findings.error(
          lock.value_place,
          fmt::format("lock: {} for joint {} is outside the URDF's limits, {} to {}", lock.value,
                      quote(lock.name), found->lower, found->upper));
      continue;
    }
    fix_at(*found, lock.value);
    for (JointDescription& joint : tree.joints) {
      if (joint.mimic && joint.mimic->joint == lock.name) {
        fix_at(joint, joint.mimic->multiplier * lock.value + joint.mimic->offset);
      }
    }
  }
}

}  // namespace geodesic::config
