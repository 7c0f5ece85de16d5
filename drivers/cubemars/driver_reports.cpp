// The half of a CubeMars driver that listens: what a report means, and what it gives away though
// the drive does not tell (other ranges, torque that does not follow). See driver.hpp.
#include <cmath>

#include "drivers/cubemars/driver.hpp"

namespace geodesic::drivers::cubemars {

using control::DriveCondition;

bool Driver::claims(const Frame& frame) const noexcept {
  return frame.extended || (frame.length >= reply::kShort && frame.data[0] == options_.id);
}

bool Driver::receive(const ReceivedFrame& received) noexcept {
  const Frame& frame = received.frame;
  if (frame.error || frame.remote || frame.fd) {
    return false;
  }
  if (frame.extended) {
    if (take_other_servo_frame(frame)) {
      update_condition();
      return false;
    }
    const auto status = decode_status(frame);
    if (!facts_.servo || !status || frame.id != servo_id(Function::kStatus, options_.id)) {
      return false;
    }
    return take({.position_rad = status->position_deg * facts_.radians_per_degree,
                 .velocity_rad_s = status->speed_erpm * facts_.rad_s_per_erpm,
                 .torque_nm = status->current_a * facts_.torque_per_ampere_nm,
                 .temperature_c = status->temperature_c,
                 .error = status->error},
                received.stamp_ns);
  }
  const auto reply = decode_reply(frame, ranges_);
  if (facts_.servo || !reply || frame.id != options_.reply_id || reply->motor != options_.id) {
    return false;
  }
  const double celsius = reply->temperature_raw
                             ? *reply->temperature_raw + facts_.temperature_offset_c
                             : state_.temperature_c;
  return take({.position_rad = reply->position_rad,
               .velocity_rad_s = reply->velocity_rad_s,
               .torque_nm = reply->torque_nm,
               .temperature_c = celsius,
               .error = reply->error},
              received.stamp_ns);
}

bool Driver::take_other_servo_frame(const Frame& frame) noexcept {
  if (!facts_.servo) {
    if (phase_ != Phase::kRefused && (frame.id == servo_id(Function::kStatus, options_.id) ||
                                      frame.id == servo_id(Function::kServoMode, options_.id))) {
      refuse({"mode of the drive (0: MIT, 1: servo)", 1.0, 0.0,
              "set MIT mode with the vendor's tool, or mode = \"servo\" in the robot file"});
    }
    return true;
  }
  if (frame.id == servo_id(Function::kStartUp, options_.id) ||
      frame.id == servo_id(Function::kServoMode, options_.id)) {
    if (following()) {
      fall_out({"announcements of having been switched on", 1.0, 0.0,
                "check the drive's supply: it was off while in operation"});
    } else if (phase_ == Phase::kIdle) {
      begin_start_up();
    }
    return true;
  }
  return false;
}

bool Driver::take(const Report& report, std::int64_t stamp_ns) noexcept {
  if (stamp_ns - last_heard_ns_ > kForgetNs) {
    counting_ = false;
    velocity_check_.restart();
  }
  last_heard_ns_ = stamp_ns;
  error_ = report.error;
  advance(report.error, stamp_ns);
  const bool meaningful = phase_ != Phase::kStartUp && phase_ != Phase::kRefused;
  if (meaningful) {
    look_at_position(report.position_rad);
    look_at_velocity(report, stamp_ns);
    look_at_torque(report.torque_nm, stamp_ns);
    state_.position_rad = report.position_rad;
    state_.velocity_rad_s = report.velocity_rad_s;
    state_.torque_nm = report.torque_nm;
    state_.temperature_c = report.temperature_c;
    state_.stamp_ns = stamp_ns;
  }
  update_condition();
  return meaningful;
}

void Driver::advance(std::uint8_t error, std::int64_t stamp_ns) noexcept {
  switch (phase_) {
    case Phase::kStartUp:
      start_up_.receive(error, stamp_ns);
      if (start_up_.done()) {
        phase_ = Phase::kIdle;
        releases_ = 0;
      }
      break;
    case Phase::kEnabling:
    case Phase::kEnabled:
      if (error != 0) {
        fall_out({"error code of the drive", static_cast<double>(error), 0.0,
                  "remove its cause, then power-cycle the drive: it has no command that clears"});
      } else if (phase_ == Phase::kEnabling &&
                 ++enabled_replies_ >= (facts_.servo ? 1 : kEnabledReplies)) {
        phase_ = Phase::kEnabled;
      }
      break;
    case Phase::kDisabling:
      if (disable_sent_) {
        phase_ = Phase::kIdle;
      }
      break;
    case Phase::kIdle:
    case Phase::kOut:
    case Phase::kRefused:
      break;
  }
}

void Driver::look_at_position(double position_rad) noexcept {
  const bool jumped =
      counting_ && std::abs(position_rad - reported_rad_) > ranges_.position_rad && !facts_.servo;
  const bool at_edge = !facts_.servo && std::abs(position_rad) >= ranges_.position_rad;
  counting_ = true;
  reported_rad_ = position_rad;
  if (following() && (jumped || at_edge)) {
    fall_out({"position of the drive [rad]: what it can report ends there", position_rad, 0.0,
              "set the drive's zero to the middle of the joint's travel (geodesic zero)"});
  }
}

void Driver::look_at_velocity(const Report& report, std::int64_t stamp_ns) noexcept {
  const bool slow =
      !following() || std::abs(report.velocity_rad_s) < 0.2 * options_.velocity_range_rad_s;
  if (velocity_check_.take(report.position_rad, report.velocity_rad_s, stamp_ns, slow)) {
    refuse({"reported velocity over the change of reported position", velocity_check_.ratio(), 1.0,
            facts_.servo ? "correct gear_ratio, pole_pairs or position_of in the robot file"
                         : "correct the drive's velocity or position range in the robot file: they "
                           "differ by model and firmware"});
  }
}

void Driver::look_at_torque(double reported_nm, std::int64_t stamp_ns) noexcept {
  const bool follows = std::abs(asked_nm_) < kAskedShare * ranges_.torque_nm ||
                       std::abs(reported_nm) >= kFollowedShare * std::abs(asked_nm_);
  if (phase_ != Phase::kEnabled || follows) {
    followed_ns_ = stamp_ns;
  } else if (stamp_ns - followed_ns_ > kFollowNs) {
    fall_out(
        {"torque that the drive reports [N·m]", reported_nm, asked_nm_,
         "it does not follow: somebody else disabled it, or it was off, or it is at its limit"});
  }
}

void Driver::update_condition() noexcept {
  state_.error = start_up_.heard() ? error_ : std::uint8_t{0};
  if (phase_ == Phase::kRefused) {
    state_.condition = DriveCondition::kRefused;
  } else if (!start_up_.heard()) {
    state_.condition = DriveCondition::kUnknown;
  } else if (phase_ == Phase::kStartUp) {
    state_.condition =
        start_up_.held_by_error() ? DriveCondition::kError : DriveCondition::kConfiguring;
  } else if (error_ != 0) {
    state_.condition = DriveCondition::kError;
  } else if (phase_ == Phase::kEnabled || phase_ == Phase::kDisabling) {
    state_.condition = DriveCondition::kEnabled;
  } else {
    state_.condition = DriveCondition::kDisabled;
  }
}

}  // namespace geodesic::drivers::cubemars
