// The options of one joint and its drive, declared once; see robot_file.cpp for all others.
#include "config/joint_options.hpp"

#include <algorithm>

#include "config/watch_options.hpp"
#include "drivers/families.hpp"

namespace geodesic::config {
namespace {

void describe_setting(OptionVisitor& o, const drivers::DriveSetting& setting,
                      Given<double>& value) {
  const Spec spec{.key = setting.key,
                  .doc = setting.doc,
                  .unit = setting.unit,
                  .range = {setting.lower, setting.upper, false},
                  .choices = setting.choices,
                  .required = setting.required,
                  .live = kRestart};
  if (setting.choices.empty()) {
    o.number(spec, value);
    return;
  }
  Given<std::string> choice{std::string(setting.choices[static_cast<std::size_t>(value.value)]),
                            value.given, value.place};
  o.text(spec, choice);
  const auto at = std::find(setting.choices.begin(), setting.choices.end(), choice.value);
  value = {static_cast<double>(at - setting.choices.begin()), choice.given, choice.place};
}

void describe_drive(OptionVisitor& o, DriveEntry& e) {
  e.place = o.here();
  o.text({.key = "family",
          .doc = "The drive's protocol, for example `damiao`.",
          .required = true,
          .live = kRestart},
         e.family);
  o.integer({.key = "id",
             .doc = "Identifier the drive listens on.",
             .range = between(0, 0x1FFFFFFF),
             .required = true,
             .live = kRestart},
            e.id);
  o.integer({.key = "reply_id",
             .doc = "Identifier the drive answers on, where its family does not say.",
             .range = between(0, 0x1FFFFFFF),
             .default_text = "the family's",
             .live = kRestart},
            e.reply_id);
  o.number({.key = "position_range_rad",
            .doc = "The drive's position scaling (Damiao PMAX); read back at start and compared, "
                   "where the drive tells. Families that send floats have none.",
            .unit = "rad",
            .range = kPositive,
            .default_text = "none",
            .live = kRestart},
           e.position_range_rad);
  o.number({.key = "velocity_range_rad_s",
            .doc = "The drive's velocity scaling (Damiao VMAX); read back and compared. Families "
                   "that send floats: the most the drive can do.",
            .unit = "rad/s",
            .range = kPositive,
            .required = true,
            .live = kRestart},
           e.velocity_range_rad_s);
  o.number({.key = "torque_range_nm",
            .doc = "The drive's torque scaling (Damiao TMAX); read back and compared. Families "
                   "that send floats: the most that is ever asked of the drive.",
            .unit = "N·m",
            .range = kPositive,
            .required = true,
            .live = kRestart},
           e.torque_range_nm);
  o.number(
      {.key = "watchdog_ms",
       .doc = "Without a command for this long the drive stops on its own; at least 3 periods.",
       .unit = "ms",
       .range = {0.0, 10'000.0, true},
       .live = kRestart},
      e.watchdog_ms);
  o.flag({.key = "clear_errors",
          .doc = "Clear an error that the drive already has at start, instead of refusing.",
          .live = kRestart},
         e.clear_errors);
  o.flag(
      {.key = "error_diffusion",
       .doc = "Carry what a torque code rounds away into the next cycle, so that the mean torque "
              "is exact; for families that send torque as an integer.",
       .live = kRestart},
      e.error_diffusion);
  describe_drive_settings(o, e);
}

void describe_limits(OptionVisitor& o, JointEntry& e) {
  o.number({.key = "position_lower",
            .doc = "Hard limit: beyond it is a fault.",
            .unit = kPosition,
            .default_text = "the URDF's",
            .live = kLive},
           e.position_lower);
  o.number({.key = "position_upper",
            .doc = "Hard limit: beyond it is a fault.",
            .unit = kPosition,
            .default_text = "the URDF's",
            .live = kLive},
           e.position_upper);
  o.number({.key = "velocity_limit",
            .doc = "Faster than this is a fault.",
            .unit = kVelocity,
            .range = kPositive,
            .default_text = "the lesser of the URDF's and the drive's range",
            .live = kLive},
           e.velocity_limit);
  o.number({.key = "torque_limit",
            .doc = "No more than this is ever commanded.",
            .unit = kTorque,
            .range = kPositive,
            .default_text = "the lesser of the URDF's and the drive's range",
            .live = kLive},
           e.torque_limit);
  o.number({.key = "torque_rate_limit",
            .doc = "The command changes no faster than this.",
            .unit = "N·m/s or N/s",
            .range = kPositive,
            .default_text = "none",
            .live = kLive},
           e.torque_rate_limit);
  o.number({.key = "soft_margin",
            .doc = "A spring-damper wall begins this far inside the position limits.",
            .unit = kPosition,
            .range = kNotNegative,
            .default_text = "0.1, but at most a tenth of the travel",
            .live = kLive},
           e.soft_margin);
  o.number({.key = "wall_stiffness",
            .doc = "Spring of that wall.",
            .unit = kStiffness,
            .range = kNotNegative,
            .live = kLive},
           e.wall_stiffness);
  o.number({.key = "wall_damping",
            .doc = "Damper of that wall.",
            .unit = kDamping,
            .range = kNotNegative,
            .live = kLive},
           e.wall_damping);
  o.number({.key = "temperature_warn_c",
            .doc = "Hotter than this is a warning.",
            .unit = "°C",
            .range = between(0, 150),
            .live = kLive},
           e.temperature_warn_c);
  o.number({.key = "temperature_limit_c",
            .doc = "Hotter than this is a fault.",
            .unit = "°C",
            .range = between(0, 150),
            .live = kLive},
           e.temperature_limit_c);
  describe_joint_watch(o, e);
}

void describe_laws(OptionVisitor& o, JointEntry& e) {
  o.number({.key = "damping",
            .doc = "Law `float`: viscous damping.",
            .unit = kDamping,
            .range = kNotNegative,
            .live = kLive},
           e.damping);
  o.number({.key = "hold_stiffness",
            .doc = "Law `hold`: spring to the pose at entry.",
            .unit = kStiffness,
            .range = kNotNegative,
            .live = kLive},
           e.hold_stiffness);
  o.number({.key = "hold_damping",
            .doc = "Law `hold`: damper.",
            .unit = kDamping,
            .range = kNotNegative,
            .live = kLive},
           e.hold_damping);
  o.number({.key = "stop_damping",
            .doc = "Damper of law `damp` and of every controlled stop.",
            .unit = kDamping,
            .range = kNotNegative,
            .live = kLive},
           e.stop_damping);
  o.number({.key = "drive_damping",
            .doc = "Damping inside the drive while lowering and when encoders are not trusted.",
            .unit = kDamping,
            .range = kNotNegative,
            .live = kLive},
           e.drive_damping);
  o.number({.key = "rotor_inertia",
            .doc = "The motor's rotor, reflected to the joint.",
            .unit = kInertia,
            .range = kNotNegative,
            .live = kLive},
           e.rotor_inertia);
  o.number({.key = "coulomb_friction",
            .doc = "Friction that is compensated; 0: none.",
            .unit = kTorque,
            .range = kNotNegative,
            .live = kLive},
           e.coulomb_friction);
  o.number({.key = "viscous_friction",
            .doc = "Viscous friction that is compensated.",
            .unit = kDamping,
            .range = kNotNegative,
            .live = kLive},
           e.viscous_friction);
  o.number({.key = "friction_velocity",
            .doc = "Width of the smooth transition of Coulomb friction through rest.",
            .unit = kVelocity,
            .range = kPositive,
            .live = kLive},
           e.friction_velocity);
}

}  // namespace

void describe_drive_settings(OptionVisitor& o, DriveEntry& e) {
  const drivers::Family* family = drivers::find_family(e.family.value);
  if (family == nullptr) return;
  if (e.settings_of != family->name) {
    e.settings.clear();
    e.settings_of = family->name;
    for (const drivers::DriveSetting& setting : family->settings) {
      e.settings.push_back({setting.value, false, {}});
    }
  }
  for (std::size_t i = 0; i < family->settings.size(); ++i) {
    describe_setting(o, family->settings[i], e.settings[i]);
  }
}

void describe_joint(OptionVisitor& o, JointEntry& e, bool defaults) {
  e.place = o.here();
  if (!defaults) {
    o.text(
        {.key = "name", .doc = "The joint's name in the URDF.", .required = true, .live = kRestart},
        e.name);
  }
  o.text(
      {.key = "bus", .doc = "Name of the bus its drive is on.", .required = true, .live = kRestart},
      e.bus);
  o.text({.key = "arm",
          .doc = "The arm it belongs to, any name: joints of an arm start and stop together. Every "
                 "joint names one, or none does: then all joints are one arm.",
          .default_text = "one arm of all joints",
          .live = kRestart},
         e.arm);
  o.integer({.key = "direction",
             .doc = "+1 or -1: sign of the drive's position at the joint.",
             .range = between(-1, 1),
             .live = kRestart},
            e.direction);
  o.number({.key = "ratio",
            .doc = "Joint units for one radian of the drive's shaft: joint = direction * ratio * "
                   "drive + offset.",
            .unit = "rad/rad or m/rad",
            .range = kPositive,
            .live = kRestart},
           e.ratio);
  o.number({.key = "offset",
            .doc = "Joint position where the drive counts 0.",
            .unit = kPosition,
            .live = kRestart},
           e.offset);
  o.number(
      {.key = "start_lower",
       .doc = "Where the joint may stand when its drive is switched on, from here to "
              "`start_upper`. Decides which turn a drive is in that forgets them; less than one "
              "turn of the drive apart.",
       .unit = kPosition,
       .default_text = "half a turn of the drive below the middle of the limits",
       .live = kRestart},
      e.start_lower);
  o.number({.key = "start_upper",
            .doc = "See `start_lower`.",
            .unit = kPosition,
            .default_text = "half a turn of the drive above it",
            .live = kRestart},
           e.start_upper);
  describe_limits(o, e);
  describe_laws(o, e);
  o.table({.key = "drive", .doc = "The drive that moves the joint.", .required = true},
          [&](OptionVisitor& t) { describe_drive(t, e.drive); });
  const auto simulation = [&](OptionVisitor& t) {
    const std::string_view same = "the joint's own";
    t.number({.key = "coulomb_friction",
              .doc = "Dry friction.",
              .unit = kTorque,
              .range = kNotNegative,
              .default_text = same,
              .live = kElsewhere},
             e.simulation.coulomb_friction);
    t.number({.key = "viscous_friction",
              .doc = "Viscous friction.",
              .unit = kDamping,
              .range = kNotNegative,
              .default_text = same,
              .live = kElsewhere},
             e.simulation.viscous_friction);
    t.number({.key = "rotor_inertia",
              .doc = "The rotor, reflected to the joint.",
              .unit = kInertia,
              .range = kNotNegative,
              .default_text = same,
              .live = kElsewhere},
             e.simulation.rotor_inertia);
  };
  o.table({.key = "simulation",
           .doc = "What the simulated arm adds to the URDF at this joint; the controller does not "
                  "know of it."},
          simulation);
}

}  // namespace geodesic::config
