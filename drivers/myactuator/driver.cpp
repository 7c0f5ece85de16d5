// The half of a MyActuator driver that commands: phases and frames. See driver.hpp for what it
// promises; listening is in driver_replies.cpp.
#include "drivers/myactuator/driver.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace geodesic::drivers::myactuator {

using control::DriveMode;

namespace {

double step_of(double range, unsigned bits) noexcept {
  return 2.0 * range / static_cast<double>((1U << bits) - 1U);
}

}  // namespace

Driver::Driver(const DriveOptions& options)
    : options_(options),
      facts_(options),
      ranges_(ranges_of(options)),
      start_up_(options),
      velocity_check_(facts_.motion, step_of(options.velocity_range_rad_s, motion::kVelocity.bits)),
      diffusion_(options.error_diffusion && facts_.motion,
                 step_of(options.torque_range_nm, motion::kTorque.bits)) {}

void Driver::restart() noexcept {
  // The mode stays: a drive that was out does not come back because somebody restarted it.
  enable_due_ = false;
  begin_start_up();
}

void Driver::begin_start_up() noexcept {
  complaint_ = {};
  start_up_.restart();
  velocity_check_.restart();
  bare_reply_ = false;
  bare_angle_ = false;
  errors_ = 0;
  phase_ = Phase::kStartUp;
  update_condition();
}

void Driver::fall_out(const DriveComplaint& complaint) noexcept {
  complaint_ = complaint;
  phase_ = Phase::kOut;
  shutdowns_ = kShutdowns;
  diffusion_.reset();
}

