// Setting a RobStride or CyberGear drive's zero; see zeroing.hpp for what it promises.
#include "drivers/robstride/zeroing.hpp"

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <utility>

#include "drivers/robstride/family.hpp"
#include "drivers/robstride/settings.hpp"

namespace geodesic::drivers::robstride {

namespace {
constexpr auto kLimitIndex = static_cast<std::uint16_t>(Index::kTorqueLimit);
}  // namespace

Zeroing::Zeroing(const DriveOptions& options)
    : link_(robstride::link_of(options)),
      ranges_(ranges_of(options)),
      cybergear_(is_cybergear(options)) {}

void Zeroing::enter(Step step) {
  step_ = step;
  awaiting_ = false;
  tries_ = 0;
  looks_ = 0;
}

void Zeroing::refuse(std::string why) {
  report_ = std::move(why);
  enter(Step::kRefused);
}

std::optional<Frame> Zeroing::transmit(std::int64_t now_ns) {
  if (over() || now_ns < next_ns_ || (awaiting_ && now_ns - asked_ns_ < kReplyNs)) {
    return std::nullopt;
  }
  if (awaiting_ && ++tries_ == kTries) {
    refuse(step_ == Step::kLimit
               ? fmt::format("drive {} does not answer: check its supply and its id", link_.motor)
               : fmt::format("drive {} has stopped answering: read its position before you trust "
                             "its zero",
                             link_.motor));
    return std::nullopt;
  }
  awaiting_ = true;
  asked_ns_ = now_ns;
  switch (step_) {
    case Step::kLimit:
      return encode_read(link_, kLimitIndex);
    case Step::kZeroState:
      return encode_write(link_, static_cast<std::uint16_t>(Index::kZeroState), 1);
    case Step::kZero:
      return encode_zero(link_);
    case Step::kSave:
      return encode_save(link_);
    default:
      return encode_write(link_, kLimitIndex, limit_);
  }
}

void Zeroing::receive(const ReceivedFrame& received) {
  const auto ours = [this](const Link& link) {
    return link.motor == link_.motor && link.host == link_.host;
  };
  if (!awaiting_) {
    return;
  }
  if (step_ == Step::kLimit) {
    const std::optional<ParameterAnswer> answer = decode_parameter(received.frame);
    if (!answer || !ours(answer->link) || answer->index != kLimitIndex) {
      return;
    }
    // Written so that a NaN from the drive is a mismatch.
    if (answer->failed || !(answer->real() > 0.0 && answer->real() <= 1.001 * ranges_.torque_nm)) {
      refuse(fmt::format(
          "limit_torque (parameter 0x700B) is {:.6g} N·m, expected above 0 and at most the robot "
          "file's torque range, {:.6g}: is this the drive it names?",
          answer->failed ? std::nan("") : answer->real(), ranges_.torque_nm));
      return;
    }
    limit_ = answer->raw;
    enter(Step::kBefore);
    return;
  }
  const std::optional<Feedback> feedback = decode_feedback(received.frame, ranges_);
  if (feedback && ours(feedback->link)) {
    awaiting_ = false;
    tries_ = 0;
    next_ns_ = asked_ns_ + kBetweenNs;
    look(*feedback);
  }
}

void Zeroing::look(const Feedback& feedback) {
  if (feedback.mode != static_cast<std::uint8_t>(Mode::kReset)) {
    refuse("the drive is not stopped: disable it first (stop whoever commands it)");
    return;
  }
  if (feedback.faults != 0) {
    refuse(
        fmt::format("the drive reports a fault ({}): remove its cause first",
                    error_name(static_cast<std::uint8_t>(std::countr_zero(feedback.faults) + 1))));
    return;
  }
  switch (step_) {
    case Step::kBefore:
      if (looks_ > 0 && std::abs(feedback.position_rad - before_rad_) > kRestRad) {
        refuse(fmt::format("the drive moves: {:+.4f} rad, then {:+.4f}; hold the joint still",
                           before_rad_, feedback.position_rad));
        return;
      }
      before_rad_ = feedback.position_rad;
      if (++looks_ == kLooks) {
        enter(cybergear_ ? Step::kZero : Step::kZeroState);
      }
      return;
    case Step::kZeroState:
      enter(Step::kZero);
      return;
    case Step::kZero:
      enter(Step::kSave);
      return;
    case Step::kSave:
      enter(Step::kAfter);
      return;
    default:
      break;
  }
  after_rad_ = feedback.position_rad;
  if (++looks_ < kLooks) {
    return;
  }
  if (std::abs(after_rad_) <= kZeroRad) {
    report_ = fmt::format("stood at {:+.4f} rad, reads {:+.4f} rad now", before_rad_, after_rad_);
    enter(Step::kDone);
  } else {
    refuse(
        fmt::format("the drive has not taken its zero: it stood at {:+.4f} rad and reads "
                    "{:+.4f} rad, expected 0 within {}",
                    before_rad_, after_rad_, kZeroRad));
  }
}

}  // namespace geodesic::drivers::robstride
