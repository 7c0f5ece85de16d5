// What the host's side of one CiA 402 drive sends; see driver.hpp for what it promises. What it
// makes of what it receives is in driver_reports.cpp.
#include "drivers/cia402/driver.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace geodesic::drivers::cia402 {

using control::DriveMode;

namespace {

constexpr TorqueCommand kOff{control_word::kDisableVoltage, 0};

}  // namespace

Driver::Driver(const DriveOptions& options)
    : options_(options),
      node_(static_cast<std::uint8_t>(options.id)),
      units_(options),
      start_up_(options, units_),
      diffusion_(options.error_diffusion, 1e-3 * units_.rated_nm) {}

void Driver::restart() noexcept {
  // The mode stays: a drive that was out does not come back because somebody restarted it.
  enable_due_ = false;
  begin_start_up();
}

void Driver::begin_start_up() noexcept {
  start_up_.restart();
  phase_ = Phase::kStartUp;
  operational_ = false;
  synced_ = false;
  counting_ = false;
  report_open_ = false;
  power_known_ = false;
  held_by_error_ = false;
  clears_ = 0;
  surplus_ = 0;
  error_ = 0;
  complaint_ = {};
  update_condition();
}

void Driver::drop_out() noexcept {
  phase_ = Phase::kOut;
  diffusion_.reset();
}

bool Driver::in_fault() const noexcept {
  return power_known_ && (power_ == PowerState::kFault || power_ == PowerState::kFaultReaction);
}

void Driver::follow(DriveMode mode, std::int64_t now_ns) noexcept {
  const bool wanted = mode == DriveMode::kEnable;
  enable_due_ = wanted && (enable_due_ || mode_ != DriveMode::kEnable);
  mode_ = mode;
  switch (phase_) {
    case Phase::kWaking:
    case Phase::kIdle:
      if (now_ns - last_heard_ns_ > kForgetNs || !operational_) {
        begin_start_up();
      } else if (phase_ == Phase::kIdle && enable_due_) {
        enable_due_ = false;
        enabling_since_ns_ = now_ns;
        phase_ = in_fault() ? Phase::kOut : Phase::kEnabling;
      }
      break;
    case Phase::kEnabling:
    case Phase::kEnabled:
      if (!wanted) {
        phase_ = Phase::kDisabling;
        zero_sent_ = power_ != PowerState::kEnabled;
        disable_sent_ = false;
        diffusion_.reset();
      }
      break;
    case Phase::kDisabling:
      if (!operational_) {
        begin_start_up();
      }
      break;
    case Phase::kOut:
      // kDisable leaves the drive as it is, so that its error can still be read.
      if (enable_due_ || mode == DriveMode::kMonitor) {
        begin_start_up();
      }
      break;
    case Phase::kStartUp:
    case Phase::kRefused:
      break;
  }
}

std::size_t Driver::transmit(const DriveCommand& command, std::int64_t now_ns,
                             std::span<Frame> out) noexcept {
  if (out.empty()) {
    return 0;
  }
  watch_silence(now_ns);
  follow(command.mode, now_ns);
  surplus_ = std::max(surplus_ - 5, kSurplusFloor);
  std::size_t frames = own_frame(command, now_ns, out[0]) ? 1 : 0;
  synced_ = operational_;
  update_condition();
  if (options_.leader && now_ns >= next_host_heartbeat_ns_ && frames < out.size()) {
    next_host_heartbeat_ns_ = now_ns + kHostHeartbeatNs;
    out[frames++] = encode_heartbeat(integer(options_, Setting::kHostNode), NmtState::kOperational);
  }
  if (options_.leader && frames < out.size()) {
    out[frames++] = encode_sync();
  }
  return frames;
}

std::size_t Driver::answers_due(std::size_t frames) const noexcept {
  if (frames == 0) {
    return 0;
  }
  if (synced_) {
    return units_.rad_s_per_velocity > 0.0 ? 2 : 1;
  }
  return phase_ == Phase::kStartUp && start_up_.asked() ? 1 : 0;
}

bool Driver::own_frame(const DriveCommand& command, std::int64_t now_ns, Frame& out) noexcept {
  TorqueCommand words = kOff;
  switch (phase_) {
    case Phase::kStartUp: {
      const bool sent = start_up_.transmit(now_ns, out);
      if (start_up_.refused()) {
        phase_ = Phase::kRefused;
      }
      return sent;
    }
    case Phase::kWaking:
      words = waking(now_ns);
      break;
    case Phase::kEnabling:
      words = enabling(now_ns);
      break;
    case Phase::kEnabled:
      words = following(command, now_ns);
      break;
    case Phase::kDisabling:
      words = disabling();
      break;
    case Phase::kIdle:
    case Phase::kOut:
    case Phase::kRefused:
      // A drive we have not enabled, yet is: somebody else's doing. This disables it.
      break;
  }
  out = encode_torque(node_, words);
  return operational_;
}

