// The host's side of one RobStride or CyberGear drive; see driver.hpp for what it promises.
#include "drivers/robstride/driver.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "drivers/robstride/settings.hpp"

namespace geodesic::drivers::robstride {

using control::DriveCondition;
using control::DriveMode;

namespace {

constexpr auto kRun = static_cast<std::uint8_t>(Mode::kRun);
/// Motor and host as they are, the type, and 8 bits between that say how it is.
constexpr std::uint32_t kReplyMask = kTypeMask | 0xFFFFU;

}  // namespace

Driver::Driver(const DriveOptions& options)
    : options_(options),
      link_(robstride::link_of(options)),
      ranges_(ranges_of(options)),
      wraps_around_(wraps(options.position_range_rad)),
      start_up_(options),
      diffusion_(options.error_diffusion, 2.0 * options.torque_range_nm / 65535.0) {}

void Driver::restart() noexcept {
  // The mode stays: a drive that was out does not come back because somebody restarted it.
  enable_due_ = false;
  complaint_ = {};
  begin_start_up();
}

void Driver::begin_start_up() noexcept {
  start_up_.restart();
  phase_ = Phase::kStartUp;
  latched_ = 0;
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
        phase_ = faults_ == 0 ? Phase::kEnabling : Phase::kOut;
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
  if (out.size() < 2) {
    return 0;
  }
  follow(command.mode, now_ns);
  if (phase_ != Phase::kEnabled) {
    diffusion_.reset();
  }
  switch (phase_) {
    case Phase::kStartUp: {
      const std::size_t count = start_up_.transmit(now_ns, out);
      if (start_up_.refused()) {
        phase_ = Phase::kRefused;
        update_condition();
      }
      return count;
    }
    case Phase::kEnabling:
      return enabling_frames(now_ns, out);
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
  // A stop brings feedback, and a drive that we have not enabled has nothing to lose by it.
  out[0] = encode_stop(link_, false);
  return 1;
}

std::size_t Driver::answers_due(std::size_t frames) const noexcept {
  return phase_ == Phase::kStartUp ? start_up_.answers_due(frames) : frames;
}

std::size_t Driver::enabling_frames(std::int64_t now_ns, std::span<Frame> out) noexcept {
  // Whatever command a drive may still hold from before, it runs with none.
  out[0] = brake_frame(0.0);
  if (now_ns < next_enable_ns_) {
    return 1;
  }
  if (enables_ == kMaxEnables) {
    complaint_ = {"mode after the enable command", static_cast<double>(drive_mode_),
                  static_cast<double>(kRun), "check the drive's supply and firmware"};
    phase_ = Phase::kOut;
    update_condition();
    out[0] = encode_stop(link_, false);
    return 1;
  }
  ++enables_;
  next_enable_ns_ = now_ns + kEnableIntervalNs;
  out[1] = encode_enable(link_);
  return 2;
}

Frame Driver::disabling_frame() noexcept {
  if (!zero_sent_) {
    zero_sent_ = true;
    return brake_frame(0.0);
  }
  disable_sent_ = true;
  return encode_stop(link_, false);
}

Frame Driver::brake_frame(double damping) const noexcept {
  return encode_control(link_.motor, {.damping_nm_s_rad = damping}, ranges_)
      .value_or(encode_stop(link_, false));
}

Frame Driver::torque_frame(const DriveCommand& command) noexcept {
  if (is_finite(command)) {
    const ControlCommand wanted{.position_rad = command.position_rad - turns_ * kWrapRad,
                                .velocity_rad_s = command.velocity_rad_s,
                                .stiffness_nm_rad = command.stiffness_nm_rad,
                                .damping_nm_s_rad = command.damping_nm_s_rad,
                                .torque_nm = diffusion_.next(command.torque_nm)};
    const Frame frame =
        encode_control(link_.motor, wanted, ranges_).value_or(encode_stop(link_, false));
    if (options_.error_diffusion) {
      const auto sent = decode_control(frame, ranges_);
      diffusion_.went(command.torque_nm, sent ? sent->torque_nm : command.torque_nm);
    }
    return frame;
  }
  complaint_ = {"command (torque, position, velocity, stiffness or damping)",
                std::numeric_limits<double>::quiet_NaN(), 0.0,
                "the controller's numbers are not finite: keep the log and report it"};
  diffusion_.reset();
  const double damping = std::isfinite(command.damping_nm_s_rad) ? command.damping_nm_s_rad : 0.0;
  return brake_frame(std::max(damping, kFallbackDamping));
}

bool Driver::receive(const ReceivedFrame& received) noexcept {
  const Frame& frame = received.frame;
  if (frame.error || !frame.extended || frame.fd || frame.remote) {
    return false;
  }
  const auto ours = [this](const Link& link) {
    return link.motor == link_.motor && link.host == link_.host;
  };
  bool report = false;
  if (const auto identity = decode_identity(frame); identity == link_.motor) {
    take_identity();
  } else if (const auto answer = decode_parameter(frame); answer && ours(answer->link)) {
    last_heard_ns_ = received.stamp_ns;
    start_up_.receive_parameter(*answer);
  } else if (const auto fault = decode_fault_report(frame); fault && ours(fault->link)) {
    take_faults(*fault);
  } else {
    report = take_feedback(received);
  }
  if (start_up_.refused()) {
    phase_ = Phase::kRefused;
  }
  update_condition();
  return report;
}

bool Driver::take_feedback(const ReceivedFrame& received) noexcept {
  const std::optional<Feedback> feedback = decode_feedback(received.frame, ranges_);
  if (!feedback || feedback->link.motor != link_.motor || feedback->link.host != link_.host) {
    return false;
  }
  if (received.stamp_ns - last_heard_ns_ > kForgetNs) {
    counting_ = false;  // it may have been off, and has forgotten the turns itself
  }
  last_heard_ns_ = received.stamp_ns;
  const bool version = start_up_.receive_version(received);
  if (!version) {
    take_mode(feedback->mode, feedback->faults);
    if (phase_ == Phase::kStartUp) {
      start_up_.receive_feedback(*feedback);
      phase_ = start_up_.done() ? Phase::kIdle : phase_;
    }
  }
  // Without wrapping, the last code stands for everything beyond it.
  if (version || !start_up_.ranges_verified() || phase_ == Phase::kRefused ||
      (feedback->at_end && !wraps_around_)) {
    return false;
  }
  state_.position_rad = unwrapped(feedback->position_rad);
  state_.velocity_rad_s = feedback->velocity_rad_s;
  state_.torque_nm = feedback->torque_nm;
  state_.temperature_c = feedback->temperature_c;
  state_.stamp_ns = received.stamp_ns;
  return true;
}

double Driver::unwrapped(double reported_rad) noexcept {
  const double step = reported_rad - reported_rad_;
  if (!counting_) {
    turns_ = 0.0;
  } else if (wraps_around_ && std::abs(step) > 0.5 * kWrapRad) {
    turns_ -= std::copysign(1.0, step);
  }
  counting_ = true;
  reported_rad_ = reported_rad;
  return reported_rad + turns_ * kWrapRad;
}

void Driver::go_out(std::uint8_t error) noexcept {
  if (phase_ == Phase::kEnabling || phase_ == Phase::kEnabled || phase_ == Phase::kDisabling) {
    phase_ = Phase::kOut;
    latched_ = error;
  }
}

void Driver::take_faults(const FaultReport& report) noexcept {
  if (report.faults != 0 && phase_ == Phase::kIdle) {
    begin_start_up();
  } else if (report.faults != 0) {
    go_out(static_cast<std::uint8_t>(kFirstReported + std::countr_zero(report.faults)));
  }
}

void Driver::take_identity() noexcept {
  counting_ = false;
  drive_mode_ = 0;
  faults_ = 0;
  if (phase_ == Phase::kIdle) {
    begin_start_up();  // its watchdog is off again
  } else if (phase_ == Phase::kStartUp) {
    start_up_.receive_identity();
  } else {
    go_out(kRebooted);
  }
}

void Driver::take_mode(std::uint8_t mode, std::uint8_t faults) noexcept {
  drive_mode_ = mode;
  faults_ = faults;
  const bool runs = mode == kRun && faults == 0;
  const auto error = static_cast<std::uint8_t>(std::countr_zero(faults) + 1);
  switch (phase_) {
    case Phase::kEnabling:
      if (runs) {
        phase_ = Phase::kEnabled;
      } else if (faults != 0) {
        go_out(error);
      }
      break;
    case Phase::kEnabled:
      if (!runs) {
        go_out(faults != 0 ? error : kLeftRunMode);
      }
      break;
    case Phase::kDisabling:
      if (disable_sent_ && mode != kRun) {
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

void Driver::update_condition() noexcept {
  const bool told = start_up_.heard() && faults_ != 0;
  state_.error = told ? static_cast<std::uint8_t>(std::countr_zero(faults_) + 1) : latched_;
  if (phase_ == Phase::kRefused) {
    state_.condition = DriveCondition::kRefused;
  } else if (!start_up_.heard()) {
    state_.condition = DriveCondition::kUnknown;
  } else if (phase_ == Phase::kStartUp) {
    state_.condition =
        start_up_.held_by_error() ? DriveCondition::kError : DriveCondition::kConfiguring;
  } else if (state_.error != 0) {
    state_.condition = DriveCondition::kError;
  } else if (drive_mode_ == kRun && phase_ != Phase::kOut) {
    state_.condition = DriveCondition::kEnabled;
  } else {
    // Out and run by somebody else: it does not follow our torque, and is being stopped.
    state_.condition = DriveCondition::kDisabled;
  }
}

const DriveComplaint& Driver::complaint() const noexcept {
  return complaint_.quantity != nullptr ? complaint_ : start_up_.complaint();
}

std::vector<IdFilter> Driver::reply_ids() const {
  const auto told_by = [this](Type type) {
    return IdFilter{identifier(type, link_.motor, link_.host), true, kReplyMask};
  };
  return {told_by(Type::kFeedback), told_by(Type::kRead), told_by(Type::kFault),
          IdFilter{identifier(Type::kGetId, link_.motor, kIdentityDestination), true}};
}

std::vector<IdFilter> Driver::command_ids() const {
  std::vector<IdFilter> ids;
  for (const Type type :
       {Type::kControl, Type::kEnable, Type::kStop, Type::kZero, Type::kSetId, Type::kRead,
        Type::kWrite, Type::kSave, Type::kBitRate, Type::kReport, Type::kProtocol}) {
    ids.push_back({identifier(type, 0, link_.motor), true, kTypeMask | kDestinationMask});
  }
  return ids;
}

}  // namespace geodesic::drivers::robstride
