// A MyActuator drive as the bus sees it: integers truncated, float32 in motion mode. See
// simulated.hpp; sources and what is assumed: README.md.
#include "drivers/myactuator/simulated.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string_view>

#include "drivers/myactuator/settings.hpp"

namespace geodesic::drivers::myactuator {

namespace {

constexpr std::string_view kModel = "X8S2V40";
constexpr double kSupply = 48.0;  ///< [V]
constexpr double kDegrees = 57.29577951308232;

/// Bit by bit, unlike the codec.
std::uint32_t bits_at(const Frame& frame, Field field) {
  std::uint32_t code = 0;
  for (unsigned bit = field.first; bit < static_cast<unsigned>(field.first) + field.bits; ++bit) {
    code = code * 2U + (frame.data[bit / 8U] >> (7U - bit % 8U) & 1U);
  }
  return code;
}

void put_bits(Frame& frame, Field field, std::uint32_t code) {
  for (unsigned i = 0; i < field.bits; ++i) {
    const unsigned bit = field.first + field.bits - 1U - i;
    if ((code >> i & 1U) != 0U) {
      frame.data[bit / 8U] = static_cast<std::uint8_t>(frame.data[bit / 8U] | 0x80U >> bit % 8U);
    }
  }
}

float uint_to_float(std::uint32_t code, float low, float high, unsigned bits) {
  return static_cast<float>(code) * (high - low) / static_cast<float>((1U << bits) - 1U) + low;
}

std::uint32_t float_to_uint(float value, float low, float high, unsigned bits) {
  const auto steps = static_cast<float>((1U << bits) - 1U);
  return static_cast<std::uint32_t>((std::clamp(value, low, high) - low) * steps / (high - low));
}

void put_int16(Frame& frame, std::size_t at, double value) {
  const auto number = static_cast<std::int16_t>(std::clamp(value, -32768.0, 32767.0));
  frame.data[at] = static_cast<std::uint8_t>(static_cast<std::uint16_t>(number) & 0xFFU);
  frame.data[at + 1] = static_cast<std::uint8_t>(static_cast<std::uint16_t>(number) >> 8U);
}

void put_uint32(Frame& frame, std::uint32_t value) {
  frame.data[4] = static_cast<std::uint8_t>(value & 0xFFU);
  frame.data[5] = static_cast<std::uint8_t>(value >> 8U & 0xFFU);
  frame.data[6] = static_cast<std::uint8_t>(value >> 16U & 0xFFU);
  frame.data[7] = static_cast<std::uint8_t>(value >> 24U);
}

std::uint32_t uint32_of(const Frame& frame) {
  return frame.data[4] | static_cast<std::uint32_t>(frame.data[5]) << 8U |
         static_cast<std::uint32_t>(frame.data[6]) << 16U |
         static_cast<std::uint32_t>(frame.data[7]) << 24U;
}

float sane(double range) {
  return std::isfinite(range) && range > 0.0 ? static_cast<float>(range) : 1.0F;
}

}  // namespace

Simulated::Simulated(const DriveOptions& options)
    : motor_(options.id),
      position_range_(sane(options.position_range_rad)),
      velocity_range_(sane(options.velocity_range_rad_s)),
      torque_range_(sane(options.torque_range_nm)),
      stiffness_range_(sane(options.settings.get(kSettings, kStiffnessRange))),
      damping_range_(sane(options.settings.get(kSettings, kDampingRange))),
      torque_per_ampere_nm_(options.settings.get(kSettings, kTorqueConstant)),
      period_rad_(options.settings.get(kSettings, kPowerOnPeriod) / kDegrees),
      has_brake_(options.settings.get(kSettings, kBrake) == 1.0),
      saves_turns_(period_rad_ == 0.0),
      brake_released_(!has_brake_) {
  const double date = options.settings.get(kSettings, kOldestFirmware);
  if (date > 0.0) {
    firmware_ = static_cast<std::uint32_t>(date);  // just new enough
  }
  if (!(torque_per_ampere_nm_ > 0.0)) {
    torque_per_ampere_nm_ = 1.0;  // whatever it is: nobody asks in motion mode
  }
}

void Simulated::set_motion_ranges(double position_rad, double velocity_rad_s, double torque_nm) {
  position_range_ = sane(position_rad);
  velocity_range_ = sane(velocity_rad_s);
  torque_range_ = sane(torque_nm);
}

void Simulated::stop() {
  running_ = false;
  loop_ = Loop::kNone;
  current_a_ = 0.0;
  motion_ = {};
}

void Simulated::power_cycle() {
  switched_on_ = true;
  stop();
  errors_ = 0;
  tripped_ = false;
  spoken_to_ = false;
  brake_released_ = !has_brake_;
  zero_rad_ = next_zero_rad_;
  if (!saves_turns_ && period_rad_ > 0.0) {
    const double turned = shaft_rad_ - zero_rad_;
    turns_rad_ = -period_rad_ * std::floor(turned / period_rad_ + 0.5);
  }
  set_temperature(celsius_);
}

void Simulated::set_shaft(double position_rad, double velocity_rad_s) {
  shaft_rad_ = position_rad;
  shaft_rad_s_ = velocity_rad_s;
}

void Simulated::set_temperature(double celsius) {
  celsius_ = celsius;
  if (celsius_ > kOverTemperature) {
    errors_ = static_cast<std::uint16_t>(errors_ |
                                         static_cast<std::uint16_t>(Error::kMotorOverTemperature));
    stop();
  }
}

void Simulated::inject_error(std::uint8_t code) {
  const unsigned bit = code == 0 ? 0U : (code - 1U) % 16U;
  errors_ = static_cast<std::uint16_t>(errors_ | 1U << bit);
  stop();
}

bool Simulated::boots(std::int64_t now_ns) {
  if (switched_on_) {
    switched_on_ = false;
    boots_until_ns_ = now_ns + kBootNs;
  }
  return now_ns < boots_until_ns_;
}

void Simulated::watch(std::int64_t now_ns) {
  const std::int64_t limit_ns = static_cast<std::int64_t>(watchdog_ms_) * 1'000'000;
  if (limit_ns > 0 && spoken_to_ && !tripped_ && now_ns - last_heard_ns_ > limit_ns) {
    tripped_ = true;  // output cut, and the brake locks
    next_notice_ns_ = now_ns;
  }
}

double Simulated::torque_nm(std::int64_t now_ns) {
  watch(now_ns);
  if (!enabled() || !brake_released_) {
    return 0.0;
  }
  const double limit = static_cast<double>(torque_range_);
  if (loop_ == Loop::kCurrent) {
    return std::clamp(current_a_ * torque_per_ampere_nm_, -limit, limit);
  }
  const float wanted = motion_.stiffness * (motion_.position - static_cast<float>(angle_rad())) +
                       motion_.damping * (motion_.velocity - static_cast<float>(shaft_rad_s_)) +
                       motion_.torque;
  return std::clamp(static_cast<double>(wanted), -limit, limit);
}

double Simulated::amperes(std::int64_t now_ns) {
  return torque_nm(now_ns) / torque_per_ampere_nm_;
}

std::size_t Simulated::receive(const Frame& frame, std::int64_t now_ns, std::span<Frame> out) {
  const bool to_it = frame.id == kRequestId + motor_ || frame.id == kBroadcastId;
  const bool in_motion = frame.id == kMotionRequestId + motor_;
  if (frame.error || frame.remote || frame.extended || frame.fd || frame.length != kLength ||
      out.empty() || (!to_it && !in_motion) || boots(now_ns)) {
    return 0;
  }
  watch(now_ns);
  last_heard_ns_ = now_ns;
  spoken_to_ = true;
  out[0] = {};
  out[0].id = (in_motion ? kMotionReplyId : kReplyId) + motor_;
  out[0].length = kLength;
  if (tripped_) {
    tripped_ = false;  // the first command is swallowed: it comes back as it was
    out[0].data = frame.data;
    return 1;
  }
  if (in_motion) {
    obey_motion(frame, now_ns, out[0]);
    return 1;
  }
  return serve(frame, now_ns, out[0]) ? 1 : 0;
}

bool Simulated::serve(const Frame& frame, std::int64_t now_ns, Frame& out) {
  out.data[0] = frame.data[0];
  switch (static_cast<Command>(frame.data[0])) {
    case Command::kStatus1:
      out.data[1] = byte_of_celsius();
      out.data[2] = out.data[1];
      out.data[3] = brake_released_ ? 1 : 0;
      put_int16(out, 4, kSupply / kVoltageUnit);
      out.data[6] = static_cast<std::uint8_t>(errors_ & 0xFFU);
      out.data[7] = static_cast<std::uint8_t>(errors_ >> 8U);
      return true;
    case Command::kStatus3:
      out.data[1] = byte_of_celsius();
      put_int16(out, 2, amperes(now_ns) * 100.0);
      put_int16(out, 4, amperes(now_ns) * -50.0);
      put_int16(out, 6, amperes(now_ns) * -50.0);
      return true;
    case Command::kTorque:
      if (errors_ == 0) {
        running_ = true;
        loop_ = Loop::kCurrent;
        current_a_ = static_cast<std::int16_t>(uint32_of(frame) & 0xFFFFU) / 100.0;
      }
      put_loop_reply(now_ns, out);
      return true;
    case Command::kSpeed:
    case Command::kPosition:
      stop();  // its own loops are not simulated
      put_loop_reply(now_ns, out);
      return true;
    case Command::kStatus2:
      put_loop_reply(now_ns, out);
      return true;
    case Command::kAngle:
      put_uint32(out, static_cast<std::uint32_t>(
                          static_cast<std::int32_t>(angle_rad() * kDegrees / kAngleUnit)));
      return true;
    case Command::kShutdown:
      stop();
      return true;
    case Command::kStop:
      current_a_ = 0.0;
      motion_ = {};
      return true;
    case Command::kReleaseBrake:
    case Command::kLockBrake:
      brake_released_ =
          !has_brake_ || static_cast<Command>(frame.data[0]) == Command::kReleaseBrake;
      return true;
    case Command::kVersion:
      put_uint32(out, firmware_);
      return true;
    case Command::kModel:
      std::copy(kModel.begin(), kModel.end(), out.data.begin() + 1);
      return true;
    case Command::kWatchdog:
      watchdog_ms_ = uint32_of(frame);
      out.data = frame.data;
      return true;
    case Command::kZeroHere:
      if (running_) {
        return false;
      }
      next_zero_rad_ = shaft_rad_;
      put_uint32(out, 1);
      return true;
    case Command::kFunction:
      if (frame.data[1] == 1) {
        turns_rad_ -=
            2.0 * std::numbers::pi * std::floor(angle_rad() / (2.0 * std::numbers::pi) + 0.5);
      } else if (frame.data[1] == 4) {
        saves_turns_ = uint32_of(frame) != 0;
      }
      out.data = frame.data;
      return true;
    case Command::kReset:
      power_cycle();
      return false;
    default:
      return false;
  }
}

std::uint8_t Simulated::byte_of_celsius() const {
  const double within = std::clamp(celsius_, -128.0, 127.0);
  return static_cast<std::uint8_t>(static_cast<std::int8_t>(within));
}

void Simulated::put_loop_reply(std::int64_t now_ns, Frame& out) {
  out.data[1] = byte_of_celsius();
  put_int16(out, kCurrentAt, std::round(amperes(now_ns) * 100.0));
  put_int16(out, kSpeedAt, shaft_rad_s_ * kDegrees);
  put_int16(out, kAngleAt, angle_rad() * kDegrees);
}

void Simulated::obey_motion(const Frame& frame, std::int64_t now_ns, Frame& out) {
  const auto signed_value = [&frame](Field field, float range) {
    return uint_to_float(bits_at(frame, field), -range, range, field.bits);
  };
  if (errors_ == 0) {
    running_ = true;
    loop_ = Loop::kMotion;
    motion_.position = signed_value(motion::kPosition, position_range_);
    motion_.velocity = signed_value(motion::kVelocity, velocity_range_);
    motion_.torque = signed_value(motion::kTorque, torque_range_);
    motion_.stiffness = uint_to_float(bits_at(frame, motion::kStiffness), 0.0F, stiffness_range_,
                                      motion::kStiffness.bits);
    motion_.damping = uint_to_float(bits_at(frame, motion::kDamping), 0.0F, damping_range_,
                                    motion::kDamping.bits);
  }
  const auto put = [&out](Field field, double value, float range) {
    put_bits(out, field, float_to_uint(static_cast<float>(value), -range, range, field.bits));
  };
  put_bits(out, motion::kReplyMotor, motor_);
  put(motion::kReplyPosition, angle_rad(), position_range_);
  put(motion::kReplyVelocity, shaft_rad_s_, velocity_range_);
  put(motion::kReplyTorque, torque_nm(now_ns), torque_range_);
}

std::size_t Simulated::speak(std::int64_t now_ns, std::span<Frame> out) {
  watch(now_ns);
  if (boots(now_ns) || !tripped_ || now_ns < next_notice_ns_ || out.empty()) {
    return 0;
  }
  next_notice_ns_ = now_ns + kNoticeNs;
  out[0] = {};
  out[0].id = kReplyId + motor_;
  out[0].length = kLength;
  out[0].data[0] = static_cast<std::uint8_t>(Command::kWatchdogExpired);
  return 1;
}

}  // namespace geodesic::drivers::myactuator
