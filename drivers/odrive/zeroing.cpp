// Makes where an ODrive stands its zero; see zeroing.hpp.
#include "drivers/odrive/zeroing.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "drivers/odrive/codec.hpp"

namespace geodesic::drivers::odrive {

namespace {
constexpr int kLooks = 5;  ///< positions before it counts as standing still
constexpr std::int64_t kSettleNs = 50'000'000;
/// A drive that was told to restart is gone at least for so long.
constexpr std::int64_t kLeastRebootNs = 100'000'000;
}  // namespace

OdriveZeroing::OdriveZeroing(const DriveOptions& options)
    : node_(options.id), firmware_(Settings(options).firmware), status_(firmware_) {
  if (firmware_ == Firmware::k05) {
    refuse(
        "firmware 0.5 cannot keep a zero over power-off by command: write the position that it "
        "tells as the joint's offset into the robot file");
  }
}

void OdriveZeroing::enter(Step step, std::int64_t now_ns) {
  step_ = step;
  entered_ns_ = now_ns;
  next_ns_ = now_ns;
  asks_ = 0;
  estimates_ = 0;
}

void OdriveZeroing::refuse(std::string why) {
  report_ = std::move(why);
  step_ = Step::kOver;
}

const char* OdriveZeroing::waited_for() const {
  switch (step_) {
    case Step::kLook:
      return "tell its heartbeat, version, errors and position";
    case Step::kReturn:
      return "come back after it was told to save and restart";
    default:
      return "tell its position";
  }
}

void OdriveZeroing::receive(const ReceivedFrame& received) {
  const Frame& frame = received.frame;
  if (frame.error || frame.extended || frame.fd || frame.remote || node_of(frame) != node_) {
    return;
  }
  status_.take(received);
  if (command_of(frame) != Command::kEstimates || received.stamp_ns < entered_ns_) {
    return;
  }
  const auto position = decode(frame, kEstimates.fields[0]);
  const auto velocity = decode(frame, kEstimates.fields[1]);
  if (position && velocity) {
    position_rev_ = *position;
    velocity_rev_s_ = *velocity;
    estimate_ns_ = received.stamp_ns;
    ++estimates_;
  }
}

void OdriveZeroing::look(std::int64_t now_ns) {
  const bool known = status_.heartbeats > 0 && status_.versions > 0 && status_.error_answers > 0 &&
                     estimates_ >= kLooks;
  if (!known) {
    return;
  }
  if (status_.axis_state != kAxisIdle) {
    refuse(fmt::format("the axis is not idle but in state {} ({}): nothing was changed",
                       status_.axis_state, state_name(status_.axis_state)));
  } else if (status_.error() && !status_.only_watchdog()) {
    refuse(fmt::format("the drive has an error ({}): nothing was changed",
                       error_name(status_.code())));
  } else if (!std::isfinite(position_rev_) || !std::isfinite(velocity_rev_s_)) {
    refuse("the drive knows no position (NaN): calibrate its encoder; nothing was changed");
  } else if (std::abs(velocity_rev_s_) > kStillRevS) {
    refuse(fmt::format("the drive moves ({:.4g} rev/s): hold it still; nothing was changed",
                       velocity_rev_s_));
  } else {
    before_rev_ = position_rev_;
    enter(Step::kSet, now_ns);
  }
}

void OdriveZeroing::check(std::int64_t now_ns, Step next) {
  if (estimates_ == 0) {
    return;
  }
  after_rev_ = position_rev_;
  if (!(std::abs(position_rev_) <= kToleranceRev)) {
    refuse(
        fmt::format("the drive told {:.6g} rev before and {:.6g} rev {}; expected 0: check that "
                    "its encoder is absolute and its firmware is 0.6",
                    before_rev_, position_rev_,
                    next == Step::kOver ? "after saving and restarting" : "after zeroing"));
    return;
  }
  if (next == Step::kOver) {
    done_ = true;
    refuse(fmt::format("the drive told {:.6g} rev before, {:.6g} rev after saving and restarting",
                       before_rev_, position_rev_));
    return;
  }
  enter(next, now_ns);
}

std::optional<Frame> OdriveZeroing::transmit(std::int64_t now_ns) {
  entered_ns_ = entered_ns_ < 0 ? now_ns : entered_ns_;
  switch (step_) {
    case Step::kLook:
      look(now_ns);
      break;
    case Step::kCheck:
      check(now_ns, Step::kSave);
      break;
    case Step::kReturn:
      if (status_.heartbeat_ns - entered_ns_ >= kLeastRebootNs && status_.axis_state == kAxisIdle) {
        enter(Step::kConfirm, now_ns);
      }
      break;
    case Step::kConfirm:
      check(now_ns, Step::kOver);
      break;
    case Step::kSet:
    case Step::kSave:
    case Step::kOver:
      break;
  }
  const std::int64_t patience_ns = step_ == Step::kReturn ? kRebootNs : kTimeoutNs;
  if (!over() && now_ns - entered_ns_ > patience_ns) {
    refuse(fmt::format("the drive did not {}", waited_for()));
  }
  if (over() || now_ns < next_ns_) {
    return std::nullopt;
  }
  next_ns_ = now_ns + kAskNs;
  switch (step_) {
    case Step::kLook: {
      constexpr std::array kAsked = {Command::kVersion, Command::kError, Command::kEstimates};
      const int ask = asks_++;
      return encode_request(node_, kAsked[static_cast<std::size_t>(ask) % kAsked.size()]);
    }
    case Step::kSet:
      enter(Step::kCheck, now_ns + kSettleNs);
      return encode(node_, kSetAbsolutePosition06, {0.0});
    case Step::kSave:
      enter(Step::kReturn, now_ns);
      return encode(node_, kReboot06, {kRebootAndSave});
    case Step::kCheck:
    case Step::kConfirm:
      return encode_request(node_, Command::kEstimates);
    case Step::kReturn:
    case Step::kOver:
      break;
  }
  return std::nullopt;
}

}  // namespace geodesic::drivers::odrive
