// Names of the laws, and the ranges that the controller's options must keep. Not what a drive or a
// URDF allows: that is compared in config/.
#include "control/options.hpp"

#include <charconv>
#include <cmath>

#include "control/arms.hpp"

namespace geodesic::control {
namespace {

constexpr std::array<const char*, 4> kLawNames{"float", "hold", "damp", "zero"};

std::string number(double value) {
  std::array<char, 32> text{};
  const std::to_chars_result end = std::to_chars(text.begin(), text.end(), value);
  return {text.data(), end.ptr};
}

/// Collects complaints about one thing: a joint, or the controller itself.
class Ranges {
 public:
  Ranges(std::string of, std::vector<std::string>& complaints)
      : of_(std::move(of)), complaints_(complaints) {}

  void at_least_zero(const char* option, double value) {
    demand(std::isfinite(value) && value >= 0.0, option, value, "a finite number, 0 or more");
  }
  void above_zero(const char* option, double value) {
    demand(std::isfinite(value) && value > 0.0, option, value, "a finite number above 0");
  }
  void limit(const char* option, double value) {
    demand(value > 0.0, option, value, "a number above 0 (infinite: no limit)");
  }
  void at_most_a_minute(const char* option, double value) {
    demand(value >= 0.0 && value <= 60.0, option, value, "0 to 60 s");
  }
  void timeout(const char* option, double value) {
    demand(value > 0.0 && value <= 600.0, option, value, "above 0 s and up to 600 s");
  }
  void cycles(const char* option, int value) {
    demand(value >= 1 && value <= 10000, option, value, "1 to 10000 cycles");
  }
  void demand(bool holds, const char* option, double value, const char* expected) {
    if (!holds) {
      complain(std::string(option) + " is " + number(value) + ", expected " + expected);
    }
  }
  void complain(const std::string& text) { complaints_.push_back(of_ + ": " + text); }

