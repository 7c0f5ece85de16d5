// [[joint]] arm = "left": joints to arms, in the order in which the file's joints first name them.
#include "control/arms.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "config/checks.hpp"
#include "control/mechanism/mechanism.hpp"

namespace geodesic::config {
namespace {

const JointEntry* entry_of(const Draft& draft, const std::string& joint) {
  for (const JointEntry& entry : draft.file.joints) {
    if (entry.name.value == joint) return &entry;
  }
  return nullptr;
}

/// Joints that carry each other are one arm; told at the robot file, since two joints are to blame.
void check_carried(Draft& draft) {
  const control::ControllerOptions& options = draft.robot.controller;
  if (!draft.urdf.ok || draft.findings.has_errors()) return;
  try {
    const control::Mechanism mechanism(draft.urdf.tree, draft.robot.gravity);
    for (const std::string& wrong : control::check_arms(options, mechanism)) {
      draft.findings.error(draft.file.robot.urdf.place, fmt::format("arms: {}", wrong));
    }
  } catch (const std::invalid_argument&) {
    return;  // fill_joints has told of a URDF that makes no mechanism
  }
}

}  // namespace

void fill_arms(Draft& draft) {
  control::ControllerOptions& options = draft.robot.controller;
  const auto& joints = draft.file.joints;
  if (std::none_of(joints.begin(), joints.end(), [](const auto& e) { return e.arm.given; })) {
    return;
  }
  for (std::size_t i = 0; i < std::min(options.joints.size(), control::kMaxJoints); ++i) {
    const JointEntry* entry = entry_of(draft, options.joints[i].name);
    if (entry == nullptr) continue;
    if (!entry->arm.given) {
      draft.findings.error(entry->place, fmt::format("arm: joint {} has none, though others have; "
                                                     "name the arm it belongs to",
                                                     quote(entry->name.value)));
      continue;
    }
    auto arm = std::find_if(options.arms.begin(), options.arms.end(),
                            [&](const auto& known) { return known.name == entry->arm.value; });
    if (arm == options.arms.end()) {
      if (options.arms.size() == control::kMaxArms) {
        draft.findings.error(entry->arm.place,
                             fmt::format("arm: {} is one too many, expected at "
                                         "most {}",
                                         quote(entry->arm.value), control::kMaxArms));
        return;
      }
      arm = options.arms.insert(options.arms.end(), {entry->arm.value, 0});
    }
    arm->joints |= control::bit(i);
  }
  check_carried(draft);
}

}  // namespace geodesic::config
