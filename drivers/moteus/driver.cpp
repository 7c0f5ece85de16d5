// The host's side of one moteus drive; see driver.hpp for what it promises.
#include "drivers/moteus/driver.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "drivers/moteus/settings.hpp"

namespace geodesic::drivers::moteus {

using control::DriveCondition;
using control::DriveMode;

namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr double kMostRev = 32768.0;  ///< the drive counts no further
/// Shares of what 16 bits hold, so that what is measured does not stand at their end.
constexpr double kMost16BitRev = 3.2;
constexpr double kMost16BitRevS = 8.0;
constexpr double kMost16BitNm = 320.0;
constexpr double kTorqueStepNm = 0.01;
constexpr double kFineTorqueStepNm = 0.001;
constexpr auto kPositionMode = static_cast<std::uint8_t>(Mode::kPosition);
constexpr auto kStoppedMode = static_cast<std::uint8_t>(Mode::kStopped);

double step_of(const Formats& formats) noexcept {
  return formats.torque == Resolution::kInt16
             ? kTorqueStepNm
             : (formats.torque == Resolution::kInt32 ? kFineTorqueStepNm : 0.0);
}

/// What the drive makes of `wanted`, as a scale of what it has; the rest is made here.
double scale_of(double wanted, double whole) noexcept {
  return whole > 0.0 ? std::clamp(wanted / whole, 0.0, 1.0) : 0.0;
}

}  // namespace

Formats formats_for(const DriveOptions& options) noexcept {
  if (setting(options, kResolution) != 0.0) {
    return {};
  }
  const auto by = [](double range, double most) {
    return range > 0.0 && range <= most ? Resolution::kInt16 : Resolution::kInt32;
  };
  return {.position = by(options.position_range_rad, kMost16BitRev * kTurn),
          .velocity = by(options.velocity_range_rad_s, kMost16BitRevS * kTurn),
          .torque = by(options.torque_range_nm, kMost16BitNm),
          .scale = Resolution::kInt16,
          .voltage = false};
}

Link link_for(const DriveOptions& options) noexcept {
  return {whole_setting(options, kHostId), options.id, whole_setting(options, kPrefix)};
}

Driver::Driver(const DriveOptions& options)
    : options_(options),
      link_(link_for(options)),
      formats_(formats_for(options)),
      kp_nm_rad_(setting(options, kKp) / kTurn),
      kd_nm_s_rad_(setting(options, kKd) / kTurn),
      start_up_(options, link_, formats_),
      diffusion_(options.error_diffusion, step_of(formats_)) {}

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

void Driver::leave() noexcept {
  phase_ = Phase::kOut;
  diffusion_.reset();
}

void Driver::follow(DriveMode mode, std::int64_t now_ns) noexcept {
  const bool wanted = mode == DriveMode::kEnable;
  enable_due_ = wanted && (enable_due_ || mode_ != DriveMode::kEnable);
  mode_ = mode;
  const bool silent = now_ns - last_heard_ns_ > kForgetNs;
  switch (phase_) {
    case Phase::kIdle:
      if (silent) {
        begin_start_up();
      } else if (enable_due_) {
        enable_due_ = false;
        enable_until_ns_ = now_ns + kEnableNs;
        diffusion_.reset();
        phase_ = told_ == kStoppedMode ? Phase::kEnabling : Phase::kOut;
      }
      break;
    case Phase::kEnabling:
    case Phase::kEnabled:
      if (!wanted) {
        phase_ = Phase::kDisabling;
        diffusion_.reset();
        zero_sent_ = false;
        stop_sent_ = false;
      } else if (phase_ == Phase::kEnabled && silent) {
        told_ = kStoppedMode;  // nobody knows; it may have been off, and our frame would start it
        leave();               // the condition stays what it was told to be until it speaks again
      } else if (phase_ == Phase::kEnabling && now_ns >= enable_until_ns_) {
        complaint_ = {"mode (register 0x000) after the command for position mode",
                      static_cast<double>(told_), static_cast<double>(kPositionMode),
                      "check the drive's supply, calibration and firmware"};
        leave();
        update_condition();
      }
      break;
    case Phase::kOut:
      // kDisable leaves the drive as it is, so that its fault can still be read.
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
      out[0] = position_frame({}, now_ns);
      return 1;
    case Phase::kEnabled:
      out[0] = torque_frame(command, now_ns);
      return 1;
    case Phase::kDisabling:
      out[0] = disabling_frame(now_ns);
      return 1;
    case Phase::kIdle:
    case Phase::kOut:
    case Phase::kRefused:
      break;
  }
  // A drive that runs though we have not told it: somebody else's doing, or it missed our stop.
  out[0] = is_running(told_) ? encode_stop(link_, formats_) : encode_query(link_, formats_);
  return 1;
}

