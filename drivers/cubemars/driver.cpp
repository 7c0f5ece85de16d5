// The half of a CubeMars driver that commands: phases and frames. See driver.hpp for what it
// promises; listening is in driver_reports.cpp.
#include "drivers/cubemars/driver.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace geodesic::drivers::cubemars {

using control::DriveMode;

namespace {

constexpr unsigned kTorqueBits = mit::kTorque.bits;

double step_of(double range, unsigned bits) noexcept {
  return 2.0 * range / static_cast<double>((1U << bits) - 1U);
}

}  // namespace

Driver::Driver(const DriveOptions& options)
    : options_(options),
      facts_(options),
      ranges_{options.position_range_rad, options.velocity_range_rad_s, options.torque_range_nm},
      start_up_(options),
      velocity_check_(facts_.velocity_check,
                      facts_.servo ? servo::kStatusSpeedUnit * facts_.rad_s_per_erpm
                                   : step_of(options.velocity_range_rad_s, mit::kVelocity.bits)),
      diffusion_(options.error_diffusion && !facts_.servo,
                 step_of(options.torque_range_nm, kTorqueBits)) {}

void Driver::restart() noexcept {
  // The mode stays: a drive that was out does not come back because somebody restarted it.
  enable_due_ = false;
  begin_start_up();
}

void Driver::begin_start_up() noexcept {
  complaint_ = {};
  start_up_.restart();
  velocity_check_.restart();
  counting_ = false;
  phase_ = Phase::kStartUp;
  update_condition();
}

void Driver::fall_out(const DriveComplaint& complaint) noexcept {
  complaint_ = complaint;
  phase_ = Phase::kOut;
  releases_ = kReleases;
  diffusion_.reset();
}

void Driver::refuse(const DriveComplaint& complaint) noexcept {
  fall_out(complaint);
  phase_ = Phase::kRefused;
}

void Driver::follow(DriveMode mode, std::int64_t now_ns) noexcept {
  const bool wanted = mode == DriveMode::kEnable;
  enable_due_ = wanted && (enable_due_ || mode_ != DriveMode::kEnable);
  mode_ = mode;
  const double limit_s = static_cast<double>(options_.watchdog_ns) * 1e-9;
  if (following() && now_ns - last_transmit_ns_ > options_.watchdog_ns) {
    fall_out({"time between two commands to the drive [s]",
              static_cast<double>(now_ns - last_transmit_ns_) * 1e-9, limit_s,
              "the drive's watchdog may have ended its torque: find what held this host up"});
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
        enabled_replies_ = 0;
        next_enable_ns_ = now_ns;
        diffusion_.reset();
        phase_ = error_ == 0 ? Phase::kEnabling : Phase::kOut;
      }
      break;
    case Phase::kEnabling:
    case Phase::kEnabled:
      if (!wanted) {
        phase_ = Phase::kDisabling;
        zero_sent_ = false;
        disable_sent_ = false;
        releases_ = kReleases;
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
      count = start_up_.transmit(now_ns, out[0]) ? 1 : 0;
      break;
    case Phase::kEnabling:
      count = enabling_frames(now_ns, out);
      break;
    case Phase::kEnabled:
      out[0] = torque_frame(command);
      count = 1;
      break;
    case Phase::kDisabling:
      count = disabling_frames(out);
      break;
    case Phase::kIdle:
    case Phase::kOut:
    case Phase::kRefused:
      count = released_frames(out);
      break;
  }
  update_condition();
  return count;
}

std::size_t Driver::enabling_frames(std::int64_t now_ns, std::span<Frame> out) noexcept {
  asked_nm_ = 0.0;
  followed_ns_ = now_ns;
  out[0] = zero_frame();
  if (now_ns < next_enable_ns_ || facts_.servo) {
    return 1;
  }
  if (enables_ == kMaxEnables) {
    fall_out({"replies to the enable command", 0.0, 1.0,
              "check the drive's supply, its cable and the bus' termination"});
    return released_frames(out);
  }
  ++enables_;
  next_enable_ns_ = now_ns + kEnableIntervalNs;
  // The drive follows whatever command is stored in it: zero stands before and after.
  out[1] = encode_special(options_.id, Special::kEnter);
  out[2] = out[0];
  return 3;
}

