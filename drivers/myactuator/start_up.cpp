// The start-up dialogue of a MyActuator drive, step by step; see start_up.hpp. Sources: README.md.
#include "drivers/myactuator/start_up.hpp"

#include <cmath>

namespace geodesic::drivers::myactuator {

namespace {

constexpr const char* kNoAnswer =
    "the drive reports its status but does not answer this: update it";

const char* const kUnanswered[] = {
    "status 1 (0x9A)",     "reset (0x76)",         "shut down (0x80)",
    "version date (0xB2)", "watchdog time (0xB3)", "angle (0x92)",
    "motion mode (0x400)", "shut down (0x80)",     "status 1 (0x9A)"};

}  // namespace

StartUp::StartUp(const DriveOptions& options)
    : options_(options), facts_(options), ranges_(ranges_of(options)) {}

void StartUp::restart() noexcept {
  enter(Step::kStatus);
  heard_ = false;
  held_by_error_ = false;
  clears_ = 0;
  next_ns_ = 0;
  errors_ = 0;
  firmware_ = 0;
  complaint_ = {};
}

void StartUp::enter(Step step) noexcept {
  step_ = step;
  awaiting_ = false;
  bare_angle_ = false;
  tries_ = 0;
}

void StartUp::refuse(const DriveComplaint& complaint) noexcept {
  complaint_ = complaint;
  enter(Step::kRefused);
}

Frame StartUp::request() const noexcept {
  switch (step_) {
    case Step::kReset:
      return encode_request(options_.id, Command::kReset);
    case Step::kShutdown:
    case Step::kShutdownAgain:
      return encode_request(options_.id, Command::kShutdown);
    case Step::kVersion:
      return encode_request(options_.id, Command::kVersion);
    case Step::kWatchdog:
      return encode_value(options_.id, Command::kWatchdog, facts_.watchdog_ms);
    case Step::kAngle:
      return encode_request(options_.id, Command::kAngle);
    case Step::kMotion:
      return encode_motion(options_.id, {}, ranges_)
          .value_or(encode_request(options_.id, Command::kShutdown));
    case Step::kStatus:
    case Step::kConfirm:
    case Step::kDone:
    case Step::kRefused:
      break;
  }
  return encode_request(options_.id, Command::kStatus1);
}

bool StartUp::transmit(std::int64_t now_ns, Frame& out) noexcept {
  if (done() || refused() || (awaiting_ && now_ns < next_ns_)) {
    return false;
  }
  if (step_ == Step::kReset && awaiting_) {
    enter(Step::kStatus);  // it has had its time
  }
  if (heard_ && step_ != Step::kStatus && ++tries_ > kMaxTries) {
    refuse({kUnanswered[static_cast<std::size_t>(step_)], std::nan(""), std::nan(""), kNoAnswer});
    return false;
  }
  out = request();
  awaiting_ = true;
  next_ns_ = now_ns + (step_ == Step::kReset ? kResetNs : kReplyTimeoutNs);
  return true;
}

bool StartUp::answers(const Frame& frame) const noexcept {
  if (done() || refused() || !awaiting_ || step_ == Step::kReset || frame.length != kLength) {
    return false;
  }
  if (step_ == Step::kMotion) {
    return frame.id == kMotionReplyId + options_.id && frame.data[0] == options_.id;
  }
  return frame.id == kReplyId + options_.id && frame.data[0] == request().data[0];
}

void StartUp::receive(const Frame& frame) noexcept {
  if (!answers(frame)) {
    return;
  }
  heard_ = true;
  awaiting_ = false;
  switch (step_) {
    case Step::kStatus:
    case Step::kConfirm:
      take_status(frame);
      break;
    case Step::kShutdown:
      enter(Step::kVersion);
      break;
    case Step::kVersion:
      take_version(frame);
      break;
    case Step::kWatchdog:
      if (decode_value(frame) != facts_.watchdog_ms) {
        refuse({"watchdog time (0xB3) [ms]", static_cast<double>(decode_value(frame)),
                static_cast<double>(facts_.watchdog_ms),
                "the drive does not take the watchdog time: check its firmware"});
      } else {
        enter(Step::kAngle);
      }
      break;
    case Step::kAngle:
      take_angle(frame);
      break;
    case Step::kMotion:
      take_motion(frame);
      break;
    case Step::kShutdownAgain:
      enter(Step::kConfirm);
      break;
    case Step::kReset:
    case Step::kDone:
    case Step::kRefused:
      break;
  }
}

void StartUp::take_status(const Frame& frame) noexcept {
  const auto status = decode_status1(frame);
  if (!status || is_bare(frame)) {
    return;  // sent back: ask again
  }
  errors_ = status->errors;
  held_by_error_ = errors_ != 0 && (!options_.clear_errors || clears_ >= kMaxClears);
  complaint_ = {};
  if (held_by_error_) {
    complaint_ = {"error bits of the drive (status 1, 0x9A)", static_cast<double>(errors_), 0.0,
                  "remove the cause; then power-cycle the drive, or let clear_errors reset it"};
    awaiting_ = true;  // ask again after the time-out
    step_ = Step::kStatus;
  } else if (errors_ != 0) {
    ++clears_;
    enter(Step::kReset);
  } else {
    enter(step_ == Step::kStatus ? Step::kShutdown : Step::kDone);
  }
}

void StartUp::take_version(const Frame& frame) noexcept {
  if (is_bare(frame)) {
    return;
  }
  firmware_ = decode_value(frame);
  if (firmware_ < facts_.oldest_firmware) {
    refuse({"version date (0xB2)", static_cast<double>(firmware_),
            static_cast<double>(facts_.oldest_firmware),
            "update the drive's firmware, or lower firmware_at_least in the robot file"});
    return;
  }
  enter(Step::kWatchdog);
}

void StartUp::take_angle(const Frame& frame) noexcept {
  const auto angle = decode_angle(frame);
  if (!angle) {
    return;
  }
  if (is_bare(frame) && !bare_angle_) {
    bare_angle_ = true;
    return;
  }
  angle_rad_ = *angle * kDegree;
  if (!facts_.motion) {
    enter(Step::kConfirm);
  } else if (std::abs(angle_rad_) >= ranges_.position_rad) {
    refuse({"angle (0x92) [rad]: motion mode can report no more than its range", angle_rad_,
            ranges_.position_rad,
            "set the drive's zero to the middle of the joint's travel (geodesic zero)"});
  } else {
    enter(Step::kMotion);
  }
}

void StartUp::take_motion(const Frame& frame) noexcept {
  const auto reply = decode_motion_reply(frame, ranges_);
  if (!reply) {
    return;
  }
  // Written so that a NaN is a mismatch.
  const double allowed = kToleranceRad + kToleranceS * std::abs(reply->velocity_rad_s);
  if (!(std::abs(reply->position_rad - angle_rad_) <= allowed)) {
    refuse({"position in motion mode, against the angle (0x92) [rad]", reply->position_rad,
            angle_rad_,
            "correct position_range_rad in the robot file: 12.5, or 12.566 since protocol V4.4"});
    return;
  }
  enter(Step::kShutdownAgain);
}

}  // namespace geodesic::drivers::myactuator
