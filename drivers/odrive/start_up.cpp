// The start-up dialogue of an ODrive, step by step; see start_up.hpp. Sources: README.md.
#include "drivers/odrive/start_up.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace geodesic::drivers::odrive {

namespace {

constexpr std::int64_t kIdleIntervalNs = 50'000'000;   ///< between two requests to become idle
constexpr std::int64_t kClearSettleNs = 5'000'000;     ///< until Clear_Errors has taken effect
constexpr std::int64_t kHeldIntervalNs = 100'000'000;  ///< between two looks at an error
constexpr std::int64_t kRatePatienceNs = 1'000'000'000;
constexpr int kWordInterval = 8;           ///< 0.5: cycles between two requests for all error words
constexpr std::uint32_t kLateAnswers = 2;  ///< to what was asked before the probes
constexpr int kConfigurations = 3;         ///< Set_Limits and Set_Controller_Mode bring no answer
constexpr double kRateTolerance = 1.05;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

constexpr const char* kLowerRate =
    "set it to the control period in ms or less in odrivetool and save, or give its endpoint in "
    "the robot file, or set feedback = \"request\"";

}  // namespace

StartUp::StartUp(const DriveOptions& options)
    : options_(options), settings_(options), parameters_(options) {
  restart(false);
}

void StartUp::restart(bool expired) noexcept {
  enter(Step::kListen, -1);
  after_errors_ = Step::kParameters;
  heard_ = false;
  verified_ = false;
  held_ = false;
  expired_ = expired;
  idle_expires_ = false;
  proven_ = false;
  probes_ = 0;
  clears_ = 0;
  watchdog_clears_ = 0;
  next_idle_ns_ = 0;
  last_now_ns_ = -1;
  due_ = 0;
  complaint_ = {};
}

void StartUp::enter(Step step, std::int64_t now_ns) noexcept {
  step_ = step;
  entered_ns_ = now_ns;
  awaiting_ = false;
  configured_ = 0;
  estimates_ = {};
  torques_ = {};
}

void StartUp::refuse(const DriveComplaint& complaint) noexcept {
  complaint_ = complaint;
  step_ = Step::kRefused;
}

bool StartUp::feeds() const noexcept {
  // 0.5 is fed by every frame.
  const bool asks_only = step_ == Step::kErrors && settings_.firmware == Firmware::k05;
  return step_ != Step::kListen && step_ != Step::kVersion && !asks_only;
}

void StartUp::add(const std::optional<Frame>& frame) noexcept {
  if (frame && count_ < out_.size()) {
    out_[count_++] = *frame;
  }
}

std::size_t StartUp::transmit(std::int64_t now_ns, const Status& status,
                              std::span<Frame> out) noexcept {
  out_ = out.first(std::min(out.size(), Drive::kMaxFramesPerCycle));
  count_ = 0;
  due_ = 0;
  if (last_now_ns_ >= 0 && now_ns > last_now_ns_) {
    period_ns_ = now_ns - last_now_ns_;
  }
  last_now_ns_ = now_ns;
  entered_ns_ = entered_ns_ < 0 ? now_ns : entered_ns_;
  advance(now_ns, status);
  if (done() || refused() || step_ == Step::kSilence) {
    return 0;
  }
  if (feeds()) {
    add(encode(options_.id, kSetInputTorque, {0.0}));
  }
  if (awaiting_ && now_ns - asked_ns_ < kReplyTimeoutNs) {
    return count_;
  }
  add_step_frames(now_ns, status);
  if (refused()) {
    return 0;
  }
  add(encode_request(options_.id, Command::kError));
  for (const Frame& frame : out_.first(count_)) {
    due_ += frame.remote && command_of(frame) != Command::kVersion ? 1 : 0;
  }
  awaiting_ = true;
  asked_ns_ = now_ns;
  return count_;
}

