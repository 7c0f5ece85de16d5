// The host's side of one ODrive axis; see driver.hpp for what it promises.
#include "drivers/odrive/driver.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace geodesic::drivers::odrive {

using control::DriveMode;

namespace {

/// More than any cycle brings: only a report of the position ends the waiting for it.
constexpr std::size_t kUntilReport = 16;
constexpr std::int64_t kIdleIntervalNs = 10'000'000;     ///< between two requests to be idle
constexpr std::int64_t kEnableIntervalNs = 150'000'000;  ///< at least, between two to be enabled

}  // namespace

Driver::Driver(const DriveOptions& options)
    : options_(options), settings_(options), status_(settings_.firmware), start_up_(options) {}

void Driver::restart() noexcept {
  // The mode stays: a drive that was out does not come back because somebody restarted it.
  enable_due_ = false;
  complaint_ = {};
  begin_start_up();
}

void Driver::begin_start_up() noexcept {
  start_up_.restart(expired_);
  status_.forget();
  heartbeat_lost_ = false;
  phase_ = Phase::kStartUp;
  update_condition();
}

void Driver::leave(std::int64_t now_ns) noexcept {
  phase_ = Phase::kOut;
  expired_ = expired_ || status_.watchdog_expired();
  requested_ns_ = now_ns - kIdleIntervalNs;
  next_slow_ns_ = now_ns;
}

void Driver::follow(DriveMode mode, std::int64_t now_ns) noexcept {
  const bool wanted = mode == DriveMode::kEnable;
  enable_due_ = wanted && (enable_due_ || mode_ != DriveMode::kEnable);
  mode_ = mode;
  switch (phase_) {
    case Phase::kIdle:
      if (now_ns - last_heard_ns_ > kForgetNs) {
        begin_start_up();
      } else if (enable_due_) {
        enable_due_ = false;
        enables_ = 0;
        mode_set_ = false;
        bad_heartbeats_ = 0;
        phase_ = Phase::kEnabling;
      }
      break;
    case Phase::kEnabling:
    case Phase::kEnabled:
      if (!wanted) {
        phase_ = Phase::kDisabling;
        zero_sent_ = false;
        requested_ns_ = 0;
      }
      break;
    case Phase::kOut:
      // kDisable leaves the drive as it is, so that its error can still be read.
      if (enable_due_ || mode == DriveMode::kMonitor) {
        begin_start_up();
      }
      break;
    case Phase::kStartUp:
    case Phase::kDisabling:
    case Phase::kRefused:
      break;
  }
}

void Driver::watch(std::int64_t now_ns) noexcept {
  const bool operating = phase_ == Phase::kEnabling || phase_ == Phase::kEnabled;
  // A drive of which nothing is heard is silent, which is seen elsewhere.
  const bool speaks = now_ns - last_heard_ns_ <= kForgetNs;
  if (operating && speaks && now_ns - status_.heartbeat_ns > kHeartbeatLostNs) {
    heartbeat_lost_ = true;
    complaint_ = {
        "time since the last heartbeat [s]",
        static_cast<double>(now_ns - status_.heartbeat_ns) * 1e-9, settings_.heartbeat_ms() * 1e-3,
        "check the drive's supply and wiring: without a heartbeat nobody knows whether it "
        "makes torque"};
    leave(now_ns);
  } else if (phase_ == Phase::kIdle && now_ns - status_.heartbeat_ns > kHeartbeatLostNs) {
    begin_start_up();
  }
  update_condition();
}

void Driver::add(const std::optional<Frame>& frame) noexcept {
  if (frame && count_ < out_.size()) {
    out_[count_++] = *frame;
  }
}

std::size_t Driver::transmit(const DriveCommand& command, std::int64_t now_ns,
                             std::span<Frame> out) noexcept {
  follow(command.mode, now_ns);
  watch(now_ns);
  out_ = out.first(std::min(out.size(), kMaxFramesPerCycle));
  count_ = 0;
  due_ = 0;
  if (phase_ == Phase::kStartUp) {
    count_ = start_up_.transmit(now_ns, status_, out);
    due_ = start_up_.answers_due();
    if (start_up_.refused()) {
      phase_ = Phase::kRefused;
    } else if (start_up_.done()) {
      phase_ = Phase::kIdle;
      expired_ = false;
      next_slow_ns_ = now_ns;
    }
    update_condition();
    if (phase_ != Phase::kIdle) {
      return count_;
    }
  }
  switch (phase_) {
    case Phase::kEnabling:
      add_enabling(now_ns);
      break;
    case Phase::kEnabled:
      add_torque(command, now_ns);
      break;
    case Phase::kDisabling:
      add_disabling(now_ns);
      break;
    case Phase::kRefused:
      add(encode_request(options_.id, Command::kError));
      due_ = 1;
      return count_;
    case Phase::kStartUp:
    case Phase::kIdle:
    case Phase::kOut:
      // Feeds the watchdog and commands nothing.
      add(encode(options_.id, kSetInputTorque, {0.0}));
      // An axis we have not enabled, yet is: somebody else's doing, or it slept through our
      // request.
      if (status_.axis_state != kAxisIdle && status_.axis_state != kAxisUndefined &&
          now_ns - requested_ns_ >= kIdleIntervalNs) {
        requested_ns_ = now_ns;
        add(encode(options_.id, kSetAxisState, {kAxisIdle}));
      }
      break;
  }
  // Requests go first: while the drive makes up its answer, the command is on the wire.
  const std::size_t commands = count_;
  add_requests(now_ns);
  std::rotate(out_.begin(), out_.begin() + static_cast<std::ptrdiff_t>(commands),
              out_.begin() + static_cast<std::ptrdiff_t>(count_));
  return count_;
}

