// Arms from options, and what may be one.
#include "control/arms.hpp"

#include <algorithm>

namespace geodesic::control {

Arms arms_of(const ControllerOptions& options) {
  Arms arms;
  const std::size_t joints = std::min(options.joints.size(), kMaxJoints);
  if (options.arms.empty()) {
    arms.joints[0] = first(joints);
    arms.buses[0] = first(kMaxBuses);
    return arms;
  }
  arms.count = std::min(options.arms.size(), kMaxArms);
  for (std::size_t a = 0; a < arms.count; ++a) {
    arms.joints[a] = options.arms[a].joints & first(joints);
    arms.buses[a] = arms.count == 1 ? first(kMaxBuses) : 0;
    for (std::size_t i = 0; i < joints; ++i) {
      if (has(arms.joints[a], i)) {
        arms.arm_of[i] = static_cast<std::uint8_t>(a);
        arms.buses[a] |= options.joints[i].bus < kMaxBuses ? bit(options.joints[i].bus) : 0;
      }
    }
  }
  return arms;
}

std::string arm_name(const ControllerOptions& options, std::size_t arm) {
  return arm < options.arms.size() ? options.arms[arm].name : "arm";
}

std::vector<std::string> check_arms(const ControllerOptions& options) {
  std::vector<std::string> complaints;
  if (options.arms.size() > kMaxArms) {
    complaints.push_back("there are " + std::to_string(options.arms.size()) +
                         " arms, expected at most " + std::to_string(kMaxArms));
  }
  BitSet seen = 0;
  for (std::size_t a = 0; a < options.arms.size(); ++a) {
    const ArmGroup& arm = options.arms[a];
    for (std::size_t b = 0; b < a; ++b) {
      if (options.arms[b].name == arm.name) {
        complaints.push_back("two arms are called '" + arm.name + "'");
      }
    }
    if (arm.joints == 0) {
      complaints.push_back("arm '" + arm.name + "' has no joint");
    }
    for (std::size_t i = 0; i < 32; ++i) {
      if (has(arm.joints & seen, i)) {
        complaints.push_back("joint " + std::to_string(i) + " belongs to two arms, '" + arm.name +
                             "' is the second");
      }
    }
    seen |= arm.joints;
  }
  if (!options.arms.empty() && seen != first(options.joints.size())) {
    for (std::size_t i = 0; i < options.joints.size(); ++i) {
      if (!has(seen, i)) {
        complaints.push_back("joint '" + options.joints[i].name + "' belongs to no arm");
      }
    }
    if ((seen & ~first(options.joints.size())) != 0) {
      complaints.emplace_back("an arm has a joint that does not exist");
    }
  }
  return complaints;
}

std::vector<std::string> check_arms(const ControllerOptions& options, const Mechanism& mechanism) {
  std::vector<std::string> complaints = check_arms(options);
  if (!complaints.empty() || mechanism.joint_names().size() != options.joints.size()) {
    return complaints;
  }
  const Arms arms = arms_of(options);
  const std::vector<Body>& bodies = mechanism.bodies();
  for (const Body& body : bodies) {
    for (int up = body.parent; up != kWorld; up = bodies[static_cast<std::size_t>(up)].parent) {
      const auto lower = static_cast<std::size_t>(body.dof - mechanism.first_joint_v());
      const auto upper = static_cast<std::size_t>(bodies[static_cast<std::size_t>(up)].dof -
                                                  mechanism.first_joint_v());
      if (lower < options.joints.size() && upper < options.joints.size() &&
          arms.arm_of[lower] != arms.arm_of[upper]) {
        complaints.push_back("joint '" + options.joints[lower].name + "' of arm '" +
                             arm_name(options, arms.arm_of[lower]) + "' hangs on joint '" +
                             options.joints[upper].name + "' of arm '" +
                             arm_name(options, arms.arm_of[upper]) +
                             "': joints that carry each other are one arm");
      }
    }
  }
  return complaints;
}

}  // namespace geodesic::control