void StartUp::add_step_frames(std::int64_t now_ns, const Status& status) noexcept {
  switch (step_) {
    case Step::kListen:
      if (status.heartbeats > 0 && status.axis_state != kAxisIdle &&
          status.axis_state != kAxisUndefined && now_ns >= next_idle_ns_) {
        next_idle_ns_ = now_ns + kIdleIntervalNs;
        add(encode(options_.id, kSetAxisState, {kAxisIdle}));
      }
      break;
    case Step::kVersion:
      if (probes_ == 0) {
        answers_before_ = status.error_answers;
        versions_before_ = status.versions;
      }
      ++probes_;
      add(encode_request(options_.id, Command::kVersion));
      break;
    case Step::kErrors:
      if (settings_.firmware == Firmware::k05 && configured_++ % kWordInterval == 0) {
        add(encode_request(options_.id, Command::kRxSdo));
        add(encode_request(options_.id, Command::kPowers));
      }
      if (held_) {
        add(encode_request(options_.id, Command::kEstimates));
      }
      break;
    case Step::kClear:
      if (configured_++ == 0) {
        add(encode(options_.id,
                   settings_.firmware == Firmware::k06 ? kClearErrors06 : kClearErrors05, {}));
      }
      break;
    case Step::kParameters:
      add(parameters_.request(now_ns));
      if (parameters_.refused()) {
        refuse(parameters_.complaint());
      }
      break;
    case Step::kConfigure:
      ++configured_;
      add(encode(options_.id, kSetLimits,
                 {settings_.velocity_limit_rad_s / kTurn, settings_.current_limit_a}));
      add(encode(options_.id, kSetControllerMode, {kTorqueControl, kPassthrough}));
      break;
    case Step::kSilence:
    case Step::kRates:
    case Step::kConfirm:
    case Step::kDone:
    case Step::kRefused:
      break;
  }
}

void StartUp::receive(const ReceivedFrame& received, const Status& status) noexcept {
  heard_ = true;
  const Command command = command_of(received.frame);
  if (command == Command::kError && !received.frame.remote) {
    awaiting_ = false;
    probes_answered_ = status.error_answers - answers_before_;
  }
  parameters_.receive(received);
  const auto time = [&received](Timing& timing) {
    timing.first_ns = timing.count == 0 ? received.stamp_ns : timing.first_ns;
    timing.last_ns = received.stamp_ns;
    ++timing.count;
  };
  // A report that was on its way when the timing began may have been asked for.
  if (step_ == Step::kRates && received.stamp_ns > entered_ns_) {
    if (command == Command::kEstimates) {
      time(estimates_);
    } else if (command == settings_.torque_command()) {
      time(torques_);
    }
  }
}

void StartUp::advance(std::int64_t now_ns, const Status& status) noexcept {
  switch (step_) {
    case Step::kListen:
      listen(now_ns, status);
      break;
    case Step::kVersion:
      probe(now_ns, status);
      break;
    case Step::kErrors:
      judge(now_ns, status);
      break;
    case Step::kClear:
      if (now_ns - entered_ns_ >= kClearSettleNs) {
        enter(Step::kErrors, now_ns);
      }
      break;
    case Step::kParameters:
      if (parameters_.refused()) {
        refuse(parameters_.complaint());
      } else if (parameters_.done()) {
        after_errors_ = Step::kSilence;
        enter(Step::kErrors, now_ns);
      }
      break;
    case Step::kSilence:
      wait_for_expiry(now_ns, status);
      break;
    case Step::kRates:
      time_reports(now_ns);
      break;
    case Step::kConfigure:
      if (configured_ == kConfigurations) {
        enter(Step::kConfirm, now_ns);
      }
      break;
    case Step::kConfirm:
      confirm(now_ns, status);
      break;
    case Step::kDone:
    case Step::kRefused:
      break;
  }
}