std::size_t Driver::answers_due(std::size_t frames) const noexcept {
  return frames == 0 ? 0 : due_;
}

void Driver::add_requests(std::int64_t now_ns) noexcept {
  // An axis that is out may have been off, and have forgotten how often it is to report.
  const bool asks = settings_.by_request || phase_ == Phase::kOut;
  const std::size_t others = asks ? 1 : 0;
  if (now_ns >= next_slow_ns_ && count_ + others < out_.size()) {
    next_slow_ns_ = now_ns + kSlowNs;
    if (phase_ == Phase::kOut || settings_.firmware == Firmware::k05) {
      add(encode_request(options_.id, Command::kError));
    } else {
      add(encode_request(options_.id, Command::kTemperature));
    }
  }
  if (settings_.requests_torque() && count_ + others < out_.size()) {
    add(encode_request(options_.id, settings_.torque_command()));
  }
  if (asks) {
    add(encode_request(options_.id, Command::kEstimates));
  }
  due_ = kUntilReport;
}

void Driver::add_enabling(std::int64_t now_ns) noexcept {
  if (!mode_set_) {
    mode_set_ = true;
    add(encode(options_.id, kSetLimits,
               {settings_.velocity_limit_rad_s / kTurn, settings_.current_limit_a}));
    add(encode(options_.id, kSetControllerMode, {kTorqueControl, kPassthrough}));
    add(encode(options_.id, kSetInputTorque, {0.0}));
    requested_ns_ = now_ns - std::max(kEnableIntervalNs, 2 * status_.heartbeat_interval_ns);
    return;
  }
  add(encode(options_.id, kSetInputTorque, {0.0}));
  if (now_ns - requested_ns_ < std::max(kEnableIntervalNs, 2 * status_.heartbeat_interval_ns)) {
    return;
  }
  if (enables_ == kMaxEnables) {
    complaint_ = {"axis state after the request for closed loop",
                  static_cast<double>(status_.axis_state), static_cast<double>(kAxisClosedLoop),
                  "check that motor and encoder are calibrated and the supply is on"};
    leave(now_ns);
    update_condition();
    return;
  }
  ++enables_;
  requested_ns_ = now_ns;
  if (start_up_.idle_expires() && status_.only_watchdog()) {
    add(encode(options_.id, settings_.firmware == Firmware::k06 ? kClearErrors06 : kClearErrors05,
               {}));
  }
  add(encode(options_.id, kSetAxisState, {kAxisClosedLoop}));
}

void Driver::add_disabling(std::int64_t now_ns) noexcept {
  add(encode(options_.id, kSetInputTorque, {0.0}));
  if (zero_sent_ && now_ns - requested_ns_ >= kIdleIntervalNs) {
    requested_ns_ = now_ns;
    add(encode(options_.id, kSetAxisState, {kAxisIdle}));
  }
  zero_sent_ = true;
}

double Driver::wanted_torque(const DriveCommand& command, std::int64_t now_ns) noexcept {
  if (!is_finite(command)) {
    return std::numeric_limits<double>::quiet_NaN();
  }
  double torque_nm = command.torque_nm;
  if (state_.stamp_ns > 0 && now_ns - state_.stamp_ns <= kStaleNs) {
    torque_nm += command.stiffness_nm_rad * (command.position_rad - state_.position_rad) +
                 command.damping_nm_s_rad * (command.velocity_rad_s - state_.velocity_rad_s);
  }
  return torque_nm;
}

void Driver::add_torque(const DriveCommand& command, std::int64_t now_ns) noexcept {
  double torque_nm = wanted_torque(command, now_ns);
  if (!std::isfinite(torque_nm)) {
    // The drive has no damping of its own to fall back on.
    torque_nm = 0.0;
    complaint_ = {"command (torque, position, velocity, stiffness or damping)",
                  std::numeric_limits<double>::quiet_NaN(), 0.0,
                  "the controller's numbers are not finite: keep the log and report it"};
  }
  torque_nm = std::clamp(torque_nm, -options_.torque_range_nm, options_.torque_range_nm);
  if (settings_.torque_feedback == TorqueFeedback::kNone) {
    state_.torque_nm = torque_nm;
  }
  add(encode(options_.id, kSetInputTorque, {torque_nm}));
}

const DriveComplaint& Driver::complaint() const noexcept {
  return complaint_.quantity != nullptr ? complaint_ : start_up_.complaint();
}

std::vector<IdFilter> Driver::reply_ids() const {
  // Not the whole node by a mask: commands lie between the reports, and are no replies.
  std::vector<IdFilter> ids;
  for (const Message* message : kMessages) {
    if (message->report && message->in(settings_.firmware)) {
      ids.push_back({frame_id(options_.id, message->command), false});
    }
  }
  if (settings_.firmware == Firmware::k05) {
    ids.push_back({frame_id(options_.id, Command::kVersion), false});  // it may be a 0.6
  }
  return ids;
}

std::vector<IdFilter> Driver::command_ids() const {
  std::vector<IdFilter> ids;
  for (const Message* message : kMessages) {
    if (!message->report && message->in(settings_.firmware)) {
      ids.push_back({frame_id(options_.id, message->command), false});
    }
  }
  return ids;
}

}  // namespace geodesic::drivers::odrive
