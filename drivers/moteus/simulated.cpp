// A moteus drive as the bus sees it: modes, torque, watchdog, console, computed in float32 as its
// firmware does. Frames are simulated_frames.cpp's. Sources and what is assumed: README.md.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>

#include "drivers/moteus/settings.hpp"
#include "drivers/moteus/simulated.hpp"

namespace geodesic::drivers::moteus {

namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr std::int64_t kEnablingNs = 10'000'000;
constexpr std::int64_t kMostTimeoutNs = 4'000'000'000'000'000;

constexpr std::uint8_t of(Mode mode) {
  return static_cast<std::uint8_t>(mode);
}

float limited(float value, float limit) {
  return std::isnan(limit) ? value : std::clamp(value, -std::abs(limit), std::abs(limit));
}

/// What is left of `value` by whole periods, in [-period / 2, period / 2).
double wrapped(double value, double period) {
  return value - period * std::floor(value / period + 0.5);
}

}  // namespace

Simulated::Simulated(const DriveOptions& options)
    : id_(options.id),
      prefix_(whole_setting(options, kPrefix)),
      output_encoder_(setting(options, kHome) == 0.0),
      torque_range_(static_cast<float>(options.torque_range_nm)),
      home_(output_encoder_ ? Home::kOutput : Home::kRotor) {
  flash_.ratio = static_cast<float>(setting(options, kRatio));
  flash_.kp = setting(options, kKp) > 0.0 ? static_cast<float>(setting(options, kKp)) : flash_.kp;
  flash_.kd = setting(options, kKd) > 0.0 ? static_cast<float>(setting(options, kKd)) : flash_.kd;
  ram_ = flash_;
}

void Simulated::set_config(const Config& config) {
  flash_ = config;
  ram_ = config;
}

void Simulated::power_cycle() {
  ram_ = flash_;
  mode_ = 0;
  fault_ = 0;
  command_ = {};
  running_ = {};
  commanded_ = false;
  watched_ = false;
  heard_size_ = 0;
  said_size_ = 0;
  home_ = output_encoder_ ? Home::kOutput : Home::kRotor;
  // An encoder at the output knows one turn of it, one at the rotor a turn of the rotor.
  const double period = output_encoder_ ? 1.0 : std::max(1e-4, static_cast<double>(ram_.ratio));
  const double offset = static_cast<double>(ram_.output_offset);
  base_rev_ = wrapped(shaft_rev_ + offset, period) - shaft_rev_ - offset;
}

bool Simulated::enabled() const {
  // After the time-out it still damps by the last command's kd scale, if that was not 0.
  return mode_ >= of(Mode::kEnabling) &&
         (mode_ != of(Mode::kPositionTimeout) || running_.kd_scale != 0.0F);
}

void Simulated::set_shaft(double position_rad, double velocity_rad_s) {
  shaft_rev_ = position_rad / kTurn;
  shaft_rev_s_ = velocity_rad_s / kTurn;
}

void Simulated::set_temperature(double celsius) {
  celsius_ = static_cast<float>(celsius);
}

void Simulated::inject_error(std::uint8_t code) {
  mode_ = code == of(Mode::kPositionTimeout) ? code : of(Mode::kFault);
  fault_ = code == of(Mode::kPositionTimeout) ? std::uint8_t{0} : code;
}

float Simulated::position() const {
  return encoder_lost_ ? kNone : static_cast<float>(shaft_rev_ + base_rev_) + ram_.output_offset;
}

void Simulated::advance(std::int64_t now_ns) {
  if (mode_ == of(Mode::kEnabling) && now_ns >= ready_ns_) {
    mode_ = running_.mode;
    control_rev_ = std::isnan(running_.position) ? position() : running_.position;
  }
  const bool servo = mode_ != of(Mode::kStopped) && mode_ != of(Mode::kFault);
  if (servo && celsius_ > ram_.fault_temperature) {
    inject_error(38);
  } else if (servo && encoder_lost_ && mode_ != of(Mode::kEnabling)) {
    inject_error(43);
  }
  if ((mode_ == of(Mode::kPosition) || mode_ == of(Mode::kStayWithin)) && watched_ &&
      now_ns >= expires_ns_) {
    mode_ = of(Mode::kPositionTimeout);
  }
}