 private:
  std::string of_;
  std::vector<std::string>& complaints_;
};

void check_joint(const JointTuning& joint, Ranges ranges) {
  ranges.at_least_zero("damping", joint.damping);
  ranges.at_least_zero("hold_stiffness", joint.hold_stiffness);
  ranges.at_least_zero("hold_damping", joint.hold_damping);
  ranges.at_least_zero("stop_damping", joint.stop_damping);
  ranges.at_least_zero("drive_damping", joint.drive_damping);
  ranges.at_least_zero("rotor_inertia", joint.rotor_inertia);
  ranges.at_least_zero("coulomb_friction", joint.coulomb_friction);
  ranges.at_least_zero("viscous_friction", joint.viscous_friction);
  ranges.above_zero("friction_velocity", joint.friction_velocity);
  ranges.at_least_zero("position_tolerance", joint.position_tolerance);
  ranges.at_least_zero("soft_margin", joint.soft_margin);
  ranges.at_least_zero("wall_stiffness", joint.wall_stiffness);
  ranges.at_least_zero("wall_damping", joint.wall_damping);
  ranges.limit("velocity_limit", joint.velocity_limit);
  ranges.limit("torque_limit", joint.torque_limit);
  ranges.limit("torque_rate_limit", joint.torque_rate_limit);
  ranges.limit("contact_torque", joint.contact_torque);
  ranges.limit("static_torque_tolerance", joint.static_torque_tolerance);
  ranges.limit("vibration_velocity", joint.vibration_velocity);
  if (!(joint.position_lower < joint.position_upper)) {
    ranges.complain("position_lower is " + number(joint.position_lower) +
                    ", expected less than position_upper, which is " +
                    number(joint.position_upper));
  }
  if (!(joint.temperature_warn_c <= joint.temperature_limit_c)) {
    ranges.complain("temperature_warn_c is " + number(joint.temperature_warn_c) +
                    ", expected no more than temperature_limit_c, which is " +
                    number(joint.temperature_limit_c));
  }
}

void check_safety(const SafetyOptions& safety, Ranges ranges) {
  ranges.cycles("carry_on_cycles", safety.carry_on_cycles);
  ranges.cycles("damp_cycles", safety.damp_cycles);
  ranges.cycles("silent_cycles", safety.silent_cycles);
  ranges.demand(safety.carry_on_cycles < safety.damp_cycles, "damp_cycles", safety.damp_cycles,
                "more than carry_on_cycles: a joint is predicted first, then damped");
  ranges.demand(safety.damp_cycles <= safety.silent_cycles || safety.silent_cycles < 1,
                "silent_cycles", safety.silent_cycles,
                "damp_cycles or more: a joint is damped first, then stopped");
  ranges.cycles("overrun_cycles", safety.overrun_cycles);
  ranges.at_most_a_minute("start_ramp_s", safety.start_ramp_s);
  ranges.at_most_a_minute("stop_rest_s", safety.stop_rest_s);
  ranges.at_most_a_minute("stop_timeout_s", safety.stop_timeout_s);
  ranges.at_most_a_minute("lower_s", safety.lower_s);
  ranges.at_most_a_minute("settle_timeout_s", safety.settle_timeout_s);
  ranges.timeout("connect_timeout_s", safety.connect_timeout_s);
  ranges.timeout("enable_timeout_s", safety.enable_timeout_s);
  ranges.above_zero("stop_rest_velocity", safety.stop_rest_velocity);
  ranges.above_zero("start_velocity", safety.start_velocity);
  ranges.above_zero("encoder_jump", safety.encoder_jump);
  ranges.above_zero("encoder_stuck", safety.encoder_stuck);
}

void check_watch(const ContactOptions& contact, const VibrationOptions& vibration, Ranges ranges) {
  ranges.at_least_zero("observer_hz", contact.observer_hz);
  ranges.demand(contact.hysteresis >= 0.0 && contact.hysteresis < 1.0, "hysteresis",
                contact.hysteresis, "0 or more and below 1");
  ranges.at_most_a_minute("release_s", contact.release_s);
  ranges.above_zero("lowest_hz", vibration.lowest_hz);
  ranges.demand(vibration.highest_hz > vibration.lowest_hz, "highest_hz", vibration.highest_hz,
                "a number above lowest_hz");
  ranges.cycles("half_cycles", vibration.half_cycles);
  ranges.demand(vibration.lowest_authority > 0.0 && vibration.lowest_authority <= 1.0,
                "lowest_authority", vibration.lowest_authority, "above 0 and up to 1");
}

}  // namespace

const char* to_string(LawKind law) noexcept {
  const auto index = static_cast<std::size_t>(law);
  return index < kLawNames.size() ? kLawNames[index] : "?";
}

std::optional<LawKind> law_from_string(std::string_view name) noexcept {
  for (std::size_t i = 0; i < kLawNames.size(); ++i) {
    if (name == kLawNames[i]) {
      return static_cast<LawKind>(i);
    }
  }
  return std::nullopt;
}

std::vector<std::string> check(const ControllerOptions& options) {
  std::vector<std::string> complaints;
  Ranges ranges("controller", complaints);
  if (static_cast<std::size_t>(options.law) >= kLawNames.size()) {
    ranges.complain("law is none of float, hold, damp, zero");
  }
  if (options.law == LawKind::kZero && !options.allow_zero_law) {
    ranges.complain(
        "law is zero, which lets the arm fall; it is for simulation: set allow_zero_law");
  }
  ranges.at_least_zero("velocity_filter_hz", options.velocity_filter_hz);
  ranges.demand(options.coriolis >= 0.0 && options.coriolis <= 1.0, "coriolis", options.coriolis,
                "0 to 1");
  ranges.timeout("retune_s", options.retune_s);
  if (options.joints.empty() || options.joints.size() > kMaxJoints) {
    ranges.complain("there are " + std::to_string(options.joints.size()) +
                    " joints, expected 1 to " + std::to_string(kMaxJoints));
  }
  for (const JointTuning& joint : options.joints) {
    check_joint(joint, Ranges("joint '" + joint.name + "'", complaints));
  }
  check_safety(options.safety, Ranges("safety", complaints));
  for (const std::string& complaint : check_arms(options)) {
    ranges.complain(complaint);
  }
  check_watch(options.contact, options.vibration, Ranges("watch", complaints));
  return complaints;
}

}  // namespace geodesic::control
