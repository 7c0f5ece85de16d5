// An ODrive axis as the bus sees it, computed as its firmware would: float32, byte by byte. See
// simulated.hpp; sources and what is assumed: README.md.
#include "drivers/odrive/simulated.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/odrive/errors.hpp"
#include "drivers/odrive/messages.hpp"
#include "drivers/odrive/simulated_bytes.hpp"

namespace geodesic::drivers::odrive {

namespace {

constexpr double kCounts = 16384.0;       ///< of the encoder, a turn
constexpr double kLinearCounts = 8192.0;  ///< 0.5: of Set_Linear_Count, a turn
constexpr double kOverspeed = 1.2;        ///< of the velocity limit
constexpr std::uint32_t kVelocityLimit06 = 0x8000;
constexpr std::uint32_t kOverTemperature06 = 0x4000;
constexpr std::uint32_t kEstop06 = 0x2000000;
constexpr std::uint32_t kMissingEstimate06 = 0x8;
constexpr std::uint32_t kInvalidState05 = 0x1;
constexpr std::uint32_t kMotorFailed05 = 0x40;
constexpr std::uint32_t kEncoderFailed05 = 0x100;
constexpr std::uint32_t kControllerFailed05 = 0x200;
constexpr std::uint32_t kEstop05 = 0x4000;
constexpr std::uint32_t kOverTemperature05 = 0x40000;
constexpr std::uint8_t kBusy = 1;
constexpr std::uint8_t kDisarmed = 3;
constexpr std::uint8_t kInvalidState = 13;
constexpr std::int64_t kLookNs = 125'000;  ///< between two looks at the watchdog

/// `rev` moved by whole periods into [-period/2, period/2).
double wrapped(double rev, double period) {
  return period > 0.0 ? rev - period * std::floor(rev / period + 0.5) : rev;
}

}  // namespace

Simulated::Simulated(const DriveOptions& options) : node_(options.id), settings_(options) {
  const auto given = [this](Parameter parameter, double factory, double set) {
    flash_.parameters[index(parameter)] = settings_.knows(parameter) && !old() ? factory : set;
  };
  given(Parameter::kWatchdogTimeout, 0.0, static_cast<double>(options.watchdog_ns) * 1e-9);
  given(Parameter::kEnableWatchdog, 0.0, 1.0);
  given(Parameter::kEncoderRate, 10.0, settings_.by_request ? 10.0 : 1.0);
  given(Parameter::kTorqueRate, 0.0, settings_.cyclic_torque() ? 1.0 : 0.0);
  given(Parameter::kHeartbeatRate, kHeartbeatMs, kHeartbeatMs);
  given(Parameter::kTorqueConstant, settings_.torque_constant_nm_a, settings_.torque_constant_nm_a);
  ram_ = flash_;
}

void Simulated::power_cycle() {
  ram_ = flash_;
  errors_ = {};
  state_ = kAxisUndefined;
  result_ = 0;
  input_torque_nm_ = 0.0F;
  booting_ = true;
  ready_ns_ = -1;
  fed_ns_ = -1;
  next_ns_.fill(-1);
  const double turned = shaft_rev_ - ram_.offset_rev;
  turns_rev_ = wrapped(turned, settings_.position_period_rev) - turned;
}

void Simulated::set_parameter(Parameter parameter, double value) {
  flash_.parameters[index(parameter)] = value;
  ram_.parameters[index(parameter)] = value;
}

double Simulated::parameter(Parameter parameter) const {
  return ram_.parameters[index(parameter)];
}

bool Simulated::awake(std::int64_t now_ns) {
  if (booting_) {
    ready_ns_ = ready_ns_ < 0 ? now_ns + kBootNs : ready_ns_;
    if (now_ns < ready_ns_) {
      return false;
    }
    booting_ = false;
    state_ = kAxisIdle;
  }
  fed_ns_ = fed_ns_ < 0 ? now_ns : fed_ns_;
  return true;
}

void Simulated::fail(std::uint32_t axis_bits) {
  errors_.axis |= axis_bits;
  if (state_ == kAxisClosedLoop && !old()) {
    errors_.disarm |= axis_bits;
    result_ = kDisarmed;
  }
  state_ = state_ == kAxisUndefined ? state_ : kAxisIdle;
}

void Simulated::watch(std::int64_t now_ns) {
  const double timeout_s = parameter(Parameter::kWatchdogTimeout);
  if (parameter(Parameter::kEnableWatchdog) != 0.0 && now_ns - cleared_ns_ >= kLookNs &&
      static_cast<double>(now_ns - fed_ns_) * 1e-9 > timeout_s) {
    fail(old() ? kWatchdog05 : kWatchdog06);
  }
  if (enabled() && std::abs(shaft_rev_s_) > kOverspeed * ram_.velocity_limit_rev_s) {
    errors_.controller |= old() ? 1U : 0U;
    fail(old() ? kControllerFailed05 : kVelocityLimit06);
  }
}

double Simulated::torque_nm(std::int64_t now_ns) {
  if (!awake(now_ns)) {
    return 0.0;
  }
  watch(now_ns);
  if (!enabled() || ram_.control_mode != kTorqueControl) {
    return 0.0;
  }
  const double most = ram_.current_limit_a * parameter(Parameter::kTorqueConstant);
  const double limit = ram_.velocity_limit_rev_s;
  double torque = std::clamp(static_cast<double>(input_torque_nm_), -most, most);
  torque = std::min(torque, (limit - shaft_rev_s_) * settings_.velocity_gain_nm_s_rev);
  torque = std::max(torque, (-limit - shaft_rev_s_) * settings_.velocity_gain_nm_s_rev);
  return static_cast<double>(static_cast<float>(torque));
}

double Simulated::current_a(std::int64_t now_ns) {
  const double constant = parameter(Parameter::kTorqueConstant);
  return constant > 0.0 ? torque_nm(now_ns) / constant : 0.0;
}

void Simulated::set_shaft(double position_rad, double velocity_rad_s) {
  shaft_rev_ = position_rad / kTurn;
  shaft_rev_s_ = velocity_rad_s / kTurn;
}

double Simulated::position_rev() const {
  return std::floor((shaft_rev_ - ram_.offset_rev + turns_rev_) * kCounts) / kCounts;
}

void Simulated::set_temperature(double celsius) {
  celsius_ = celsius;
  if (hot()) {
    fail(old() ? kOverTemperature05 : kOverTemperature06);
  }
}

void Simulated::inject_error(std::uint8_t code) {
  const auto bit = [code](std::uint8_t base) {
    return std::uint64_t{1} << (static_cast<unsigned>(code) - base);
  };
  if (!old()) {
    constexpr std::uint32_t kSystemLevel = 2;
    const bool known = code >= kActiveBase && code < kAxisBase;
    fail(known ? static_cast<std::uint32_t>(bit(kActiveBase)) : kSystemLevel);
  } else if (code >= kMotorBase && code < kHeartbeatLost) {
    errors_.motor |= bit(kMotorBase);
    fail(kMotorFailed05);
  } else if (code >= kControllerBase && code < kMotorBase) {
    errors_.controller |= static_cast<std::uint32_t>(bit(kControllerBase));
    fail(kControllerFailed05);
  } else if (code >= kEncoderBase && code < kControllerBase) {
    errors_.encoder |= static_cast<std::uint32_t>(bit(kEncoderBase));
    fail(kEncoderFailed05);
  } else {
    const bool known = code >= kAxisBase && code < kEncoderBase;
    fail(known ? static_cast<std::uint32_t>(bit(kAxisBase)) : kInvalidState05);
  }
}

std::size_t Simulated::receive(const Frame& frame, std::int64_t now_ns, std::span<Frame> out) {
  if (frame.error || frame.extended || frame.fd || frame.id >> kCommandBits != node_ ||
      out.empty() || !awake(now_ns)) {
    return 0;
  }
  watch(now_ns);
  const auto command = static_cast<Command>(frame.id & kCommandMask);
  if (old()) {
    feed(now_ns);
  }
  const Message* message = find_message(settings_.firmware, frame.id & kCommandMask);
  if (message != nullptr && message->report) {
    const bool asked = frame.remote || frame.length == 0;
    return asked && command != Command::kHeartbeat && report(command, now_ns, out[0]) ? 1 : 0;
  }
  if (frame.remote || message == nullptr) {
    return 0;
  }
  if (message == &kRxSdo06) {
    return serve_sdo(frame, out);
  }
  obey(frame, now_ns);
  return 0;
}

void Simulated::obey(const Frame& frame, std::int64_t now_ns) {
  const auto command = static_cast<Command>(frame.id & kCommandMask);
  const std::size_t length = frame.length;
  switch (command) {
    case Command::kEstop:
      fail(old() ? kEstop05 : kEstop06);
      break;
    case Command::kAxisState:
      if (length >= 4) {
        request_state(word_at(frame, 0), now_ns);
      }
      break;
    case Command::kControllerMode:
      if (length >= 8) {
        ram_.control_mode = word_at(frame, 0);
        ram_.input_mode = word_at(frame, 4);
      }
      break;
    case Command::kInputPosition:
    case Command::kInputVelocity:
      feed(now_ns);  // the drive's own loops are not simulated
      break;
    case Command::kInputTorque:
      if (length >= 4) {
        const float torque = float_at(frame, 0);
        input_torque_nm_ = std::isfinite(torque) ? torque : input_torque_nm_;
        if (idle_feeding_ || enabled()) {
          feed(now_ns);
        }
      }
      break;
    case Command::kLimits:
      if (length >= 8 && float_at(frame, 0) >= 0.0F && float_at(frame, 4) >= 0.0F &&
          std::isfinite(float_at(frame, 0)) && std::isfinite(float_at(frame, 4))) {
        ram_.velocity_limit_rev_s = static_cast<double>(float_at(frame, 0));
        ram_.current_limit_a = static_cast<double>(float_at(frame, 4));
      }
      break;
    case Command::kReboot: {
      const bool save = !old() && length >= 1 && frame.data[0] == kRebootAndSave;
      flash_ = save && !enabled() ? ram_ : flash_;
      power_cycle();
      break;
    }
    case Command::kClearErrors:
      errors_ = {};
      result_ = 0;
      cleared_ns_ = now_ns;
      if (hot()) {
        fail(old() ? kOverTemperature05 : kOverTemperature06);
      }
      break;
    case Command::kAbsolutePosition:
      if (length >= 4 && (old() || std::isfinite(float_at(frame, 0)))) {
        const double position =
            old()
                ? static_cast<double>(static_cast<std::int32_t>(word_at(frame, 0))) / kLinearCounts
                : static_cast<double>(float_at(frame, 0));
        ram_.offset_rev = shaft_rev_ - position;
        turns_rev_ = 0.0;
      }
      break;
    default:
      break;
  }
}

void Simulated::request_state(std::uint32_t state, std::int64_t now_ns) {
  if (state == kAxisIdle) {
    state_ = kAxisIdle;
    result_ = 0;
  } else if (state == kAxisClosedLoop && !estimate_valid_) {
    errors_.encoder |= old() ? 4U : 0U;
    fail(old() ? kEncoderFailed05 : kMissingEstimate06);
  } else if (state == kAxisClosedLoop && !errors_.any()) {
    state_ = kAxisClosedLoop;
    fed_ns_ = now_ns;
    errors_.disarm = 0;
    result_ = kBusy;
  } else if (state != kAxisClosedLoop) {
    // Calibration and the like are not simulated.
    result_ = kInvalidState;
    if (old()) {
      fail(kInvalidState05);
    }
  }
}

}  // namespace geodesic::drivers::odrive