void StartUp::listen(std::int64_t now_ns, const Status& status) noexcept {
  if (status.heartbeats > 1 && status.heartbeat_interval_ns > kSlowestHeartbeatNs) {
    refuse({"axis0.config.can.heartbeat_msg_rate_ms, as measured [ms]",
            static_cast<double>(status.heartbeat_interval_ns) * 1e-6, kHeartbeatMs,
            "set it to 100 ms or less in odrivetool and save: it is what tells of lost torque"});
  } else if (status.heartbeats > 1 && status.axis_state == kAxisIdle) {
    probes_ = 0;
    probes_answered_ = 0;
    versions_before_ = status.versions;
    enter(Step::kVersion, now_ns);
  } else if (status.heartbeats == 0 && heard_ && now_ns - entered_ns_ > kPatienceNs) {
    refuse({"axis0.config.can.heartbeat_msg_rate_ms [ms]", kNan, kHeartbeatMs,
            "the drive answers but sends no heartbeat: set its period in odrivetool and save"});
  }
}

void StartUp::probe(std::int64_t now_ns, const Status& status) noexcept {
  const bool old = settings_.firmware == Firmware::k05;
  constexpr double kNew = 0.6;
  constexpr double kOld = 0.5;
  constexpr const char* kFix =
      "correct firmware in the robot file: 0.5 never answers command 00, 0.6 always does";
  const std::uint32_t versions = status.versions - versions_before_;
  if (versions > 0) {
    const double found = status.firmware_major + 0.1 * status.firmware_minor;
    const bool is_new = status.firmware_major == 0 && status.firmware_minor == 6;
    const bool any_endpoint = settings_.revision != 0;
    if (versions > static_cast<std::uint32_t>(probes_)) {
      refuse({"answers to one request for the version", versions * 1.0, probes_ * 1.0,
              "a second axis has this node id: give each its own"});
    } else if (old || !is_new) {
      refuse({"firmware (command 00)", found, old ? kOld : kNew, kFix});
    } else if (any_endpoint && status.firmware_revision != settings_.revision) {
      refuse({"firmware revision (command 00)", status.firmware_revision * 1.0,
              settings_.revision * 1.0,
              "endpoint ids differ between builds: look them up for the drive's very firmware, and "
              "correct endpoint_revision"});
    } else {
      verified_ = true;
      enter(Step::kErrors, now_ns);
    }
  } else if (probes_ > 0 && probes_answered_ > static_cast<std::uint32_t>(probes_) + kLateAnswers) {
    refuse({"answers to one request for the error", probes_answered_ * 1.0, probes_ * 1.0,
            "a second axis has this node id: give each its own"});
  } else if (probes_ >= kProbes && probes_answered_ >= kProbes) {
    if (old) {
      verified_ = true;
      enter(Step::kErrors, now_ns);
    } else {
      refuse({"firmware (command 00 is not answered)", kOld, kNew, kFix});
    }
  }
}

void StartUp::judge(std::int64_t now_ns, const Status& status) noexcept {
  if (!status.errors_known_since(entered_ns_)) {
    return;
  }
  const bool idle_watchdog = status.only_watchdog() && !expired_;
  if (!status.error()) {
    expired_ = false;
    after_errors(now_ns);
  } else if (idle_watchdog && watchdog_clears_ == kMaxWatchdogClears) {
    idle_expires_ = true;
    if (!watchdog_known()) {
      refuse(
          {"axis0.config.watchdog_timeout [s]", kNan,
           static_cast<double>(options_.watchdog_ns) * 1e-9,
           "set-points do not feed this watchdog while the axis is idle, so that its time cannot "
           "be seen: give its endpoints, or set watchdog_proof = \"trusted\""});
      return;
    }
    after_errors(now_ns);
  } else if (idle_watchdog || (options_.clear_errors && clears_ < kMaxClears)) {
    ++(idle_watchdog ? watchdog_clears_ : clears_);
    enter(Step::kClear, now_ns);
  } else {
    held_ = true;
    complaint_ = {"error code of the drive", static_cast<double>(status.code()), 0.0,
                  "remove its cause; then power-cycle the drive, or let clear_errors clear it"};
    if (now_ns - entered_ns_ >= kHeldIntervalNs) {
      enter(Step::kErrors, now_ns);
    }
  }
}

