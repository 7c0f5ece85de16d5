// The half of a MyActuator driver that listens: what a reply means, and which is none though it
// looks like one. See driver.hpp.
#include <algorithm>
#include <cmath>

#include "drivers/myactuator/driver.hpp"

namespace geodesic::drivers::myactuator {

using control::DriveCondition;

namespace {

constexpr DriveComplaint kExpired{
    "commands that the drive sent back unexecuted, or its notice of lost communication (0xF1)", 1.0,
    0.0, "the drive's watchdog ended its torque: check the cable, or lengthen watchdog_ms"};

}  // namespace

bool Driver::receive(const ReceivedFrame& received) noexcept {
  const Frame& frame = received.frame;
  const bool motion_reply = facts_.motion && frame.id == kMotionReplyId + options_.id;
  if (frame.error || frame.remote || frame.fd || frame.extended || frame.length != kLength ||
      (frame.id != kReplyId + options_.id && !motion_reply)) {
    return false;
  }
  if (received.stamp_ns - last_heard_ns_ > kForgetNs) {
    velocity_check_.restart();
  }
  last_heard_ns_ = received.stamp_ns;
  bool reported = false;
  if (phase_ == Phase::kStartUp) {
    start_up_.receive(frame);
    errors_ = start_up_.errors();
    if (start_up_.done()) {
      phase_ = Phase::kIdle;
      next_status_ns_ = received.stamp_ns + own_share_of(kStatusIntervalNs);
    } else if (start_up_.refused()) {
      phase_ = Phase::kRefused;
      shutdowns_ = kShutdowns;
    }
  } else {
    reported =
        motion_reply ? take_motion_reply(frame, received.stamp_ns) : take(frame, received.stamp_ns);
  }
  update_condition();
  return reported;
}

bool Driver::take(const Frame& frame, std::int64_t stamp_ns) noexcept {
  switch (static_cast<Command>(frame.data[0])) {
    case Command::kWatchdogExpired:
      if (following()) {
        fall_out(kExpired);
      }
      return false;
    case Command::kStatus1:
      take_status(frame);
      return false;
    case Command::kTorque:
    case Command::kStatus2:
      take_loop_reply(frame);
      return false;
    case Command::kAngle:
      return take_angle(frame, stamp_ns);
    case Command::kShutdown:
      shutdowns_ -= shutdowns_ > 0 ? 1 : 0;
      if (phase_ == Phase::kDisabling && disable_sent_ && shutdowns_ == 0) {
        phase_ = Phase::kIdle;
      }
      return false;
    default:
      return false;
  }
}

void Driver::take_status(const Frame& frame) noexcept {
  const auto status = decode_status1(frame);
  if (!status || is_bare(frame)) {
    if (following()) {
      fall_out(kExpired);  // no drive runs at 0 V: our request, sent back
    }
    return;
  }
  errors_ = status->errors;
  status_heard_ = true;
  brake_released_ = status->brake_released;
  state_.temperature_c = std::max(status->motor_c, status->mosfet_c);
  if (following() && errors_ != 0) {
    fall_out({"error bits of the drive (status 1, 0x9A)", static_cast<double>(errors_), 0.0,
              "remove the cause; then power-cycle the drive, or let clear_errors reset it"});
  } else if (phase_ == Phase::kEnabled && facts_.brake && !brake_released_) {
    fall_out({"brake of the drive (0x9A; 1: released)", 0.0, 1.0,
              "it locked by itself: check its supply, then its errors"});
  }
  become_enabled();
}

void Driver::take_loop_reply(const Frame& frame) noexcept {
  const auto reply = decode_loop_reply(frame);
  const bool torque = frame.data[0] == static_cast<std::uint8_t>(Command::kTorque);
  const bool bare = is_bare(frame);
  if (torque && !bare && frame.data == last_torque_.data && last_torque_.length == kLength) {
    if (following()) {
      fall_out(kExpired);
    }
    return;
  }
  // Everything 0 can be a drive at 0 °C, but not the first time.
  const bool believed = !bare || bare_reply_;
  bare_reply_ = bare;
  if (!reply || !believed) {
    return;
  }
  state_.velocity_rad_s = reply->speed_deg_s * kDegree;
  state_.torque_nm = reply->current_a * facts_.torque_per_ampere_nm;
  state_.temperature_c = reply->temperature_c;
  if (torque) {
    look_at_torque();
  }
  if (torque && phase_ == Phase::kEnabling) {
    torque_answered_ = true;
    become_enabled();
  }
}

bool Driver::take_angle(const Frame& frame, std::int64_t stamp_ns) noexcept {
  const auto angle = decode_angle(frame);
  const bool bare = is_bare(frame);
  const bool believed = !bare || bare_angle_ || std::abs(state_.position_rad) < kNearZeroRad;
  bare_angle_ = bare;
  if (!angle || !believed || phase_ == Phase::kRefused) {
    return false;
  }
  state_.position_rad = *angle * kDegree;
  state_.stamp_ns = stamp_ns;
  return true;
}

bool Driver::take_motion_reply(const Frame& frame, std::int64_t stamp_ns) noexcept {
  if (following() && frame.data == last_torque_.data) {
    fall_out(kExpired);
    return false;
  }
  const auto reply = decode_motion_reply(frame, ranges_);
  if (!reply || reply->motor != options_.id || phase_ == Phase::kRefused) {
    return false;
  }
  state_.position_rad = reply->position_rad;
  state_.velocity_rad_s = reply->velocity_rad_s;
  state_.torque_nm = reply->torque_nm;
  state_.stamp_ns = stamp_ns;
  look_at_torque();
  const bool slow = std::abs(reply->velocity_rad_s) < 0.2 * ranges_.velocity_rad_s;
  if (std::abs(reply->position_rad) >= ranges_.position_rad && following()) {
    fall_out({"position of the drive [rad]: what motion mode can report ends there",
              reply->position_rad, 0.0,
              "set the drive's zero to the middle of the joint's travel (geodesic zero)"});
  } else if (velocity_check_.take(reply->position_rad, reply->velocity_rad_s, stamp_ns, slow)) {
    fall_out({"reported velocity over the change of reported position", velocity_check_.ratio(),
              1.0, "correct velocity_range_rad_s in the robot file: it differs by model"});
    phase_ = Phase::kRefused;
  } else if (phase_ == Phase::kEnabling) {
    torque_answered_ = true;
    become_enabled();
  }
  return true;
}

void Driver::look_at_torque() noexcept {
  if (phase_ == Phase::kEnabled && std::abs(asked_nm_) > kAskedShare * options_.torque_range_nm &&
      std::abs(state_.torque_nm) < 0.5 * std::abs(asked_nm_)) {
    next_status_ns_ = last_status_ns_ + kSoonestNs;  // it may be in error: ask in the next cycle
  }
}

void Driver::become_enabled() noexcept {
  if (phase_ == Phase::kEnabling && torque_answered_ && status_heard_ &&
      (brake_released_ || !facts_.brake)) {
    phase_ = Phase::kEnabled;
  }
}

void Driver::update_condition() noexcept {
  state_.error = error_code(errors_);
  if (phase_ == Phase::kRefused) {
    state_.condition = DriveCondition::kRefused;
  } else if (phase_ == Phase::kStartUp && !start_up_.heard()) {
    state_.condition = DriveCondition::kUnknown;
  } else if (phase_ == Phase::kStartUp) {
    state_.condition =
        start_up_.held_by_error() ? DriveCondition::kError : DriveCondition::kConfiguring;
  } else if (errors_ != 0) {
    state_.condition = DriveCondition::kError;
  } else if (phase_ == Phase::kEnabled || phase_ == Phase::kDisabling) {
    state_.condition = DriveCondition::kEnabled;
  } else {
    state_.condition = DriveCondition::kDisabled;
  }
}

}  // namespace geodesic::drivers::myactuator
