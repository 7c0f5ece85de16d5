// What the host's side of one CiA 402 drive makes of the frames it receives; see driver.hpp. What
// it sends is in driver.cpp.
#include <algorithm>

#include "drivers/cia402/driver.hpp"
#include "drivers/cia402/errors.hpp"

namespace geodesic::drivers::cia402 {

using control::DriveCondition;

namespace {

constexpr DriveComplaint kDoubled{
    "reports (TPDO1) to one SYNC", 2.0, 1.0,
    "a second drive has this one's node, or another master sends SYNC: give each its own node"};

constexpr double state_bits(PowerState state) noexcept {
  return kPowerStates[static_cast<std::size_t>(state)].bits;
}

}  // namespace

bool Driver::receive(const ReceivedFrame& received) noexcept {
  const Frame& frame = received.frame;
  if (frame.error || frame.extended || frame.fd || frame.remote) {
    return false;
  }
  bool news = false;
  if (frame.id == cob::kTransmit1 + node_) {
    const std::optional<Report> report = decode_report(frame);
    news = report && take_report(*report, received.stamp_ns);
  } else if (frame.id == cob::kTransmit2 + node_) {
    const std::optional<std::int32_t> velocity = decode_velocity(frame);
    if (velocity && report_open_) {
      next_.velocity_rad_s = static_cast<double>(*velocity) * units_.rad_s_per_velocity;
      report_open_ = false;
      state_ = next_;
      news = true;
    }
  } else if (frame.id == cob::kSdoReply + node_) {
    if (const std::optional<Sdo> reply = decode_sdo_reply(frame)) {
      last_heard_ns_ = received.stamp_ns;
      if (phase_ == Phase::kStartUp) {
        start_up_.receive_sdo(*reply);
      }
    }
  } else if (frame.id == cob::kHeartbeat + node_) {
    if (const std::optional<NmtState> state = decode_heartbeat(frame)) {
      last_heard_ns_ = received.stamp_ns;
      last_heartbeat_ns_ = received.stamp_ns;
      take_heartbeat(*state);
    }
  } else if (frame.id == cob::kEmergency + node_) {
    if (const std::optional<Emergency> emergency = decode_emergency(frame)) {
      last_heard_ns_ = received.stamp_ns;
      take_emergency(*emergency);
    }
  } else {
    return false;
  }
  if (phase_ == Phase::kStartUp && start_up_.done()) {
    phase_ = Phase::kWaking;
    operational_ = true;
    last_heartbeat_ns_ = received.stamp_ns;
    next_clear_ns_ = 0;
  } else if (phase_ == Phase::kStartUp && start_up_.refused()) {
    phase_ = Phase::kRefused;
  }
  update_condition();
  return news;
}

bool Driver::take_report(const Report& report, std::int64_t stamp_ns) noexcept {
  if (phase_ == Phase::kStartUp) {
    start_up_.receive_process_data();
    if (!start_up_.done()) {
      return false;  // mapped by whoever used the drive before
    }
  }
  const std::optional<PowerState> power = power_state(report.statusword);
  if (!power) {
    return false;  // no state of the profile: not ours to interpret
  }
  surplus_ += 4;
  if (surplus_ >= kSurplusLimit && phase_ != Phase::kRefused) {
    complaint_ = kDoubled;
    phase_ = Phase::kRefused;
  }
  if (stamp_ns - last_heard_ns_ > kForgetNs) {
    counting_ = false;  // it may have been off
  }
  last_heard_ns_ = stamp_ns;
  last_report_ns_ = stamp_ns;
  power_ = *power;
  power_known_ = true;
  take_power_state();
  if (phase_ == Phase::kRefused) {
    return false;
  }
  next_ = state_;
  next_.torque_nm = from_permille(report.torque_permille, units_.rated_nm);
  take_position(report.position, stamp_ns);
  next_.stamp_ns = stamp_ns;
  report_open_ = units_.rad_s_per_velocity > 0.0;
  if (report_open_) {
    return false;  // TPDO2, which follows, makes it whole
  }
  state_ = next_;
  return true;
}

void Driver::take_position(std::int32_t counted, std::int64_t stamp_ns) noexcept {
  const auto now = static_cast<std::uint32_t>(counted);
  const bool first = !counting_;
  if (first) {
    position_ = counted;
  } else {
    position_ += static_cast<std::int32_t>(now - counted_);  // around 32 bits, too
  }
  counting_ = true;
  counted_ = now;
  const double position_rad = static_cast<double>(position_) * units_.rad_per_increment;
  const std::int64_t elapsed_ns = stamp_ns - next_.stamp_ns;
  if (first || next_.stamp_ns == 0) {
    next_.velocity_rad_s = 0.0;
  } else if (elapsed_ns > 0) {
    next_.velocity_rad_s =
        (position_rad - next_.position_rad) / (static_cast<double>(elapsed_ns) * 1e-9);
  }
  next_.position_rad = position_rad;
}

void Driver::take_power_state() noexcept {
  const bool fault = in_fault();
  if (!fault && power_ != PowerState::kNotReady) {
    error_ = 0;
  }
  switch (phase_) {
    case Phase::kWaking:
      held_by_error_ = fault && (!options_.clear_errors || clears_ >= kMaxClears);
      if (held_by_error_) {
        complaint_ = {"state of the drive (0x6041:0: an error)", state_bits(power_),
                      state_bits(PowerState::kSwitchOnDisabled),
                      "remove its cause; then power-cycle the drive, or let clear_errors clear it"};
      } else if (!fault && power_ != PowerState::kNotReady && power_ != PowerState::kEnabled &&
                 power_ != PowerState::kQuickStop) {
        complaint_ = {};
        phase_ = Phase::kIdle;
      }
      break;
    case Phase::kEnabling:
      if (fault) {
        drop_out();
      } else if (power_ == PowerState::kEnabled) {
        phase_ = Phase::kEnabled;
        diffusion_.reset();
      }
      break;
    case Phase::kEnabled:
      if (power_ != PowerState::kEnabled) {
        drop_out();
      }
      break;
    case Phase::kDisabling:
      if (disable_sent_ && power_ != PowerState::kEnabled && power_ != PowerState::kQuickStop) {
        phase_ = Phase::kIdle;
      }
      break;
    case Phase::kStartUp:
    case Phase::kIdle:
    case Phase::kOut:
    case Phase::kRefused:
      break;
  }
}

void Driver::take_heartbeat(NmtState state) noexcept {
  if (phase_ == Phase::kStartUp) {
    start_up_.receive_state(state);
    return;
  }
  if (state == NmtState::kOperational) {
    return;
  }
  // It has been reset, or has left operational by itself: what we told it may be gone.
  operational_ = false;
  report_open_ = false;
  if (phase_ == Phase::kEnabling || phase_ == Phase::kEnabled) {
    complaint_ = {"NMT state in its heartbeat (5: operational, 127: pre-operational, 0: boot-up)",
                  static_cast<double>(state), static_cast<double>(NmtState::kOperational),
                  "the drive has been reset, lost its supply or this host's heartbeat"};
    drop_out();
  }
}

void Driver::watch_silence(std::int64_t now_ns) noexcept {
  if (phase_ != Phase::kEnabling && phase_ != Phase::kEnabled) {
    return;
  }
  const double period_ms = number(options_, Setting::kHeartbeat);
  const double quiet_ms = static_cast<double>(now_ns - last_heartbeat_ns_) * 1e-6;
  const double silent_ms = static_cast<double>(now_ns - last_report_ns_) * 1e-6;
  const double watchdog_ms = static_cast<double>(options_.watchdog_ns) * 1e-6;
  if (silent_ms > watchdog_ms) {
    complaint_ = {"silence of the drive's reports (TPDO1) [ms]", silent_ms, watchdog_ms,
                  "its own watchdog may have ended its torque meanwhile: look at the bus"};
    drop_out();
  } else if (quiet_ms > kMissedHeartbeats * period_ms) {
    complaint_ = {"silence of the drive's heartbeat (0x1017) [ms]", quiet_ms, period_ms,
                  "the drive has stopped or lost its setting: look at its supply and the bus"};
    drop_out();
  }
}

void Driver::take_emergency(const Emergency& emergency) noexcept {
  const std::uint8_t error = error_of(emergency.code);
  if (error != 0) {
    error_ = error;
    if (phase_ != Phase::kStartUp && phase_ != Phase::kRefused) {
      complaint_ = {"emergency (EMCY) of the drive: error code",
                    static_cast<double>(emergency.code), 0.0,
                    "see the error's name, and the drive's manual for its cause"};
    }
  } else if (!in_fault()) {
    error_ = 0;
  }
}

void Driver::update_condition() noexcept {
  // An emergency alone is a warning: the drive itself says by its state whether it goes on. One
  // that has left operational says no more than that.
  const bool fault = in_fault() || (phase_ == Phase::kOut && !operational_ && error_ != 0);
  state_.error = fault ? std::max(error_, kUnspecifiedFault) : std::uint8_t{0};
  next_.error = state_.error;
  if (phase_ == Phase::kRefused) {
    state_.condition = DriveCondition::kRefused;
  } else if (phase_ == Phase::kStartUp && !start_up_.heard()) {
    state_.condition = DriveCondition::kUnknown;
  } else if (phase_ == Phase::kStartUp || (phase_ == Phase::kWaking && !held_by_error_)) {
    state_.condition = DriveCondition::kConfiguring;
  } else if (fault) {
    state_.condition = DriveCondition::kError;
  } else if (phase_ == Phase::kEnabled ||
             (phase_ == Phase::kDisabling && power_ == PowerState::kEnabled)) {
    state_.condition = DriveCondition::kEnabled;
  } else {
    // Out and enabled by somebody else: it does not follow our torque, and is being disabled.
    state_.condition = DriveCondition::kDisabled;
  }
  next_.condition = state_.condition;
}

}  // namespace geodesic::drivers::cia402
