// The layout of a robot file: what may stand in it, as written, with places. Checked against the
// URDF and the drives, and turned into option structs, elsewhere (robot.cpp).
#pragma once

#include <string>
#include <vector>

#include "config/options/options.hpp"

namespace geodesic::config {

/// How a file says that nothing is carried.
inline constexpr std::string_view kNoPayload = "none";

struct RobotEntry {
  Given<std::string> name, urdf, tool_link;
  Given<std::array<double, 3>> gravity{{0.0, 0.0, -9.81}, false, {}};
  Given<double> rate_hz{1000.0, false, {}};
  Given<std::string> payload{std::string(kNoPayload), false, {}};
  std::vector<NamedNumber> lock;
};

struct RealtimeEntry {
  Given<std::int64_t> priority{RealtimeOptions{}.priority, false, {}};
  Given<std::vector<std::int64_t>> cpus;
  Given<double> receive_deadline{RealtimeOptions{}.receive_deadline, false, {}};
};

struct BusEntry {
  Place place;
  Given<std::string> name, interface;
  Given<bool> fd;
  Given<std::int64_t> bit_rate{drivers::BusOptions{}.bit_rate, false, {}};
  Given<std::int64_t> data_bit_rate{drivers::BusOptions{}.data_bit_rate, false, {}};
  Given<bool> bring_up{true, false, {}};
  Given<double> sample_point, data_sample_point;
  Given<std::int64_t> restart_ms{drivers::kDefaultRestartMs, false, {}};
  Given<std::int64_t> queue{drivers::kDefaultQueue, false, {}};
};

struct DriveEntry {
  Place place;
  Given<std::string> family;
  Given<std::int64_t> id, reply_id;
  Given<double> position_range_rad, velocity_range_rad_s, torque_range_nm;
  Given<double> watchdog_ms{
      static_cast<double>(drivers::DriveOptions{}.watchdog_ns) * 1e-6, false, {}};
  Given<bool> clear_errors, error_diffusion;
  /// The family's own, in the order of its table; a choice is its index.
  std::vector<Given<double>> settings;
  std::string settings_of;  ///< the family they are of
};

struct SimulatedJointEntry {
  Given<double> coulomb_friction, viscous_friction, rotor_inertia;
};

struct JointEntry {
  Place place;
  Given<std::string> name, bus, arm;
  DriveEntry drive;
  Given<std::int64_t> direction{1, false, {}};
  Given<double> ratio{1.0, false, {}};
  Given<double> offset, start_lower, start_upper;

