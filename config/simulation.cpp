// [simulation] and the joints' simulation tables: what the simulated arm adds to the URDF.
#include <fmt/format.h>

#include <algorithm>

#include "config/checks.hpp"

namespace geodesic::config {
namespace {

double start_position(const control::JointTuning& joint) {
  if (joint.position_lower <= 0.0 && joint.position_upper >= 0.0) return 0.0;
  return 0.5 * (joint.position_lower + joint.position_upper);
}

}  // namespace

void fill_simulation(Draft& draft) {
  const SimulationEntry& from = draft.file.simulation;
  SimulationOptions& to = draft.robot.simulation;
  to.floor = from.floor_z_m.given;
  to.floor_z_m = from.floor_z_m.value;
  to.reply_latency_s = from.reply_latency_us.value * 1e-6;

  const std::vector<control::JointTuning>& joints = draft.robot.controller.joints;
  std::vector<std::string> names;
  for (const control::JointTuning& joint : joints) {
    names.push_back(joint.name);
    SimulatedJoint simulated{joint.coulomb_friction, joint.viscous_friction, joint.rotor_inertia};
    for (const JointEntry& entry : draft.file.joints) {
      if (entry.name.value != joint.name) continue;
      const SimulatedJointEntry& says = entry.simulation;
      if (says.coulomb_friction.given) simulated.coulomb_friction = says.coulomb_friction.value;
      if (says.viscous_friction.given) simulated.viscous_friction = says.viscous_friction.value;
      if (says.rotor_inertia.given) simulated.rotor_inertia = says.rotor_inertia.value;
    }
    to.joints.push_back(simulated);
    to.pose.push_back(start_position(joint));
  }
  for (const NamedNumber& named : from.pose) {
    const auto found = std::find(names.begin(), names.end(), named.name);
    if (found == names.end()) {
      draft.findings.error(named.name_place,
                           fmt::format("pose: there is no [[joint]] {}{}", quote(named.name),
                                       did_you_mean(named.name, names)));
      continue;
    }
    const auto i = static_cast<std::size_t>(found - names.begin());
    if (named.value < joints[i].position_lower || named.value > joints[i].position_upper) {
      draft.findings.error(
          named.value_place,
          fmt::format("pose: {} for joint {} is outside its limits, {} to {}", named.value,
                      quote(named.name), joints[i].position_lower, joints[i].position_upper));
    }
    to.pose[i] = named.value;
  }
}

}  // namespace geodesic::config
