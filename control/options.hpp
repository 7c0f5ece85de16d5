// Everything that tunes the controller, as plain checked numbers. config/ fills it in; nothing here
// reads files. Defaults are what a careful user would start with.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "control/bit_set.hpp"
#include "control/joint.hpp"

namespace geodesic::control {

/// What to do with the arm while active.
enum class LawKind : std::uint8_t {
  kFloat,  ///< gravity + Coriolis compensation, optional joint damping
  kHold,   ///< float plus joint impedance around the pose at entry
  kDamp,   ///< float plus the stop damping: the arm sinks into rest wherever it is
  kZero,   ///< no compensation: zero torque (walls still push); for simulation and contrast only
};

/// One joint, in the mechanism's order of v. [rad, N·m] revolute; [m, N] prismatic.
struct JointTuning {
  std::string name;
  std::size_t bus = 0;  ///< its drive is on ArmState::bus[bus]

  // law
  double damping = 0.0;         ///< float: viscous damping [N·m·s/rad]
  double hold_stiffness = 0.0;  ///< hold [N·m/rad]
  double hold_damping = 0.0;    ///< hold [N·m·s/rad]
  double stop_damping = 1.0;    ///< damp law and controlled stop [N·m·s/rad]
  double drive_damping = 0.0;   ///< drive-side damping while lowering and on encoder faults

  // what the URDF does not know
  double rotor_inertia = 0.0;      ///< reflected to the joint [kg·m²]
  double coulomb_friction = 0.0;   ///< compensated, at the joint [N·m]; 0: none
  double viscous_friction = 0.0;   ///< compensated [N·m·s/rad]
  double friction_velocity = 0.1;  ///< width of the smooth Coulomb transition [rad/s], > 0

  // limits; a hard limit is a fault, a soft limit a spring-damper wall inside it
  double position_lower = -std::numeric_limits<double>::infinity();
  double position_upper = std::numeric_limits<double>::infinity();
  double position_tolerance = 0.01;  ///< beyond a limit by this is not yet a fault [rad or m]
  /// The wall begins this far inside the limit [rad or m]; at most a quarter of the range counts.
  double soft_margin = 0.1;
  double wall_stiffness = 0.0;  ///< [N·m/rad]
  double wall_damping = 0.0;    ///< [N·m·s/rad]
  double velocity_limit = std::numeric_limits<double>::infinity();
  double torque_limit = std::numeric_limits<double>::infinity();
  double torque_rate_limit = std::numeric_limits<double>::infinity();  ///< [N·m/s]
  double temperature_warn_c = 70.0;
  double temperature_limit_c = 85.0;

  // what watches the joint; infinite: it does not
  /// An external torque of this size is a contact, found within 10 ms [N·m].
  double contact_torque = std::numeric_limits<double>::infinity();
  /// At arm-up, measured and modelled torque may differ by this [N·m]; bounds the start's spring.
  double static_torque_tolerance = std::numeric_limits<double>::infinity();
  /// Velocity swinging by this to either side may be a limit cycle [rad/s].
  double vibration_velocity = std::numeric_limits<double>::infinity();
};

/// What to do when something pushes the arm.
enum class ContactReaction : std::uint8_t {
  kReport,  ///< carry on and say so
  kDamp,    ///< the damp law, until the contact has gone
  kStop,    ///< a controlled stop
};

/// What the other arms of a robot do when one has a fault.
enum class OtherArm : std::uint8_t {
  kStop,     ///< each comes to its own controlled stop
  kCarryOn,  ///< nothing
};

struct SafetyOptions {
  // A joint that misses replies, in cycles in a row: predicted, damped, stopped.
  int carry_on_cycles = 2;    ///< for as long it is predicted to move on; the law goes on
  int damp_cycles = 3;        ///< from then on it is at rest for us, its drive damps, its law fades
  int silent_cycles = 5;      ///< from then on it is a fault
  int overrun_cycles = 10;    ///< as many overruns in a row are a fault
  double start_ramp_s = 1.0;  ///< authority rises from 0 to 1 in this time
  double stop_rest_velocity = 0.05;  ///< below it on every joint, the arm is at rest [rad/s, m/s]
  double stop_rest_s = 0.1;          ///< for this long
  double stop_timeout_s = 2.0;       ///< a controlled stop goes on to lowering after this
  double lower_s = 1.0;              ///< authority falls from 1 to 0, drives damping
  double settle_timeout_s = 2.0;     ///< then drives damp until the arm rests, but no longer
  double connect_timeout_s = 3.0;    ///< every joint must be configured and reporting by then
  double enable_timeout_s = 0.5;     ///< every drive must report enabled by then
  double start_velocity = 0.1;       ///< starting needs rest: every joint below this [rad/s, m/s]
  double encoder_jump = 0.5;    ///< a step in one cycle beyond velocity allows: not trusted [rad]
  double encoder_stuck = 0.02;  ///< way that velocity says while position stands still [rad or m]
  ContactReaction contact = ContactReaction::kReport;
  OtherArm other_arm = OtherArm::kStop;
};

/// The observer of external torque, and when a contact begins and ends (safety/contact.hpp).
struct ContactOptions {
  double observer_hz = 50.0;  ///< corner of the observed torque; 0: nothing is observed
  /// The observer is driven by the torque drives report; false: by the torque they were told.
  bool measured_torque = true;
  double hysteresis = 0.3;  ///< a contact ends below (1 - hysteresis) of where it began, 0..1
  double release_s = 0.1;   ///< ... and after as long without
};

/// The vibration detector (safety/vibration.hpp).
struct VibrationOptions {
  double lowest_hz = 5.0;  ///< slower is a hand's work
  double highest_hz = 200.0;
  int half_cycles = 10;             ///< as many in a row are a limit cycle
  double lowest_authority = 0.125;  ///< of the gains; vibrating still, the arm is stopped
};

inline constexpr std::size_t kMaxArms = 8;

/// Joints that start and stop together.
struct ArmGroup {
  std::string name;
  BitSet joints = 0;
};

struct ControllerOptions {
  LawKind law = LawKind::kFloat;
  bool start_active = true;           ///< go to active(law) as soon as ready
  bool allow_zero_law = false;        ///< simulation only
  double velocity_filter_hz = 100.0;  ///< first-order low pass on measured velocity; 0: none
  /// Share of the Coriolis torque C(q, v) v that is compensated, 0..1. All of it: left alone,
  /// joints keep their velocities. None: the arm moves along geodesics of its kinetic-energy
  /// metric.
  double coriolis = 1.0;
  double retune_s = 0.5;            ///< an exchange of options changes torque over this time
  std::vector<JointTuning> joints;  ///< one for every degree of freedom, in order of v
  std::vector<ArmGroup> arms;       ///< empty: one arm of all joints (arms.hpp)
  SafetyOptions safety;
  ContactOptions contact;
  VibrationOptions vibration;
  /// The link that payloads are on, for the words of a static_torque fault; empty: the last one.
  std::string tool_link;
};

/// "float", "hold", "damp", "zero": as files and the command line say it.
const char* to_string(LawKind law) noexcept;
/// The law of that name; nothing if there is none.
std::optional<LawKind> law_from_string(std::string_view name) noexcept;

/// What is wrong with these options, each a sentence that names the joint and the option; empty:
/// nothing. Controller refuses what this complains of. Not real-time.
std::vector<std::string> check(const ControllerOptions& options);

}  // namespace geodesic::control
