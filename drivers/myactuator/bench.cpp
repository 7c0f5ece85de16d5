// MyActuator drives at the bench; see bench.hpp. Sources: README.md.
#include "drivers/myactuator/bench.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "drivers/myactuator/family.hpp"

namespace geodesic::drivers::myactuator {

std::optional<Frame> BusScanner::transmit(std::int64_t now_ns) {
  // Status twice: the first request after a silence may be sent back unexecuted.
  static constexpr std::array kAsked = {Command::kStatus1, Command::kStatus1, Command::kVersion,
                                        Command::kModel};
  if (over() || now_ns < next_ns_) {
    return std::nullopt;
  }
  next_ns_ = now_ns + kStepNs;
  if (searched_ < kLastMotor) {
    return encode_request(++searched_, Command::kStatus1);
  }
  while (motor_ <= kLastMotor && !heard_[motor_].answered) {
    ++motor_;
  }
  if (motor_ > kLastMotor) {
    over_ = true;
    return std::nullopt;
  }
  const Frame request = encode_request(motor_, kAsked[question_]);
  question_ = (question_ + 1) % kAsked.size();
  motor_ += question_ == 0 ? 1U : 0U;
  return request;
}

void BusScanner::receive(const ReceivedFrame& received) {
  const Frame& frame = received.frame;
  if (frame.error || frame.remote || frame.fd || frame.extended || frame.length != kLength ||
      frame.id <= kReplyId || frame.id > kReplyId + kLastMotor) {
    return;
  }
  Heard& heard = heard_[frame.id - kReplyId];
  switch (static_cast<Command>(frame.data[0])) {
    case Command::kStatus1:
      heard.answered = true;
      if (!is_bare(frame)) {
        heard.status = decode_status1(frame);
      }
      break;
    case Command::kVersion:
      heard.version = decode_value(frame);
      break;
    case Command::kModel:
      heard.model.clear();
      for (std::size_t i = 1; i < kLength; ++i) {
        const auto letter = static_cast<char>(frame.data[i]);
        if (letter > ' ' && letter <= '~') {
          heard.model.push_back(letter);
        }
      }
      break;
    default:
      break;
  }
}

std::vector<FoundDrive> BusScanner::found() const {
  std::vector<FoundDrive> all;
  for (std::uint32_t motor = 1; motor <= kLastMotor; ++motor) {
    const Heard& heard = heard_[motor];
    if (!heard.answered) {
      continue;
    }
    FoundDrive drive;
    drive.id = motor;
    drive.reply_id = kReplyId + motor;
    drive.model = heard.model;
    drive.firmware = heard.version == 0 ? "" : fmt::format("{}", heard.version);
    drive.options = {{"mode", "\"torque\""},
                     {"torque_constant_nm_a", "2.0"},
                     {"velocity_range_rad_s", "20.0"},
                     {"torque_range_nm", "10.0"}};
    drive.remarks.emplace_back(
        "it does not tell torque constant or limits: take them from the motor's data sheet");
    if (!heard.status) {
      drive.remarks.emplace_back("it sends status requests back without an answer");
    } else {
      if (heard.status->errors != 0) {
        drive.remarks.push_back(fmt::format("errors {:#06x}: {}", heard.status->errors,
                                            error_name(error_code(heard.status->errors))));
      }
      drive.remarks.push_back(fmt::format("supply {:.1f} V, brake {}", heard.status->voltage_v,
                                          heard.status->brake_released ? "released" : "locked"));
    }
    all.push_back(std::move(drive));
  }
  return all;
}

void ZeroSetter::end(bool done, std::string report) {
  step_ = Step::kOver;
  done_ = done;
  report_ = std::move(report);
}

std::optional<Frame> ZeroSetter::transmit(std::int64_t now_ns) {
  if (!begun_) {
    begun_ = true;
    since_ns_ = now_ns;
  }
  if (over() || now_ns < next_ns_) {
    return std::nullopt;
  }
  next_ns_ = now_ns + kStepNs;
  if (step_ == Step::kRestarting) {
    step_ = Step::kReadBack;
    since_ns_ = now_ns;
  }
  if (now_ns - since_ns_ > kPatienceNs) {
    end(false, answered_ ? "the drive does not answer after its restart: its zero is not known"
                         : "the drive does not answer: nothing was set");
    return std::nullopt;
  }
  if (step_ == Step::kReset) {
    step_ = Step::kRestarting;
    next_ns_ = now_ns + kRestartNs;
    return encode_request(options_.id, Command::kReset);
  }
  if (step_ == Step::kSet) {
    next_ns_ = now_ns + kRepeatNs;
    return encode_request(options_.id, Command::kZeroHere);
  }
  // Status first: the first request after a silence may come back unexecuted.
  static constexpr std::array kAsked = {Command::kStatus1, Command::kStatus2, Command::kAngle};
  return encode_request(options_.id, kAsked[turn_++ % kAsked.size()]);
}

void ZeroSetter::receive(const ReceivedFrame& received) {
  const Frame& frame = received.frame;
  if (over() || !begun_ || frame.error || frame.remote || frame.fd || frame.extended ||
      frame.length != kLength || frame.id != kReplyId + options_.id) {
    return;
  }
  switch (static_cast<Command>(frame.data[0])) {
    case Command::kStatus1:
      take_status(frame);
      break;
    case Command::kStatus2: {
      const auto reply = decode_loop_reply(frame);
      at_rest_ = reply && !is_bare(frame);
      const double torque_nm = reply ? reply->current_a * facts_.torque_per_ampere_nm : 0.0;
      if (step_ == Step::kWatch && reply && std::abs(reply->speed_deg_s) > 1.0) {
        end(false,
            fmt::format("the drive moves ({:.0f} deg/s): nothing was set", reply->speed_deg_s));
      } else if (step_ == Step::kWatch && std::abs(torque_nm) > 0.02 * options_.torque_range_nm) {
        end(false, fmt::format("the drive makes torque ({:.3g} N·m): nothing was set", torque_nm));
      }
      break;
    }
    case Command::kAngle:
      take_angle(frame, received.stamp_ns);
      break;
    case Command::kZeroHere:
      if (step_ == Step::kSet) {
        answered_ = true;
        step_ = Step::kReset;
      }
      break;
    default:
      break;
  }
}

void ZeroSetter::take_status(const Frame& frame) {
  const auto status = decode_status1(frame);
  if (!status || is_bare(frame) || step_ != Step::kWatch) {
    return;
  }
  sound_ = status->errors == 0;
  if (!sound_) {
    end(false, fmt::format("the drive reports errors {:#06x} ({}): nothing was set", status->errors,
                           error_name(error_code(status->errors))));
  }
}

void ZeroSetter::take_angle(const Frame& frame, std::int64_t stamp_ns) {
  const double angle_rad = decode_angle(frame).value_or(0.0) * kDegree;
  if (step_ == Step::kWatch && sound_ && at_rest_) {
    if (watched_ns_ == 0) {
      watched_ns_ = stamp_ns;
      before_rad_ = least_rad_ = most_rad_ = angle_rad;
    }
    least_rad_ = std::min(least_rad_, angle_rad);
    most_rad_ = std::max(most_rad_, angle_rad);
    since_ns_ = stamp_ns;
    if (most_rad_ - least_rad_ > kRestRad) {
      end(false, "the drive moves: nothing was set");
    } else if (stamp_ns - watched_ns_ >= kWatchNs) {
      step_ = Step::kSet;
    }
  } else if (step_ == Step::kReadBack) {
    after_rad_ = angle_rad;
    const bool zero = std::abs(angle_rad) <= 0.1 * kDegree;
    end(zero, fmt::format("it stood at {:.5f} rad before, and tells {:.5f} rad now{}", before_rad_,
                          after_rad_, zero ? "" : ": it did not take the zero"));
  }
}

}  // namespace geodesic::drivers::myactuator
