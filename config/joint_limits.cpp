// Limits and gains of one joint: defaults from the URDF and the drive, nothing outside what the
// drive can count or make.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "config/checks.hpp"
#include "config/watch_options.hpp"

namespace geodesic::config {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kSlack = 1.0 + 1e-9;  // a limit that equals the range but for rounding is inside

class JointLimits {
 public:
  JointLimits(const JointEntry& entry, const control::JointDescription* joint, Findings& findings)
      : entry_(entry),
        joint_(joint),
        findings_(findings),
        prismatic_(joint != nullptr && joint->kind == control::JointKind::kPrismatic) {}

  void position(control::JointTuning& tuning) {
    // What the drive can count, at the joint.
    const Given<double>& range = entry_.drive.position_range_rad;
    const double reach = range.given ? entry_.ratio.value * range.value : kInfinity;
    const double least = entry_.offset.value - reach;
    const double most = entry_.offset.value + reach;
    const double urdf_lower = joint_ != nullptr ? joint_->lower : -kInfinity;
    const double urdf_upper = joint_ != nullptr ? joint_->upper : kInfinity;
    // A continuous joint has no limit but the drive's counting.
    tuning.position_lower = std::isfinite(urdf_lower) ? urdf_lower : least;
    tuning.position_upper = std::isfinite(urdf_upper) ? urdf_upper : most;
    if (entry_.position_lower.given) tuning.position_lower = entry_.position_lower.value;
    if (entry_.position_upper.given) tuning.position_upper = entry_.position_upper.value;
    one_position("position_lower", entry_.position_lower, tuning.position_lower, least, most);
    one_position("position_upper", entry_.position_upper, tuning.position_upper, least, most);
    const double travel = tuning.position_upper - tuning.position_lower;
    if (!(travel > 0.0)) {
      const Given<double>& upper = entry_.position_upper;
      findings_.error(upper.given ? upper.place : where(entry_.position_lower),
                      fmt::format("{}position_lower {} is not below position_upper {}", name(),
                                  tuning.position_lower, tuning.position_upper));
      return;
    }
    tuning.soft_margin = entry_.soft_margin.value;
    if (!entry_.soft_margin.given) {
      tuning.soft_margin = std::min(tuning.soft_margin, 0.1 * travel);
    } else if (2.0 * tuning.soft_margin >= travel) {
      findings_.error(entry_.soft_margin.place,
                      fmt::format("{}soft_margin {} on both sides leaves nothing of a travel of {} "
                                  "{}; expected less than half of it",
                                  name(), tuning.soft_margin, travel, prismatic_ ? "m" : "rad"));
    }
  }

  double velocity() {
    const Given<double>& range = entry_.drive.velocity_range_rad_s;
    const double most = range.given ? range.value * entry_.ratio.value : kInfinity;
    return one_magnitude(
        "velocity_limit", entry_.velocity_limit, joint_ != nullptr ? joint_->velocity : 0.0, most,
        fmt::format("velocity_range_rad_s {} * ratio {}", range.value, entry_.ratio.value),
        prismatic_ ? "m/s" : "rad/s");
  }

  double torque() {
    const Given<double>& range = entry_.drive.torque_range_nm;
    const double most = range.given ? range.value / entry_.ratio.value : kInfinity;
    return one_magnitude(
        "torque_limit", entry_.torque_limit, joint_ != nullptr ? joint_->effort : 0.0, most,
        fmt::format("torque_range_nm {} / ratio {}", range.value, entry_.ratio.value),
        prismatic_ ? "N" : "N·m");
  }

 private:
  std::string name() const { return fmt::format("joint {}: ", quote(entry_.name.value)); }

  const Place& where(const Given<double>& value) const {
    return value.given ? value.place : entry_.place;
  }