void Simulated::apply(std::int64_t now_ns) {
  running_ = command_;
  float timeout = running_.timeout_s;
  timeout = timeout == 0.0F ? ram_.default_timeout_s : timeout;
  watched_ = !std::isnan(timeout);
  const double timeout_ns = watched_ ? 1e9 * static_cast<double>(timeout) : 0.0;
  expires_ns_ = now_ns + static_cast<std::int64_t>(
                             std::clamp(timeout_ns, 0.0, static_cast<double>(kMostTimeoutNs)));
  const std::uint8_t wanted = running_.mode;
  if (wanted == of(Mode::kStopped)) {
    mode_ = wanted;
    fault_ = 0;
    return;
  }
  if (mode_ == of(Mode::kFault) || mode_ == of(Mode::kPositionTimeout) ||
      (wanted >= of(Mode::kFault) && wanted <= of(Mode::kCalibrated))) {
    return;
  }
  if (mode_ == of(Mode::kStopped)) {
    mode_ = of(Mode::kEnabling);
    ready_ns_ = now_ns + kEnablingNs;
  } else if (mode_ != of(Mode::kEnabling)) {
    mode_ = wanted;
    if (!std::isnan(running_.position)) {
      control_rev_ = running_.position;
    }
  }
}

float Simulated::made_torque() const {
  const auto velocity = static_cast<float>(shaft_rev_s_);
  if (mode_ == of(Mode::kPosition)) {
    const float error = position() - control_rev_;
    const float rate = velocity - (std::isnan(running_.velocity) ? 0.0F : running_.velocity);
    const float all =
        running_.torque - running_.kp_scale * ram_.kp * error - running_.kd_scale * ram_.kd * rate;
    const float torque = limited(limited(all, running_.max_torque), torque_range_);
    return std::isfinite(torque) ? torque : 0.0F;
  }
  // The damper of the last command: none if its kd scale was 0.
  if (mode_ == of(Mode::kPositionTimeout) || mode_ == of(Mode::kZeroVelocity)) {
    const float torque = limited(-running_.kd_scale * ram_.kd * velocity, ram_.timeout_max_torque);
    return std::isfinite(torque) ? torque : 0.0F;
  }
  return 0.0F;
}

double Simulated::torque_nm(std::int64_t now_ns) {
  advance(now_ns);
  return static_cast<double>(made_torque());
}

void Simulated::say(std::string_view text) {
  const std::size_t size = std::min(text.size(), said_.size() - said_size_);
  std::copy_n(text.begin(), size, said_.begin() + static_cast<std::ptrdiff_t>(said_size_));
  said_size_ += size;
}

void Simulated::obey_line(std::string_view line) {
  struct Named {
    std::string_view name;
    float Config::*value;
  };
  constexpr std::array kNames = {Named{"servo.pid_position.kp", &Config::kp},
                                 Named{"servo.pid_position.kd", &Config::kd},
                                 Named{"motor_position.rotor_to_output_ratio", &Config::ratio},
                                 Named{"servo.default_timeout_s", &Config::default_timeout_s}};
  constexpr std::string_view kGet = "conf get ";
  constexpr std::string_view kSetOutput = "d cfg-set-output ";
  if (line.starts_with(kGet)) {
    for (const Named& named : kNames) {
      if (line.substr(kGet.size()) == named.name) {
        std::array<char, 32> text{};
        const auto end = std::to_chars(text.data(), text.data() + text.size(), ram_.*named.value,
                                       std::chars_format::fixed, 6);
        say({text.data(), static_cast<std::size_t>(end.ptr - text.data())});
        say("\r\n");
        return;
      }
    }
    say("ERR error reading\r\n");
  } else if (line.starts_with(kSetOutput)) {
    float wanted = 0.0F;
    const std::string_view number = line.substr(kSetOutput.size());
    std::from_chars(number.data(), number.data() + number.size(), wanted);
    ram_.output_offset += std::isfinite(wanted) ? wanted - position() : 0.0F;
    say("OK\r\n");
  } else if (line == "conf write") {
    flash_ = ram_;
    say("OK\r\n");
  } else {
    say("ERR unknown command\r\n");
  }
}

}  // namespace geodesic::drivers::moteus