/// Resets a fault that was there before us, if told to: an edge of bit 7 each time.
TorqueCommand Driver::waking(std::int64_t now_ns) noexcept {
  if (!options_.clear_errors || clears_ >= kMaxClears || !in_fault() || now_ns < next_clear_ns_) {
    return kOff;
  }
  next_clear_ns_ = now_ns + kClearIntervalNs;
  ++clears_;
  return {control_word::kFaultReset, 0};
}

TorqueCommand Driver::enabling(std::int64_t now_ns) noexcept {
  if (now_ns - enabling_since_ns_ <= kEnableTimeoutNs) {
    return {next_towards_enabled(power_), 0};
  }
  complaint_ = {
      "state on the way to operation enabled (0x6041:0, bits 0 to 6)",
      static_cast<double>(kPowerStates[static_cast<std::size_t>(power_)].bits),
      static_cast<double>(kPowerStates[static_cast<std::size_t>(PowerState::kEnabled)].bits),
      "check the drive's supply and its inputs for enabling"};
  drop_out();
  return kOff;
}

double Driver::braking_torque(double damping, std::int64_t now_ns) const noexcept {
  const bool stale = state_.stamp_ns == 0 || now_ns - state_.stamp_ns > kStaleNs;
  return stale ? 0.0 : -damping * state_.velocity_rad_s;
}

TorqueCommand Driver::following(const DriveCommand& command, std::int64_t now_ns) noexcept {
  double wanted = 0.0;
  if (is_finite(command)) {
    const bool stale = state_.stamp_ns == 0 || now_ns - state_.stamp_ns > kStaleNs;
    const double velocity = std::clamp(command.velocity_rad_s, -options_.velocity_range_rad_s,
                                       options_.velocity_range_rad_s);
    wanted = command.torque_nm;
    if (!stale) {
      wanted += command.stiffness_nm_rad * (command.position_rad - state_.position_rad) +
                command.damping_nm_s_rad * (velocity - state_.velocity_rad_s);
    }
  } else {
    complaint_ = {"command (torque, position, velocity, stiffness or damping)",
                  std::numeric_limits<double>::quiet_NaN(), 0.0,
                  "the controller's numbers are not finite: keep the log and report it"};
    const double damping = std::isfinite(command.damping_nm_s_rad) ? command.damping_nm_s_rad : 0.0;
    wanted = braking_torque(std::max(damping, kFallbackDamping), now_ns);
    diffusion_.reset();
  }
  wanted = std::clamp(wanted, -options_.torque_range_nm, options_.torque_range_nm);
  const std::optional<std::int16_t> permille =
      to_permille(diffusion_.next(wanted), units_.rated_nm,
                  static_cast<std::int16_t>(units_.max_torque_permille));
  if (!permille) {
    return {control_word::kEnableOperation, 0};
  }
  diffusion_.went(wanted, from_permille(*permille, units_.rated_nm));
  return {control_word::kEnableOperation, *permille};
}

TorqueCommand Driver::disabling() noexcept {
  if (!zero_sent_) {
    zero_sent_ = true;
    return {control_word::kEnableOperation, 0};
  }
  disable_sent_ = true;
  return kOff;
}

const DriveComplaint& Driver::complaint() const noexcept {
  return complaint_.quantity != nullptr ? complaint_ : start_up_.complaint();
}

std::vector<IdFilter> Driver::reply_ids() const {
  std::vector<IdFilter> ids = {{cob::kEmergency + node_},
                               {cob::kTransmit1 + node_},
                               {cob::kSdoReply + node_},
                               {cob::kHeartbeat + node_}};
  if (units_.rad_s_per_velocity > 0.0) {
    ids.push_back({cob::kTransmit2 + node_});
  }
  return ids;
}

std::vector<IdFilter> Driver::command_ids() const {
  std::vector<IdFilter> ids = {{cob::kNmt},
                               {cob::kSync},
                               {cob::kSdoRequest + node_},
                               {cob::kHeartbeat + integer(options_, Setting::kHostNode)}};
  for (std::uint32_t pdo = 0; pdo < 4; ++pdo) {
    ids.push_back({cob::kReceive1 + cob::kStep * pdo + node_});
  }
  return ids;
}

}  // namespace geodesic::drivers::cia402