void Driver::follow(DriveMode mode, std::int64_t now_ns) noexcept {
  const bool wanted = mode == DriveMode::kEnable;
  enable_due_ = wanted && (enable_due_ || mode_ != DriveMode::kEnable);
  mode_ = mode;
  const double limit_s = static_cast<double>(options_.watchdog_ns) * 1e-9;
  if (following() && now_ns - last_transmit_ns_ > options_.watchdog_ns) {
    fall_out({"time between two commands to the drive [s]",
              static_cast<double>(now_ns - last_transmit_ns_) * 1e-9, limit_s,
              "the drive's watchdog has ended its torque: find what held this host up"});
  } else if (phase_ == Phase::kEnabled && now_ns - last_heard_ns_ > options_.watchdog_ns) {
    fall_out({"silence of the drive [s]", static_cast<double>(now_ns - last_heard_ns_) * 1e-9,
              limit_s, "check the drive's supply, its cable and the bus' termination"});
  }
  last_transmit_ns_ = now_ns;
  switch (phase_) {
    case Phase::kIdle:
      if (now_ns - last_heard_ns_ > kForgetNs) {
        begin_start_up();
      } else if (enable_due_) {
        enable_due_ = false;
        enables_ = 0;
        torque_answered_ = false;
        status_heard_ = false;
        brake_released_ = false;
        bare_reply_ = false;
        next_enable_ns_ = now_ns + own_share_of(kEnableIntervalNs);
        diffusion_.reset();
        phase_ = errors_ == 0 ? Phase::kEnabling : Phase::kOut;
      }
      break;
    case Phase::kEnabling:
    case Phase::kEnabled:
      if (!wanted) {
        phase_ = Phase::kDisabling;
        zero_sent_ = false;
        disable_sent_ = false;
        shutdowns_ = 2;
        diffusion_.reset();
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
  if (out.size() < kMaxFramesPerCycle) {
    return 0;
  }
  follow(command.mode, now_ns);
  std::size_t count = 0;
  switch (phase_) {
    case Phase::kStartUp:
      count = start_up_frames(now_ns, out);
      phase_ = start_up_.refused() ? Phase::kRefused : phase_;
      break;
    case Phase::kEnabling:
      count = enabling_frames(now_ns, out);
      break;
    case Phase::kEnabled:
      count = enabled_frames(command, now_ns, out);
      break;
    case Phase::kDisabling:
      count = disabling_frames(out);
      break;
    case Phase::kIdle:
    case Phase::kOut:
    case Phase::kRefused:
      count = asking_frames(now_ns, out);
      break;
  }
  update_condition();
  return count;
}

std::size_t Driver::start_up_frames(std::int64_t now_ns, std::span<Frame> out) noexcept {
  const bool heard = start_up_.heard();
  if (!start_up_.transmit(now_ns, out[0])) {
    return 0;
  }
  if (heard) {
    return 1;
  }
  // Whatever the drive does again when somebody speaks to it ends with the second frame.
  out[2] = out[0];
  out[0] = out[1] = request(Command::kShutdown);
  return 3;
}

std::size_t Driver::enabling_frames(std::int64_t now_ns, std::span<Frame> out) noexcept {
  std::size_t count = 0;
  if (now_ns >= next_enable_ns_) {
    if (enables_ == kMaxEnables) {
      fall_out({facts_.brake ? "answers to zero torque and the brake's release"
                             : "answers to zero torque",
                0.0, 1.0, "check the drive's supply, its cable and whether it has a brake"});
      return asking_frames(now_ns, out);
    }
    ++enables_;
    next_enable_ns_ = now_ns + kEnableIntervalNs;
    if (facts_.brake) {
      // The current loop does not release it; what it held hangs free until the next command.
      out[count++] = request(Command::kReleaseBrake);
    }
    out[count++] = request(Command::kStatus1);
  }
  out[count++] = last_torque_ = zero_frame();
  if (!facts_.motion) {
    out[count++] = request(Command::kAngle);
  }
  return count;
}

std::size_t Driver::enabled_frames(const DriveCommand& command, std::int64_t now_ns,
                                   std::span<Frame> out) noexcept {
  std::size_t count = 0;
  out[count++] = last_torque_ = torque_frame(command);
  if (!facts_.motion) {
    out[count++] = request(Command::kAngle);
  }
  return count + status_frame(now_ns, out.subspan(count));
}

std::int64_t Driver::own_share_of(std::int64_t interval_ns) const noexcept {
  constexpr double kGolden = 0.6180339887498949;  // neighbouring ids come to lie far apart
  const double share = kGolden * static_cast<double>(options_.id);
  return std::llround((share - std::floor(share)) * static_cast<double>(interval_ns));
}

std::size_t Driver::status_frame(std::int64_t now_ns, std::span<Frame> out) noexcept {
  if (now_ns < next_status_ns_) {
    return 0;
  }
  // Not all drives of a bus in the same cycle: there is not room for as many frames more.
  const std::int64_t since = (now_ns - own_share_of(kStatusIntervalNs)) % kStatusIntervalNs;
  next_status_ns_ = now_ns - since + kStatusIntervalNs;
  last_status_ns_ = now_ns;
  out[0] = request(Command::kStatus1);
  return 1;
}

std::size_t Driver::disabling_frames(std::span<Frame> out) noexcept {
  std::size_t count = 0;
  if (!zero_sent_) {
    zero_sent_ = true;
    if (facts_.brake) {
      out[count++] = request(Command::kLockBrake);
    }
    out[count++] = last_torque_ = zero_frame();
    return count;
  }
  disable_sent_ = true;
  out[0] = out[1] = request(Command::kShutdown);
  return 2;
}

std::size_t Driver::asking_frames(std::int64_t now_ns, std::span<Frame> out) noexcept {
  std::size_t count = 0;
  // The first frame after the drive's watchdog comes back unexecuted, and it does again what it
  // did: so shutting down takes two in one cycle, and the angle is never asked for first.
  if (shutdowns_ > 0 && phase_ != Phase::kIdle) {
    out[count++] = request(Command::kShutdown);
    out[count++] = request(Command::kShutdown);
    return count;
  }
  // No more than a cycle in operation has.
  asked_angle_ = facts_.motion && !asked_angle_;
  if (!facts_.motion || !asked_angle_) {
    out[count++] = request(Command::kStatus2);
  }
  if (!facts_.motion || asked_angle_) {
    out[count++] = request(Command::kAngle);
  }
  return count + status_frame(now_ns, out.subspan(count));
}

Frame Driver::zero_frame() const noexcept {
  const Frame shutdown = request(Command::kShutdown);
  return facts_.motion ? encode_motion(options_.id, {}, ranges_).value_or(shutdown)
                       : encode_torque(options_.id, 0.0).value_or(shutdown);
}

Frame Driver::torque_frame(const DriveCommand& command) noexcept {
  DriveCommand sound = command;
  if (!is_finite(command)) {
    complaint_ = {"command (torque, position, velocity, stiffness or damping)",
                  std::numeric_limits<double>::quiet_NaN(), 0.0,
                  "the controller's numbers are not finite: keep the log and report it"};
    const double damping = std::isfinite(command.damping_nm_s_rad) ? command.damping_nm_s_rad : 0.0;
    sound = {.mode = command.mode, .damping_nm_s_rad = std::max(damping, kFallbackDamping)};
    diffusion_.reset();
  }
  const double spring = sound.stiffness_nm_rad * (sound.position_rad - state_.position_rad) +
                        sound.damping_nm_s_rad * (sound.velocity_rad_s - state_.velocity_rad_s);
  asked_nm_ =
      std::clamp(sound.torque_nm + spring, -options_.torque_range_nm, options_.torque_range_nm);
  if (facts_.motion) {
    return motion_frame(sound);
  }
  // The drive has no spring of its own here.
  return encode_torque(options_.id, asked_nm_ / facts_.torque_per_ampere_nm).value_or(zero_frame());
}

Frame Driver::motion_frame(const DriveCommand& command) noexcept {
  const double wanted_nm = std::clamp(command.torque_nm, -ranges_.torque_nm, ranges_.torque_nm);
  const auto frame = encode_motion(options_.id,
                                   {.position_rad = command.position_rad,
                                    .velocity_rad_s = command.velocity_rad_s,
                                    .stiffness_nm_rad = command.stiffness_nm_rad,
                                    .damping_nm_s_rad = command.damping_nm_s_rad,
                                    .torque_nm = diffusion_.next(wanted_nm)},
                                   ranges_);
  if (!frame) {
    return zero_frame();
  }
  diffusion_.went(wanted_nm, from_code(extract(*frame, motion::kTorque), -ranges_.torque_nm,
                                       ranges_.torque_nm, motion::kTorque.bits));
  return *frame;
}

const DriveComplaint& Driver::complaint() const noexcept {
  return complaint_.quantity != nullptr ? complaint_ : start_up_.complaint();
}

std::vector<IdFilter> Driver::reply_ids() const {
  std::vector<IdFilter> ids = {{kReplyId + options_.id, false}};
  if (facts_.motion) {
    ids.push_back({kMotionReplyId + options_.id, false});
  }
  return ids;
}

std::vector<IdFilter> Driver::command_ids() const {
  return {{kRequestId + options_.id, false},
          {kMotionRequestId + options_.id, false},
          {kBroadcastId, false},
          {kIdSettingId, false}};
}

}  // namespace geodesic::drivers::myactuator