  void one_position(const char* what, const Given<double>& given, double value, double least,
                    double most) {
    const char* unit = prismatic_ ? "m" : "rad";
    const double slack = 1e-9 * (1.0 + std::abs(value));
    if (value < least - slack || value > most + slack) {
      findings_.error(
          where(given),
          fmt::format("{}{} {} {} is outside what the drive can count, {:.6g} to {:.6g} "
                      "{} (offset {} -+ ratio {} * position_range_rad {})",
                      name(), what, value, unit, least, most, unit, entry_.offset.value,
                      entry_.ratio.value, entry_.drive.position_range_rad.value));
    } else if (given.given && joint_ != nullptr &&
               (value < joint_->lower - slack || value > joint_->upper + slack)) {
      findings_.warning(given.place,
                        fmt::format("{}{} {} {} is outside the URDF's limits, {} to {}", name(),
                                    what, value, unit, joint_->lower, joint_->upper));
    }
  }

  double one_magnitude(const char* what, const Given<double>& given, double from_urdf, double most,
                       const std::string& arithmetic, const char* unit) {
    const bool stated = from_urdf > 0.0;  // 0 in a URDF: not stated, the lint has said so
    if (!given.given) return std::min(stated ? from_urdf : kInfinity, most);
    if (given.value > most * kSlack) {
      findings_.error(given.place,
                      fmt::format("{}{} {} {} is more than the drive's {:.6g} {} ({})", name(),
                                  what, given.value, unit, most, unit, arithmetic));
    } else if (stated && given.value > from_urdf * kSlack) {
      findings_.warning(given.place, fmt::format("{}{} {} {} is more than the URDF's {} {}", name(),
                                                 what, given.value, unit, from_urdf, unit));
    }
    return given.value;
  }

  const JointEntry& entry_;
  const control::JointDescription* joint_;
  Findings& findings_;
  bool prismatic_;
};

}  // namespace

control::JointTuning check_limits(const JointEntry& entry, const control::JointDescription* joint,
                                  std::int64_t period_ns, Findings& findings) {
  control::JointTuning tuning;
  tuning.name = entry.name.value;
  tuning.damping = entry.damping.value;
  tuning.hold_stiffness = entry.hold_stiffness.value;
  tuning.hold_damping = entry.hold_damping.value;
  tuning.stop_damping = entry.stop_damping.value;
  tuning.drive_damping = entry.drive_damping.value;
  tuning.rotor_inertia = entry.rotor_inertia.value;
  tuning.coulomb_friction = entry.coulomb_friction.value;
  tuning.viscous_friction = entry.viscous_friction.value;
  tuning.friction_velocity = entry.friction_velocity.value;
  tuning.wall_stiffness = entry.wall_stiffness.value;
  tuning.wall_damping = entry.wall_damping.value;
  tuning.temperature_warn_c = entry.temperature_warn_c.value;
  tuning.temperature_limit_c = entry.temperature_limit_c.value;
  if (entry.torque_rate_limit.given) tuning.torque_rate_limit = entry.torque_rate_limit.value;

  if (entry.direction.value == 0) {
    findings.error(entry.direction.place, "direction: found 0, expected 1 or -1");
  }
  if (tuning.temperature_warn_c > tuning.temperature_limit_c) {
    const Given<double>& warn = entry.temperature_warn_c;
    findings.error(
        warn.given ? warn.place : entry.temperature_limit_c.place,
        fmt::format("joint {}: temperature_warn_c {} is above temperature_limit_c {}",
                    quote(tuning.name), tuning.temperature_warn_c, tuning.temperature_limit_c));
  }
  const double period_ms = static_cast<double>(period_ns) * 1e-6;
  if (const Given<double>& watchdog = entry.drive.watchdog_ms; watchdog.value < 3.0 * period_ms) {
    findings.error(
        watchdog.given ? watchdog.place : entry.drive.place,
        fmt::format("joint {}: watchdog_ms {} is shorter than three periods, 3 * {:.4g} ms "
                    "= {:.4g} ms: one late frame would stop the drive",
                    quote(tuning.name), watchdog.value, period_ms, 3.0 * period_ms));
  }
  JointLimits limits(entry, joint, findings);
  limits.position(tuning);
  tuning.velocity_limit = limits.velocity();
  tuning.torque_limit = limits.torque();
  watch_defaults(entry, tuning);
  return tuning;
}

}  // namespace geodesic::config
