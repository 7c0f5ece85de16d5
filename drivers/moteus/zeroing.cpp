// Setting a moteus drive's zero; see zeroing.hpp for what it promises.
#include "drivers/moteus/zeroing.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "drivers/moteus/driver.hpp"
#include "drivers/moteus/family.hpp"

namespace geodesic::drivers::moteus {

Zeroing::Zeroing(const DriveOptions& options) : link_(link_for(options)) {}

void Zeroing::enter(Step step) {
  step_ = step;
  awaiting_ = false;
  tries_ = 0;
  looks_ = 0;
  since_ns_ = asked_ns_;
  if (step == Step::kSet) {
    console_.ask("d cfg-set-output 0.0\n");
  } else if (step == Step::kWrite) {
    console_.ask("conf write\n");
  }
}

void Zeroing::refuse(std::string why) {
  report_ = std::move(why);
  enter(Step::kRefused);
}

std::optional<Frame> Zeroing::transmit(std::int64_t now_ns) {
  if (over() || now_ns < next_ns_ || (awaiting_ && now_ns - asked_ns_ < kReplyNs)) {
    return std::nullopt;
  }
  const bool talking = step_ == Step::kSet || step_ == Step::kWrite;
  if ((awaiting_ && ++tries_ == kTries) || (talking && now_ns - since_ns_ > kWriteNs)) {
    refuse(step_ == Step::kBefore
               ? fmt::format("drive {} does not answer: check its supply, its id, and that the bus "
                             "runs CAN FD at 1 and 5 Mbit/s",
                             link_.drive)
               : fmt::format("drive {} has stopped answering: read its position before you trust "
                             "its zero",
                             link_.drive));
    return std::nullopt;
  }
  awaiting_ = true;
  asked_ns_ = now_ns;
  if (talking) {
    return console_.request(link_);
  }
  Frame frame = make_frame(link_.command());
  constexpr std::array kAsked = {Item{Register::kMode, Resolution::kInt8},
                                 Item{Register::kPosition, Resolution::kFloat},
                                 Item{Register::kVelocity, Resolution::kFloat},
                                 Item{Register::kTorque, Resolution::kFloat},
                                 Item{Register::kHomeState, Resolution::kInt8},
                                 Item{Register::kVoltage, Resolution::kInt8},
                                 Item{Register::kTemperature, Resolution::kInt8},
                                 Item{Register::kFault, Resolution::kInt8}};
  append_reads(frame, kAsked);
  pad(frame);
  return frame;
}

void Zeroing::receive(const ReceivedFrame& received) {
  const Frame& frame = received.frame;
  if (!awaiting_ || frame.error || frame.remote || frame.id != to_id(link_.reply())) {
    return;
  }
  if (step_ == Step::kSet || step_ == Step::kWrite) {
    hear(frame);
  } else {
    look(frame);
  }
}

void Zeroing::hear(const Frame& reply) {
  if (!console_.take(reply)) {
    return;
  }
  awaiting_ = false;
  tries_ = 0;
  if (!console_.answered()) {
    return;
  }
  if (console_.answer() != "OK") {
    refuse(fmt::format("the drive answers '{}' to {}: {}", console_.answer(),
                       step_ == Step::kSet ? "d cfg-set-output" : "conf write",
                       "update its firmware, or set the zero by moteus_tool --zero-offset"));
  } else {
    enter(step_ == Step::kSet ? Step::kWrite : Step::kAfter);
  }
}

void Zeroing::look(const Frame& reply) {
  const StateReport report = decode_report(reply);
  double home = std::nan("");
  Reader reader(reply);
  for (Entry entry; reader.next(entry);) {
    home = entry.kind == opcode::kReply && entry.number == 0x00C ? entry.value : home;
  }
  if (!report.mode || !report.position_rev || std::isnan(home)) {
    return;
  }
  awaiting_ = false;
  tries_ = 0;
  next_ns_ = asked_ns_ + kBetweenNs;
  const double position_rad = *report.position_rev * 2.0 * std::numbers::pi;
  if (is_running(*report.mode)) {
    refuse(fmt::format("the drive is enabled (mode {}): stop whoever commands it", *report.mode));
  } else if (is_error(*report.mode)) {
    refuse(fmt::format("the drive reports error {} ({}): remove its cause first",
                       error_of(*report.mode, report.fault.value_or(0)),
                       error_name(error_of(*report.mode, report.fault.value_or(0)))));
  } else if (!std::isfinite(position_rad)) {
    refuse("the drive has no valid position: check its encoder and calibration");
  } else if (!(home >= static_cast<double>(Home::kRotor))) {
    refuse("the drive's position is referenced to nothing (home state 0): a zero would be lost");
  } else if (step_ == Step::kBefore) {
    if (looks_ > 0 && std::abs(position_rad - before_rad_) > kRestRad) {
      refuse(fmt::format("the drive moves: {:+.4f} rad, then {:+.4f}; hold the joint still",
                         before_rad_, position_rad));
      return;
    }
    before_rad_ = position_rad;
    if (++looks_ == kLooks) {
      enter(Step::kSet);
    }
  } else {
    after_rad_ = position_rad;
    if (!(std::abs(position_rad) <= kZeroRad)) {
      refuse(
          fmt::format("the drive took the zero but reads {:+.4f} rad: hold the joint still and "
                      "set it again",
                      position_rad));
    } else if (++looks_ == kLooks) {
      report_ = fmt::format("was at {:+.4f} rad, reads {:+.4f} rad as its new zero, kept",
                            before_rad_, after_rad_);
      enter(Step::kDone);
    }
  }
}

}  // namespace geodesic::drivers::moteus