  Given<double> position_lower, position_upper, velocity_limit, torque_limit, torque_rate_limit;
  Given<double> soft_margin{control::JointTuning{}.soft_margin, false, {}};
  Given<double> wall_stiffness{control::JointTuning{}.wall_stiffness, false, {}};
  Given<double> wall_damping{control::JointTuning{}.wall_damping, false, {}};
  Given<double> damping{control::JointTuning{}.damping, false, {}};
  Given<double> hold_stiffness{control::JointTuning{}.hold_stiffness, false, {}};
  Given<double> hold_damping{control::JointTuning{}.hold_damping, false, {}};
  Given<double> stop_damping{control::JointTuning{}.stop_damping, false, {}};
  Given<double> drive_damping{control::JointTuning{}.drive_damping, false, {}};
  Given<double> rotor_inertia{control::JointTuning{}.rotor_inertia, false, {}};
  Given<double> coulomb_friction{control::JointTuning{}.coulomb_friction, false, {}};
  Given<double> viscous_friction{control::JointTuning{}.viscous_friction, false, {}};
  Given<double> friction_velocity{control::JointTuning{}.friction_velocity, false, {}};
  Given<double> temperature_warn_c{control::JointTuning{}.temperature_warn_c, false, {}};
  Given<double> temperature_limit_c{control::JointTuning{}.temperature_limit_c, false, {}};
  Given<double> contact_torque, static_torque_tolerance, vibration_velocity;
  SimulatedJointEntry simulation;
};

struct ControlEntry {
  Given<std::string> law{"float", false, {}};
  Given<bool> start_active{control::ControllerOptions{}.start_active, false, {}};
  Given<double> velocity_filter_hz{control::ControllerOptions{}.velocity_filter_hz, false, {}};
  Given<double> coriolis{control::ControllerOptions{}.coriolis, false, {}};
  Given<double> retune_s{control::ControllerOptions{}.retune_s, false, {}};
  Given<std::string> compiled;
};

struct SafetyEntry {
  Given<std::int64_t> carry_on_cycles{control::SafetyOptions{}.carry_on_cycles, false, {}};
  Given<std::int64_t> damp_cycles{control::SafetyOptions{}.damp_cycles, false, {}};
  Given<std::int64_t> silent_cycles{control::SafetyOptions{}.silent_cycles, false, {}};
  Given<std::int64_t> overrun_cycles{control::SafetyOptions{}.overrun_cycles, false, {}};
  Given<double> start_ramp_s{control::SafetyOptions{}.start_ramp_s, false, {}};
  Given<double> stop_rest_velocity{control::SafetyOptions{}.stop_rest_velocity, false, {}};
  Given<double> stop_rest_s{control::SafetyOptions{}.stop_rest_s, false, {}};
  Given<double> stop_timeout_s{control::SafetyOptions{}.stop_timeout_s, false, {}};
  Given<double> lower_s{control::SafetyOptions{}.lower_s, false, {}};
  Given<double> settle_timeout_s{control::SafetyOptions{}.settle_timeout_s, false, {}};
  Given<std::string> other_arm{"stop", false, {}};
  Given<double> connect_timeout_s{control::SafetyOptions{}.connect_timeout_s, false, {}};
  Given<double> enable_timeout_s{control::SafetyOptions{}.enable_timeout_s, false, {}};
  Given<double> start_velocity{control::SafetyOptions{}.start_velocity, false, {}};
  Given<double> encoder_jump{control::SafetyOptions{}.encoder_jump, false, {}};
  Given<double> encoder_stuck{control::SafetyOptions{}.encoder_stuck, false, {}};
};

struct ContactEntry {
  Given<std::string> reaction{"report", false, {}};
  Given<std::string> torque{"measured", false, {}};
  Given<double> observer_hz{control::ContactOptions{}.observer_hz, false, {}};
  Given<double> hysteresis{control::ContactOptions{}.hysteresis, false, {}};
  Given<double> release_s{control::ContactOptions{}.release_s, false, {}};
};

struct VibrationEntry {
  Given<double> lowest_hz{control::VibrationOptions{}.lowest_hz, false, {}};
  Given<double> highest_hz{control::VibrationOptions{}.highest_hz, false, {}};
  Given<std::int64_t> half_cycles{control::VibrationOptions{}.half_cycles, false, {}};
  Given<double> lowest_authority{control::VibrationOptions{}.lowest_authority, false, {}};
};

struct PayloadEntry {
  Place place;
  Given<std::string> name, link;
  Given<double> mass;
  Given<std::array<double, 3>> com, inertia, products;
};

struct SimulationEntry {
  Given<std::string> payload{std::string(kNoPayload), false, {}};
  std::vector<NamedNumber> pose;
  Given<double> floor_z_m;
  Given<double> reply_latency_us{SimulationOptions{}.reply_latency_s * 1e6, false, {}};
};

struct RobotFile {
  RobotEntry robot;
  RealtimeEntry realtime;
  std::vector<BusEntry> buses;
  JointEntry joint_defaults;
  std::vector<JointEntry> joints;
  std::vector<PayloadEntry> payloads;
  ControlEntry control;
  SafetyEntry safety;
  ContactEntry contact;
  VibrationEntry vibration;
  SimulationEntry simulation;
};

/// Shows every option of a robot file to the visitor, in the order of the reference.
void describe(OptionVisitor& file, RobotFile& out);

}  // namespace geodesic::config
