// The host's side of one Damiao drive; see driver.hpp for what it promises.
#include "drivers/damiao/driver.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace geodesic::drivers::damiao {

using control::DriveCondition;
using control::DriveMode;

namespace {

constexpr auto kDisabledStatus = static_cast<std::uint8_t>(Status::kDisabled);
constexpr auto kEnabledStatus = static_cast<std::uint8_t>(Status::kEnabled);

constexpr double kTorqueCodes = (1U << mit::kTorque.bits) - 1U;

}  // namespace

Driver::Driver(const DriveOptions& options)
    : options_(options),
      ranges_{options.position_range_rad, options.velocity_range_rad_s, options.torque_range_nm},
      diffusion_(options.error_diffusion, 2.0 * options.torque_range_nm / kTorqueCodes),
      start_up_(options) {}

void Driver::restart() noexcept {
  // The mode stays: a drive that was out does not come back because somebody restarted it.
  enable_due_ = false;
  complaint_ = {};
  begin_start_up();
}

void Driver::begin_start_up() noexcept {
  start_up_.restart();
  phase_ = Phase::kStartUp;
  update_condition();
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
        next_enable_ns_ = now_ns;
        phase_ = status_ == kDisabledStatus ? Phase::kEnabling : Phase::kOut;
      }
      break;
    case Phase::kEnabling:
    case Phase::kEnabled:
      if (!wanted) {
        phase_ = Phase::kDisabling;
        zero_sent_ = false;
        disable_sent_ = false;
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

std::size_t Driver::transmit(const DriveCommand& command, std::int64_t now_ns,
                             std::span<Frame> out) noexcept {
  if (out.empty()) {
    return 0;
  }
  follow(command.mode, now_ns);
  if (phase_ != Phase::kEnabled) {
    diffusion_.reset();
  }
  switch (phase_) {
    case Phase::kStartUp: {
      const bool sent = start_up_.transmit(now_ns, out[0]);
      if (start_up_.refused()) {
        phase_ = Phase::kRefused;
        update_condition();
      }
      return sent ? 1 : 0;
    }
    case Phase::kEnabling:
      out[0] = enabling_frame(now_ns);
      return 1;
    case Phase::kEnabled:
      out[0] = torque_frame(command);
      return 1;
    case Phase::kDisabling:
      out[0] = disabling_frame();
      return 1;
    case Phase::kIdle:
    case Phase::kOut:
    case Phase::kRefused:
      break;
  }
  // A drive we have not enabled, yet is: somebody else's doing, or it slept through our disable.
  out[0] = status_ == kEnabledStatus ? encode_special(options_.id, options_.fd, Special::kDisable)
                                     : encode_state_request(options_.id, options_.fd);
  return 1;
}

Frame Driver::enabling_frame(std::int64_t now_ns) noexcept {
  if (now_ns < next_enable_ns_) {
    return brake_frame(0.0);
  }
  if (enables_ == kMaxEnables) {
    complaint_ = {"status after the enable command", static_cast<double>(status_),
                  static_cast<double>(kEnabledStatus), "check the drive's supply and firmware"};
    phase_ = Phase::kOut;
    update_condition();
    return encode_special(options_.id, options_.fd, Special::kDisable);
  }
  ++enables_;
  next_enable_ns_ = now_ns + kEnableIntervalNs;
  return encode_special(options_.id, options_.fd, Special::kEnable);
}

Frame Driver::disabling_frame() noexcept {
  if (!zero_sent_) {
    zero_sent_ = true;
    return brake_frame(0.0);
  }
  disable_sent_ = true;
  return encode_special(options_.id, options_.fd, Special::kDisable);
}

Frame Driver::brake_frame(double damping) const noexcept {
  return encode_mit(options_.id, options_.fd, {.damping_nm_s_rad = damping}, ranges_)
      .value_or(encode_special(options_.id, options_.fd, Special::kDisable));
}

Frame Driver::torque_frame(const DriveCommand& command) noexcept {
  if (is_finite(command)) {
    const MitCommand mit{.position_rad = command.position_rad - wraps_ * 2.0 * ranges_.position_rad,
                         .velocity_rad_s = command.velocity_rad_s,
                         .stiffness_nm_rad = command.stiffness_nm_rad,
                         .damping_nm_s_rad = command.damping_nm_s_rad,
                         .torque_nm = command.torque_nm};
    if (options_.error_diffusion) {
      return diffused_frame(mit);
    }
    return encode_mit(options_.id, options_.fd, mit, ranges_)
        .value_or(encode_special(options_.id, options_.fd, Special::kDisable));
  }
  complaint_ = {"command (torque, position, velocity, stiffness or damping)",
                std::numeric_limits<double>::quiet_NaN(), 0.0,
                "the controller's numbers are not finite: keep the log and report it"};
  diffusion_.reset();
  const double damping = std::isfinite(command.damping_nm_s_rad) ? command.damping_nm_s_rad : 0.0;
  return brake_frame(std::max(damping, kFallbackDamping));
}

Frame Driver::diffused_frame(MitCommand command) noexcept {
  const double wanted = std::clamp(command.torque_nm, -ranges_.torque_nm, ranges_.torque_nm);
  command.torque_nm = diffusion_.next(wanted);
  const std::optional<Frame> frame = encode_mit(options_.id, options_.fd, command, ranges_);
  if (!frame) {
    return encode_special(options_.id, options_.fd, Special::kDisable);
  }
  diffusion_.went(wanted, from_code(extract(*frame, mit::kTorque), -ranges_.torque_nm,
                                    ranges_.torque_nm, mit::kTorque.bits));
  return *frame;
}

bool Driver::receive(const ReceivedFrame& received) noexcept {
  const Frame& frame = received.frame;
  if (frame.error || frame.extended || frame.id != options_.reply_id) {
    return false;
  }
  if (start_up_.receive_register(received)) {
    if (start_up_.refused()) {
      phase_ = Phase::kRefused;
    }
    last_heard_ns_ = received.stamp_ns;
    update_condition();
    return false;
  }
  const std::optional<StateReport> report = decode_report(frame, ranges_);
  if (!report || report->motor != (options_.id & 0xFU)) {
    return false;
  }
  if (received.stamp_ns - last_heard_ns_ > kForgetNs) {
    counting_ = false;  // it may have been off, and has forgotten the turns itself
  }
  last_heard_ns_ = received.stamp_ns;
  take_status(report->status);
  const bool meaningful = start_up_.ranges_verified() && phase_ != Phase::kRefused;
  if (meaningful) {
    state_.position_rad = unwrapped(report->position_rad);
    state_.velocity_rad_s = report->velocity_rad_s;
    state_.torque_nm = report->torque_nm;
    state_.temperature_c = std::max(report->mosfet_c, report->rotor_c);
    state_.stamp_ns = received.stamp_ns;
  }
  update_condition();
  return meaningful;
}

double Driver::unwrapped(double reported_rad) noexcept {
  const double step = reported_rad - reported_rad_;
  if (!counting_) {
    wraps_ = 0.0;
  } else if (std::abs(step) > ranges_.position_rad) {
    wraps_ -= std::copysign(1.0, step);
  }
  counting_ = true;
  reported_rad_ = reported_rad;
  return reported_rad + wraps_ * 2.0 * ranges_.position_rad;
}

void Driver::take_status(std::uint8_t status) noexcept {
  status_ = status;
  switch (phase_) {
    case Phase::kStartUp:
      start_up_.receive_status(status);
      if (start_up_.done()) {
        phase_ = Phase::kIdle;
      }
      break;
    case Phase::kEnabling:
      if (status == kEnabledStatus) {
        phase_ = Phase::kEnabled;
      } else if (status != kDisabledStatus) {
        phase_ = Phase::kOut;
      }
      break;
    case Phase::kEnabled:
      if (status != kEnabledStatus) {
        phase_ = Phase::kOut;
      }
      break;
    case Phase::kDisabling:
      if (disable_sent_ && status != kEnabledStatus) {
        phase_ = Phase::kIdle;
      }
      break;
    case Phase::kIdle:
    case Phase::kOut:
    case Phase::kRefused:
      break;
  }
}

void Driver::update_condition() noexcept {
  const bool error = status_ != kDisabledStatus && status_ != kEnabledStatus;
  state_.error = error && start_up_.heard() ? status_ : std::uint8_t{0};
  if (phase_ == Phase::kRefused) {
    state_.condition = DriveCondition::kRefused;
  } else if (!start_up_.heard()) {
    state_.condition = DriveCondition::kUnknown;
  } else if (phase_ == Phase::kStartUp) {
    state_.condition =
        start_up_.held_by_error() ? DriveCondition::kError : DriveCondition::kConfiguring;
  } else if (error) {
    state_.condition = DriveCondition::kError;
  } else if (status_ == kEnabledStatus && phase_ != Phase::kOut) {
    state_.condition = DriveCondition::kEnabled;
  } else {
    // Out and enabled by somebody else: it does not follow our torque, and is being disabled.
    state_.condition = DriveCondition::kDisabled;
  }
}

const DriveComplaint& Driver::complaint() const noexcept {
  return complaint_.quantity != nullptr ? complaint_ : start_up_.complaint();
}

std::vector<IdFilter> Driver::reply_ids() const {
  return {{options_.reply_id, false}};
}

std::vector<IdFilter> Driver::command_ids() const {
  return {{command_id(options_.id, ControlMode::kMit), false},
          {command_id(options_.id, ControlMode::kPositionVelocity), false},
          {command_id(options_.id, ControlMode::kVelocity), false},
          {command_id(options_.id, ControlMode::kPositionForce), false},
          {kRegisterId, false}};
}

}  // namespace geodesic::drivers::damiao