Frame Driver::disabling_frame(std::int64_t now_ns) noexcept {
  if (!zero_sent_) {
    zero_sent_ = true;
    return position_frame({}, now_ns);
  }
  stop_sent_ = true;
  return encode_stop(link_, formats_);
}

Frame Driver::torque_frame(const DriveCommand& command, std::int64_t now_ns) noexcept {
  if (is_finite(command)) {
    return position_frame(command, now_ns);
  }
  complaint_ = {"command (torque, position, velocity, stiffness or damping)",
                std::numeric_limits<double>::quiet_NaN(), 0.0,
                "the controller's numbers are not finite: keep the log and report it"};
  diffusion_.reset();
  const double damping = std::isfinite(command.damping_nm_s_rad) ? command.damping_nm_s_rad : 0.0;
  return position_frame({.damping_nm_s_rad = std::max(damping, kFallbackDamping)}, now_ns);
}

Frame Driver::position_frame(const DriveCommand& command, std::int64_t now_ns) noexcept {
  const double kp_scale = scale_of(command.stiffness_nm_rad, kp_nm_rad_);
  const double kd_scale = scale_of(command.damping_nm_s_rad, kd_nm_s_rad_);
  double wanted_nm = command.torque_nm;
  if (now_ns - state_.stamp_ns < kFreshNs) {
    const double stiffness = std::max(command.stiffness_nm_rad, 0.0) - kp_scale * kp_nm_rad_;
    const double damping = std::max(command.damping_nm_s_rad, 0.0) - kd_scale * kd_nm_s_rad_;
    wanted_nm += stiffness * (command.position_rad - state_.position_rad) +
                 damping * (command.velocity_rad_s - state_.velocity_rad_s);
  }
  const double range_nm = options_.torque_range_nm;
  wanted_nm = std::clamp(wanted_nm, -range_nm, range_nm);
  PositionCommand position;
  position.torque_nm = std::clamp(diffusion_.next(wanted_nm), -range_nm, range_nm);
  position.kp_scale = kp_scale;
  position.kd_scale = kd_scale;
  position.max_torque_nm = range_nm;
  position.watchdog_ns = options_.watchdog_ns;
  if (kp_scale > 0.0) {
    position.position_rev = std::clamp(command.position_rad / kTurn, -kMostRev, kMostRev);
  }
  if (kd_scale > 0.0) {
    position.velocity_rev_s = std::clamp(command.velocity_rad_s, -options_.velocity_range_rad_s,
                                         options_.velocity_range_rad_s) /
                              kTurn;
  }
  if (formats_.torque != Resolution::kFloat) {
    diffusion_.went(wanted_nm,
                    from_code(to_code(position.torque_nm, Quantity::kTorque, formats_.torque),
                              Quantity::kTorque, formats_.torque));
  }
  return encode_position(link_, formats_, position, phase_ == Phase::kEnabling)
      .value_or(encode_stop(link_, formats_));
}

bool Driver::receive(const ReceivedFrame& received) noexcept {
  const Frame& frame = received.frame;
  if (frame.error || frame.remote || frame.id != to_id(link_.reply())) {
    return false;
  }
  const StateReport report = decode_report(frame);
  last_heard_ns_ = received.stamp_ns;
  if (phase_ == Phase::kStartUp) {
    start_up_.receive(frame, report);
    if (start_up_.refused()) {
      phase_ = Phase::kRefused;
    }
  }
  const bool meaningful = report.mode && take_measures(report, received.stamp_ns);
  if (report.mode) {
    take_mode(report, frame);
  }
  update_condition();
  return meaningful;
}

bool Driver::take_measures(const StateReport& report, std::int64_t stamp_ns) noexcept {
  if (!start_up_.verified() || phase_ == Phase::kRefused) {
    return false;
  }
  const double position = report.position_rev.value_or(std::nan(""));
  const double velocity = report.velocity_rev_s.value_or(std::nan(""));
  const double torque = report.torque_nm.value_or(std::nan(""));
  if (!(std::abs(position) <= kMostRev) || !std::isfinite(velocity) || !std::isfinite(torque)) {
    complaint_ = {"position, velocity or torque (registers 0x001 to 0x003)", position, 0.0,
                  "the drive has no valid encoder reading: check its encoder and calibration"};
    return false;
  }
  if (report.saturated) {
    complaint_ = {"position or velocity at the end of 16 bits [rev]", position, 0.0,
                  "correct position_range_rad and velocity_range_rad_s, or take resolution "
                  "\"float\""};
    return false;
  }
  state_.position_rad = position * kTurn;
  state_.velocity_rad_s = velocity * kTurn;
  state_.torque_nm = torque;
  const double board = report.temperature_c.value_or(std::nan(""));
  const double hottest = std::fmax(board, report.motor_c.value_or(std::nan("")));
  state_.temperature_c = std::isfinite(hottest) ? hottest : state_.temperature_c;
  state_.stamp_ns = stamp_ns;
  return true;
}

