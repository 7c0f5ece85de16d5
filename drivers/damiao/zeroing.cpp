// Setting a Damiao drive's zero; see zeroing.hpp for what it promises.
#include "drivers/damiao/zeroing.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "drivers/damiao/family.hpp"

namespace geodesic::drivers::damiao {

namespace {
constexpr double kRangeTolerance = 1e-3;  ///< relative, as at start-up
}  // namespace

Zeroing::Zeroing(const DriveOptions& options)
    : options_(options),
      ranges_{options.position_range_rad, options.velocity_range_rad_s, options.torque_range_nm} {}

void Zeroing::enter(Step step) {
  step_ = step;
  awaiting_ = false;
  tries_ = 0;
  looks_ = 0;
  bad_looks_ = 0;
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
    refuse(step_ == Step::kRange
               ? fmt::format("drive 0x{:X} does not answer: check its supply, its id, and whether "
                             "it speaks {}",
                             options_.id, options_.fd ? "CAN FD" : "classic CAN")
               : fmt::format("drive 0x{:X} has stopped answering: read its position before you "
                             "trust its zero",
                             options_.id));
    return std::nullopt;
  }
  awaiting_ = true;
  asked_ns_ = now_ns;
  switch (step_) {
    case Step::kRange:
      return encode_read(options_.id, options_.fd,
                         static_cast<std::uint8_t>(Register::kPositionRange));
    case Step::kZero:
      return encode_special(options_.id, options_.fd, Special::kSetZero);
    default:
      return encode_state_request(options_.id, options_.fd);
  }
}

void Zeroing::receive(const ReceivedFrame& received) {
  const Frame& frame = received.frame;
  if (!awaiting_ || frame.error || frame.extended || frame.remote ||
      frame.id != options_.reply_id) {
    return;
  }
  if (step_ == Step::kRange) {
    const std::optional<RegisterFrame> answer = decode_register(frame);
    if (!answer || answer->id != options_.id ||
        answer->operation != static_cast<std::uint8_t>(Operation::kRead) ||
        answer->number != static_cast<std::uint8_t>(Register::kPositionRange)) {
      return;
    }
    // Written so that a NaN from the drive is a mismatch.
    if (!(std::abs(answer->real() - ranges_.position_rad) <=
          kRangeTolerance * ranges_.position_rad)) {
      refuse(
          fmt::format("PMAX (register 21) is {:.6g} rad, the robot file says {:.6g}: correct "
                      "position_range_rad, or write register 21 and save",
                      answer->real(), ranges_.position_rad));
      return;
    }
    enter(Step::kBefore);
    return;
  }
  const std::optional<StateReport> report = decode_report(frame, ranges_);
  if (!report || report->motor != (options_.id & 0xFU)) {
    return;
  }
  awaiting_ = false;
  tries_ = 0;
  next_ns_ = asked_ns_ + kBetweenNs;
  look(*report);
}

void Zeroing::look(const StateReport& report) {
  if (report.status == static_cast<std::uint8_t>(Status::kEnabled)) {
    refuse("the drive is enabled: disable it first (stop whoever commands it)");
    return;
  }
  if (report.status != static_cast<std::uint8_t>(Status::kDisabled)) {
    refuse(fmt::format("the drive reports error 0x{:X} ({}): remove its cause first", report.status,
                       error_name(report.status)));
    return;
  }
  if (step_ == Step::kZero) {
    enter(Step::kAfter);
    return;
  }
  if (step_ == Step::kBefore) {
    if (looks_ > 0 && std::abs(report.position_rad - before_rad_) > kRestRad) {
      refuse(fmt::format("the drive moves: {:+.4f} rad, then {:+.4f}; hold the joint still",
                         before_rad_, report.position_rad));
      return;
    }
    before_rad_ = report.position_rad;
    if (++looks_ == kLooks) {
      enter(Step::kZero);
    }
    return;
  }
  after_rad_ = report.position_rad;
  const double resolution = 2.0 * ranges_.position_rad / 65535.0;
  if (std::abs(after_rad_) <= kCodes * resolution) {
    if (++looks_ == kLooks) {
      report_ = fmt::format("stood at {:+.4f} rad, reads {:+.4f} rad now", before_rad_, after_rad_);
      enter(Step::kDone);
    }
    return;
  }
  looks_ = 0;
  if (++bad_looks_ < kLooks) {
    return;
  }
  if (++zeros_ < kZeros) {
    enter(Step::kZero);
    return;
  }
  refuse(
      fmt::format("the drive has not taken its zero: it stood at {:+.4f} rad and reads {:+.4f} "
                  "rad, expected 0 within {:.4f}",
                  before_rad_, after_rad_, kCodes * resolution));
}

}  // namespace geodesic::drivers::damiao
