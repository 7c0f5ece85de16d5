// The options of what watches the arm beside its limits, [contact], [vibration] and a joint's own,
// and what they become.
#pragma once

#include "config/robot_file.hpp"

namespace geodesic::config {

void describe_contact(OptionVisitor& o, ContactEntry& e);
void describe_vibration(OptionVisitor& o, VibrationEntry& e);
/// contact_torque, static_torque_tolerance, vibration_velocity.
void describe_joint_watch(OptionVisitor& o, JointEntry& e);

/// The joint's thresholds, with defaults from its torque limit and its drive's velocity range.
void watch_defaults(const JointEntry& entry, control::JointTuning& tuning);
void fill_watch(const RobotFile& file, control::ControllerOptions& controller);

}  // namespace geodesic::config