std::size_t Driver::disabling_frames(std::span<Frame> out) noexcept {
  if (facts_.servo) {
    const std::size_t count = released_frames(out);
    phase_ = releases_ == 0 ? Phase::kIdle : phase_;
    return count;
  }
  if (!zero_sent_) {
    zero_sent_ = true;
    out[0] = zero_frame();
    return 1;
  }
  disable_sent_ = true;
  out[0] = encode_special(options_.id, Special::kExit);
  return 1;
}

std::size_t Driver::released_frames(std::span<Frame> out) noexcept {
  if (!facts_.servo) {
    out[0] = encode_special(options_.id, Special::kExit);
    return 1;
  }
  if (releases_ == 0) {
    return 0;  // servo mode has no frame that asks and does not command
  }
  --releases_;
  out[0] = zero_frame();
  return 1;
}

Frame Driver::zero_frame() const noexcept {
  const Frame exit = encode_special(options_.id, Special::kExit);
  return facts_.servo ? encode_servo(options_.id, {Function::kCurrent, 0.0}).value_or(exit)
                      : encode_mit(options_.id, {}, ranges_).value_or(exit);
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
  asked_nm_ = std::clamp(sound.torque_nm + spring, -ranges_.torque_nm, ranges_.torque_nm);
  return facts_.servo ? current_frame() : mit_frame(sound);
}

Frame Driver::mit_frame(const DriveCommand& command) noexcept {
  const double wanted_nm = std::clamp(command.torque_nm, -ranges_.torque_nm, ranges_.torque_nm);
  const MitCommand mit{.position_rad = command.position_rad,
                       .velocity_rad_s = command.velocity_rad_s,
                       .stiffness_nm_rad = command.stiffness_nm_rad,
                       .damping_nm_s_rad = command.damping_nm_s_rad,
                       .torque_nm = diffusion_.next(wanted_nm)};
  const auto frame = encode_mit(options_.id, mit, ranges_);
  if (!frame) {
    return zero_frame();
  }
  diffusion_.went(wanted_nm, from_code(extract(*frame, mit::kTorque), -ranges_.torque_nm,
                                       ranges_.torque_nm, kTorqueBits));
  return *frame;
}

Frame Driver::current_frame() const noexcept {
  // The drive has no spring of its own here: asked_nm_ holds them.
  return encode_servo(options_.id, {Function::kCurrent, asked_nm_ / facts_.torque_per_ampere_nm})
      .value_or(zero_frame());
}

const DriveComplaint& Driver::complaint() const noexcept {
  return complaint_.quantity != nullptr ? complaint_ : start_up_.complaint();
}

std::vector<IdFilter> Driver::reply_ids() const {
  const IdFilter status{servo_id(Function::kStatus, options_.id), true};
  const IdFilter mode{servo_id(Function::kServoMode, options_.id), true};
  if (facts_.servo) {
    return {status, mode, {servo_id(Function::kStartUp, options_.id), true}};
  }
  IdFilter reply{options_.reply_id, false};
  reply.shared = options_.reply_id != options_.id;
  return {reply, status, mode};
}

std::vector<IdFilter> Driver::command_ids() const {
  if (!facts_.servo) {
    // A drive that answers on its own identifier: commands of others cannot be told from answers.
    return options_.reply_id == options_.id ? std::vector<IdFilter>{}
                                            : std::vector<IdFilter>{{options_.id, false}};
  }
  std::vector<IdFilter> ids;
  for (const Function function :
       {Function::kDuty, Function::kCurrent, Function::kBrakeCurrent, Function::kSpeed,
        Function::kPosition, Function::kOrigin, Function::kPositionSpeed, Function::kMit}) {
    ids.push_back({servo_id(function, options_.id), true});
  }
  return ids;
}

}  // namespace geodesic::drivers::cubemars