bool StartUp::watchdog_known() const noexcept {
  return settings_.trusts_watchdog || parameters_.covers_watchdog() || proven_;
}

void StartUp::after_errors(std::int64_t now_ns) noexcept {
  held_ = false;
  complaint_ = {};
  const bool known = watchdog_known();
  if (after_errors_ == Step::kParameters) {
    parameters_.restart(period_ns_);
  }
  Step step = after_errors_;
  if (step == Step::kSilence && known) {
    step = settings_.by_request ? Step::kConfigure : Step::kRates;
  }
  if (step == Step::kSilence) {
    after_errors_ = settings_.by_request ? Step::kConfigure : Step::kRates;
  }
  enter(step, now_ns);
}

void StartUp::wait_for_expiry(std::int64_t now_ns, const Status& status) noexcept {
  if (status.watchdog_expired()) {
    proven_ = true;
    watchdog_clears_ = 0;
    enter(Step::kErrors, now_ns);
    return;
  }
  const std::int64_t limit_ns =
      options_.watchdog_ns + status.heartbeat_interval_ns + kProofSlackNs + period_ns_;
  if (now_ns - entered_ns_ > limit_ns) {
    refuse({"axis0.config.watchdog_timeout, seen by falling silent [s]", kNan,
            static_cast<double>(options_.watchdog_ns) * 1e-9,
            "the drive's watchdog does not expire: set watchdog_timeout and enable_watchdog in "
            "odrivetool and save, or give their endpoints in the robot file"});
  }
}

void StartUp::time_reports(std::int64_t now_ns) noexcept {
  const bool all =
      estimates_.count > kSamples && (!settings_.cyclic_torque() || torques_.count > kSamples);
  if (!all && now_ns - entered_ns_ < kRatePatienceNs) {
    return;
  }
  const double period_ms = static_cast<double>(period_ns_) * 1e-6;
  const auto mean_ms = [](const Timing& timing) {
    return timing.count < 2 ? kNan
                            : static_cast<double>(timing.last_ns - timing.first_ns) * 1e-6 /
                                  static_cast<double>(timing.count - 1);
  };
  const double estimates_ms = mean_ms(estimates_);
  const double torques_ms = mean_ms(torques_);
  if (!(estimates_ms <= kRateTolerance * period_ms)) {
    refuse({settings_.firmware == Firmware::k06
                ? "axis0.config.can.encoder_msg_rate_ms, as measured [ms]"
                : "axis0.config.can.encoder_rate_ms, as measured [ms]",
            estimates_ms, period_ms, kLowerRate});
  } else if (settings_.cyclic_torque() && !(torques_ms <= kRateTolerance * period_ms)) {
    refuse({settings_.torque_feedback == TorqueFeedback::kIq
                ? "axis0.config.can.iq_msg_rate_ms, as measured [ms]"
                : "axis0.config.can.torques_msg_rate_ms, as measured [ms]",
            torques_ms, period_ms, kLowerRate});
  } else {
    enter(Step::kConfigure, now_ns);
  }
}

void StartUp::confirm(std::int64_t now_ns, const Status& status) noexcept {
  if (status.heartbeat_ns <= entered_ns_) {
    return;
  }
  if (status.axis_state != kAxisIdle) {
    enter(Step::kListen, now_ns);
  } else if (status.error() && !(idle_expires_ && status.only_watchdog())) {
    after_errors_ = Step::kConfigure;
    enter(Step::kErrors, now_ns);
  } else {
    step_ = Step::kDone;
  }
}

}  // namespace geodesic::drivers::odrive
