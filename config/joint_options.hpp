// The options of one joint and its drive, and the units that joints count in. Declares; reads
// nothing.
#pragma once

#include "config/robot_file.hpp"

namespace geodesic::config {

inline constexpr std::string_view kTorque = "N·m or N";
inline constexpr std::string_view kPosition = "rad or m";
inline constexpr std::string_view kVelocity = "rad/s or m/s";
inline constexpr std::string_view kStiffness = "N·m/rad or N/m";
inline constexpr std::string_view kDamping = "N·m·s/rad or N·s/m";
inline constexpr std::string_view kInertia = "kg·m² or kg";

/// Shows the options that the drive's family alone has (none while it is not known).
void describe_drive_settings(OptionVisitor& o, DriveEntry& e);

/// Shows every option of a joint to the visitor; with `defaults` all but its name.
void describe_joint(OptionVisitor& o, JointEntry& e, bool defaults);

}  // namespace geodesic::config