bool Driver::read_back(const Frame& reply) noexcept {
  bool torque = false;
  bool watchdog = false;
  Reader reader(reply);
  for (Entry entry; reader.next(entry);) {
    if (entry.kind == opcode::kWriteError) {
      complaint_ = {"register that the drive does not take", static_cast<double>(entry.number), 0.0,
                    "update the drive's firmware"};
      phase_ = Phase::kRefused;
      return false;
    }
    const auto number = static_cast<Register>(entry.number);
    if (entry.kind != opcode::kReply ||
        (number != Register::kCommandMaxTorque && number != Register::kCommandTimeout)) {
      continue;
    }
    const bool of_torque = number == Register::kCommandMaxTorque;
    const double expected = of_torque ? options_.torque_range_nm : watchdog_s(options_.watchdog_ns);
    const double step = of_torque ? step_of(formats_) : 1e-4;
    if (!(std::abs(entry.value - expected) <= 1e-5 * expected + step)) {
      complaint_ = {of_torque ? "maximum torque (register 0x025) [N·m]"
                              : "watchdog timeout (register 0x027) [s]",
                    entry.value, expected, "the drive does not take it: check its firmware"};
      phase_ = Phase::kRefused;
      return false;
    }
    torque = torque || of_torque;
    watchdog = watchdog || !of_torque;
  }
  return torque && watchdog;
}

void Driver::take_mode(const StateReport& report, const Frame& reply) noexcept {
  told_ = *report.mode;
  fault_ = report.fault.value_or(0);
  switch (phase_) {
    case Phase::kStartUp:
      if (start_up_.done()) {
        phase_ = Phase::kIdle;
      }
      break;
    case Phase::kEnabling:
      if (is_error(told_)) {
        leave();
      } else if (read_back(reply) && told_ == kPositionMode) {
        phase_ = Phase::kEnabled;
      }
      break;
    case Phase::kEnabled:
      if (told_ != kPositionMode) {
        leave();
      }
      break;
    case Phase::kDisabling:
      if (is_error(told_) && !stop_sent_) {
        leave();  // its fault is to be read, and a stop would clear it
      } else if (stop_sent_ && !is_running(told_)) {
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
  const bool error = is_error(told_) && start_up_.heard();
  state_.error = error ? error_of(told_, fault_) : std::uint8_t{0};
  if (phase_ == Phase::kRefused) {
    state_.condition = DriveCondition::kRefused;
  } else if (!start_up_.heard()) {
    state_.condition = DriveCondition::kUnknown;
  } else if (phase_ == Phase::kStartUp) {
    state_.condition =
        start_up_.held_by_error() ? DriveCondition::kError : DriveCondition::kConfiguring;
  } else if (error) {
    state_.condition = DriveCondition::kError;
  } else if (phase_ == Phase::kEnabled || (phase_ == Phase::kDisabling && told_ == kPositionMode)) {
    state_.condition = DriveCondition::kEnabled;
  } else {
    // Out and made to run by somebody else: it does not follow our torque, and is being stopped.
    state_.condition = DriveCondition::kDisabled;
  }
}

const DriveComplaint& Driver::complaint() const noexcept {
  return complaint_.quantity != nullptr ? complaint_ : start_up_.complaint();
}

std::vector<IdFilter> Driver::reply_ids() const {
  const std::uint32_t id = to_id(link_.reply());
  return {{id, id > kLastStandardId}};
}

std::vector<IdFilter> Driver::command_ids() const {
  // From whatever source, with or without a wish for a reply; in a short frame too.
  constexpr std::uint32_t kDestination = 0xFF;
  constexpr std::uint32_t kPrefixBits = kLastPrefix << kPrefixShift;
  std::vector<IdFilter> ids = {
      {link_.prefix << kPrefixShift | link_.drive, true, kPrefixBits | kDestination}};
  if (link_.prefix == 0) {
    ids.push_back({link_.drive, false, kDestination});
  }
  return ids;
}

}  // namespace geodesic::drivers::moteus
