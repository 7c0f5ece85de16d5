// Implements watch_options.hpp.
#include "config/watch_options.hpp"

#include <array>
#include <string_view>

namespace geodesic::config {
namespace {

constexpr std::array<std::string_view, 3> kReactions = {"report", "damp", "stop"};
constexpr std::array<std::string_view, 2> kTorques = {"measured", "commanded"};

}  // namespace

void describe_contact(OptionVisitor& o, ContactEntry& e) {
  o.text({.key = "reaction",
          .doc = "`report`: carry on and say so; `damp`: law damp until the contact has gone; "
                 "`stop`: a controlled stop.",
          .choices = kReactions,
          .live = kLive},
         e.reaction);
  o.text({.key = "torque",
          .doc = "What the observer takes for the drives' torque: what they report, or what they "
                 "were told.",
          .choices = kTorques,
          .live = kLive},
         e.torque);
  o.number({.key = "observer_hz",
            .doc = "Corner of the observed external torque; 0: nothing is observed. Below 40 a "
                   "contact is found later than in 10 ms.",
            .unit = "Hz",
            .range = between(0, 500),
            .live = kLive},
           e.observer_hz);
  o.number({.key = "hysteresis",
            .doc = "A contact ends this part below the torque at which it began.",
            .range = between(0, 0.99),
            .live = kLive},
           e.hysteresis);
  o.number({.key = "release_s",
            .doc = "And after as long below it.",
            .unit = "s",
            .range = between(0, 60),
            .live = kLive},
           e.release_s);
}

void describe_vibration(OptionVisitor& o, VibrationEntry& e) {
  o.number({.key = "lowest_hz",
            .doc = "A slower swing is not a limit cycle.",
            .unit = "Hz",
            .range = between(0.5, 1000),
            .live = kLive},
           e.lowest_hz);
  o.number({.key = "highest_hz",
            .doc = "Nor is a faster one.",
            .unit = "Hz",
            .range = between(1, 2000),
            .live = kLive},
           e.highest_hz);
  o.integer({.key = "half_cycles",
             .doc = "As many half-waves in a row that the drive feeds are a limit cycle.",
             .range = between(4, 1000),
             .live = kLive},
            e.half_cycles);
  o.number({.key = "lowest_authority",
            .doc = "A limit cycle halves damping, stiffness and friction compensation down to "
                   "this; if it goes on, the arm is stopped.",
            .range = between(0.01, 1.0),
            .live = kLive},
           e.lowest_authority);
}

void describe_joint_watch(OptionVisitor& o, JointEntry& e) {
  o.number({.key = "contact_torque",
            .doc = "An external torque of this size is a contact, found within 10 ms. Choose more "
                   "than twice what `geodesic status` shows as external in free motion.",
            .unit = "N·m or N",
            .range = kPositive,
            .default_text = "a third of torque_limit",
            .live = kLive},
           e.contact_torque);
  o.number({.key = "static_torque_tolerance",
            .doc = "While the start ramps, measured and modelled torque may differ by this, and a "
                   "spring holds the pose with no more than this beyond what the pose needs.",
            .unit = "N·m or N",
            .range = kPositive,
            .default_text = "not checked",
            .live = kLive},
           e.static_torque_tolerance);
  o.number({.key = "vibration_velocity",
            .doc = "A velocity that swings by this to either side may be a limit cycle.",
            .unit = "rad/s or m/s",
            .range = kPositive,
            .default_text = "a two-hundredth of the drive's velocity range",
            .live = kLive},
           e.vibration_velocity);
}

void watch_defaults(const JointEntry& entry, control::JointTuning& tuning) {
  tuning.contact_torque =
      entry.contact_torque.given ? entry.contact_torque.value : tuning.torque_limit / 3.0;
  if (entry.static_torque_tolerance.given) {
    tuning.static_torque_tolerance = entry.static_torque_tolerance.value;
  }
  if (entry.vibration_velocity.given) {
    tuning.vibration_velocity = entry.vibration_velocity.value;
  } else if (entry.drive.velocity_range_rad_s.given) {
    tuning.vibration_velocity = 0.005 * entry.drive.velocity_range_rad_s.value * entry.ratio.value;
  }
}

void fill_watch(const RobotFile& file, control::ControllerOptions& controller) {
  controller.safety.contact = control::ContactReaction::kReport;
  if (file.contact.reaction.value == "damp") {
    controller.safety.contact = control::ContactReaction::kDamp;
  } else if (file.contact.reaction.value == "stop") {
    controller.safety.contact = control::ContactReaction::kStop;
  }
  controller.contact.measured_torque = file.contact.torque.value == "measured";
  controller.contact.observer_hz = file.contact.observer_hz.value;
  controller.contact.hysteresis = file.contact.hysteresis.value;
  controller.contact.release_s = file.contact.release_s.value;
  controller.vibration.lowest_hz = file.vibration.lowest_hz.value;
  controller.vibration.highest_hz = file.vibration.highest_hz.value;
  controller.vibration.half_cycles = static_cast<int>(file.vibration.half_cycles.value);
  controller.vibration.lowest_authority = file.vibration.lowest_authority.value;
}

}  // namespace geodesic::config
