// A CubeMars drive as the bus sees it, computed as its firmware would: float32, truncating encoders
// that do not clamp. See simulated.hpp; sources and what is assumed: README.md.
#include "drivers/cubemars/simulated.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "drivers/cubemars/settings.hpp"

namespace geodesic::drivers::cubemars {

namespace {

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

/// As the firmware: no clamping. What lies beyond the range wraps around.
std::uint32_t float_to_uint(double value, float half_range, unsigned bits) {
  const auto half = static_cast<double>(half_range);
  const double code = (value + half) * static_cast<double>((1U << bits) - 1U) / (2.0 * half);
  const double span = static_cast<double>(1U << bits);
  const double within = code - span * std::floor(code / span);
  return static_cast<std::uint32_t>(std::min(within, span - 1.0));
}

std::int32_t big_int32(const Frame& frame) {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(frame.data[0]) << 24U |
                                   static_cast<std::uint32_t>(frame.data[1]) << 16U |
                                   static_cast<std::uint32_t>(frame.data[2]) << 8U |
                                   static_cast<std::uint32_t>(frame.data[3]));
}

/// Saturates, as the manual's limits (+-3200 deg, +-320000 erpm, +-60 A) suggest.
void put_int16(Frame& frame, std::size_t at, double counts, double limit) {
  const auto value = static_cast<std::int16_t>(std::clamp(counts, -limit, limit));
  frame.data[at] = static_cast<std::uint8_t>(static_cast<std::uint16_t>(value) >> 8U);
  frame.data[at + 1] = static_cast<std::uint8_t>(static_cast<std::uint16_t>(value) & 0xFFU);
}

bool is_special(const Frame& frame) {
  return std::all_of(frame.data.begin(), frame.data.begin() + 7,
                     [](std::uint8_t byte) { return byte == 0xFF; }) &&
         frame.data[7] >= 0xFC && frame.data[7] <= 0xFE;
}

float sane(double range) {
  return std::isfinite(range) && range > 0.0 ? static_cast<float>(range) : 1.0F;
}

}  // namespace

Simulated::Simulated(const DriveOptions& options)
    : id_(options.id & 0xFFU),
      reply_id_(options.reply_id & 0x7FFU),
      position_range_(sane(options.position_range_rad)),
      velocity_range_(sane(options.velocity_range_rad_s)),
      torque_range_(sane(options.torque_range_nm)),
      gear_(std::max(1.0, options.settings.get(kSettings, kGearRatio))),
      torque_per_ampere_nm_(options.settings.get(kSettings, kTorqueConstant) * gear_),
      erpm_per_rad_s_(options.settings.get(kSettings, kPolePairs) * gear_ * 30.0 /
                      std::numbers::pi),
      degrees_per_radian_(180.0 / std::numbers::pi *
                          (options.settings.get(kSettings, kPositionOf) == 1.0 ? gear_ : 1.0)),
      period_rad_(2.0 * std::numbers::pi /
                  (options.settings.get(kSettings, kEncoder) == 1.0 ? 1.0 : gear_)),
      temperature_offset_c_(options.settings.get(kSettings, kTemperatureOffset)),
      servo_(options.settings.get(kSettings, kMode) == 1.0),
      watchdog_ns_(options.watchdog_ns) {}

void Simulated::power_cycle() {
  switched_on_ = true;
  running_ = false;
  error_ = Error::kNone;
  command_ = {};
  current_a_ = 0.0;
  deaf_until_ns_ = 0;
  announcements_due_ = 2;
  // The encoder knows the angle within one of its turns, not the turn.
  const double turned = shaft_rad_ - zero_rad_;
  turns_rad_ = -period_rad_ * std::floor(turned / period_rad_ + 0.5);
  if (celsius_ > kOverTemperature) {
    fail(Error::kMotorOverTemperature);
  }
}

void Simulated::set_servo_mode(bool servo) {
  servo_ = servo;
  power_cycle();
}

void Simulated::set_ranges(double velocity_rad_s, double torque_nm) {
  velocity_range_ = sane(velocity_rad_s);
  torque_range_ = sane(torque_nm);
}

void Simulated::set_shaft(double position_rad, double velocity_rad_s) {
  shaft_rad_ = position_rad;
  shaft_rad_s_ = velocity_rad_s;
}

double Simulated::measured_rad() const {
  return shaft_rad_ - zero_rad_ + turns_rad_;
}

void Simulated::set_temperature(double celsius) {
  celsius_ = celsius;
  if (celsius_ > kOverTemperature) {
    fail(Error::kMotorOverTemperature);
  }
}

void Simulated::inject_error(std::uint8_t code) {
  fail(static_cast<Error>(code));
}

void Simulated::fail(Error error) {
  error_ = error;
  running_ = false;
  command_ = {};
  current_a_ = 0.0;
}

bool Simulated::boots(std::int64_t now_ns) {
  if (switched_on_) {
    switched_on_ = false;
    boots_until_ns_ = now_ns + kBootNs;
  }
  return now_ns < boots_until_ns_;
}

void Simulated::watch(std::int64_t now_ns) {
  if (watchdog_ns_ > 0 && now_ns - last_command_ns_ > watchdog_ns_) {
    // It stays in its mode and follows the next command: nothing tells that it stopped.
    command_ = {};
    current_a_ = 0.0;
    expired_ = true;
  }
}

double Simulated::torque_nm(std::int64_t now_ns) {
  watch(now_ns);
  if (!enabled()) {
    return 0.0;
  }
  const double limit = static_cast<double>(torque_range_);
  if (servo_) {
    return std::clamp(current_a_ * torque_per_ampere_nm_, -limit, limit);
  }
  const auto position = static_cast<float>(measured_rad());
  const auto velocity = static_cast<float>(shaft_rad_s_);
  const float wanted = command_.stiffness * (command_.position - position) +
                       command_.damping * (command_.velocity - velocity) + command_.torque;
  return std::clamp(static_cast<double>(wanted), -limit, limit);
}

std::size_t Simulated::receive(const Frame& frame, std::int64_t now_ns, std::span<Frame> out) {
  if (frame.error || frame.remote || frame.fd || out.empty() || now_ns < deaf_until_ns_ ||
      boots(now_ns)) {
    return 0;
  }
  watch(now_ns);
  if (servo_) {
    if (frame.extended && (frame.id & 0xFFU) == id_) {
      obey_servo(frame, now_ns);
    }
    return 0;
  }
  return !frame.extended && frame.id == id_ && frame.length == 8 ? serve_mit(frame, now_ns, out[0])
                                                                 : 0;
}

std::size_t Simulated::serve_mit(const Frame& frame, std::int64_t now_ns, Frame& out) {
  out = mit_reply(now_ns);  // before the command is looked at
  if (!is_special(frame)) {
    const auto signed_value = [&frame](Field field, float range) {
      return uint_to_float(bits_at(frame, field), -range, range, field.bits);
    };
    last_command_ns_ = now_ns;
    expired_ = false;
    if (error_ == Error::kNone) {
      command_.position = signed_value(mit::kPosition, position_range_);
      command_.velocity = signed_value(mit::kVelocity, velocity_range_);
      command_.torque = signed_value(mit::kTorque, torque_range_);
      command_.stiffness =
          uint_to_float(bits_at(frame, mit::kStiffness), 0.0F,
                        static_cast<float>(mit::kMaxStiffness), mit::kStiffness.bits);
      command_.damping = uint_to_float(bits_at(frame, mit::kDamping), 0.0F,
                                       static_cast<float>(mit::kMaxDamping), mit::kDamping.bits);
    }
    return 1;
  }
  switch (static_cast<Special>(frame.data[7])) {
    case Special::kEnter:
      running_ = error_ == Error::kNone;
      break;
    case Special::kExit:
      running_ = false;
      break;
    case Special::kSetZero:
      zero_rad_ = shaft_rad_;
      turns_rad_ = 0.0;
      deaf_until_ns_ = now_ns + kDeafNs;
      break;
  }
  return 1;
}

void Simulated::obey_servo(const Frame& frame, std::int64_t now_ns) {
  const auto function = static_cast<Function>(frame.id >> 8U & 0xFFU);
  if (frame.id >> 8U > static_cast<std::uint32_t>(Function::kPositionSpeed)) {
    return;
  }
  if (function == Function::kOrigin) {
    if (frame.length == 1) {
      zero_rad_ = shaft_rad_;
      turns_rad_ = 0.0;
    }
    return;
  }
  last_command_ns_ = now_ns;
  expired_ = false;
  // The drive's own speed and position loops are not simulated: no torque there.
  const bool current = function == Function::kCurrent && frame.length == 4;
  running_ = current && error_ == Error::kNone;
  current_a_ = running_ ? big_int32(frame) / 1000.0 : 0.0;
}

Frame Simulated::mit_reply(std::int64_t now_ns) {
  Frame frame;
  frame.id = reply_id_;
  frame.length = reply_bytes_;
  put_bits(frame, reply::kMotor, id_);
  put_bits(frame, reply::kPosition,
           float_to_uint(measured_rad(), position_range_, reply::kPosition.bits));
  put_bits(frame, reply::kVelocity,
           float_to_uint(shaft_rad_s_, velocity_range_, reply::kVelocity.bits));
  put_bits(frame, reply::kTorque,
           float_to_uint(torque_nm(now_ns), torque_range_, reply::kTorque.bits));
  if (reply_bytes_ == reply::kWithVoltage) {
    put_bits(frame, reply::kVoltage, static_cast<std::uint32_t>(24.0 / reply::kMaxVoltage * 255.0));
  } else if (reply_bytes_ == reply::kWithError) {
    put_bits(frame, reply::kTemperature,
             static_cast<std::uint32_t>(std::clamp(celsius_ - temperature_offset_c_, 0.0, 255.0)));
    put_bits(frame, reply::kError, static_cast<std::uint32_t>(error_));
  }
  return frame;
}

std::size_t Simulated::speak(std::int64_t now_ns, std::span<Frame> out) {
  std::size_t count = 0;
  if (boots(now_ns) || !servo_) {
    return 0;
  }
  for (; announcements_due_ > 0 && count < out.size(); --announcements_due_) {
    out[count++] =
        announcement(announcements_due_ == 2 ? Function::kStartUp : Function::kServoMode);
    next_status_ns_ = now_ns;
  }
  if (now_ns >= next_status_ns_ && count < out.size()) {
    next_status_ns_ = std::max(next_status_ns_ + status_interval_ns_, now_ns - status_interval_ns_);
    out[count++] = status(now_ns);
  }
  return count;
}

Frame Simulated::announcement(Function function) const {
  Frame frame;
  frame.id = static_cast<std::uint32_t>(function) * 256U + id_;
  frame.extended = true;
  frame.length = 8;
  if (function == Function::kServoMode) {
    frame.length = 4;
    frame.data = {0xFA, 0xFB, 0xFC, 0xFD};
  }
  return frame;
}

Frame Simulated::status(std::int64_t now_ns) {
  Frame frame = announcement(Function::kStatus);
  const double amperes =
      torque_per_ampere_nm_ > 0.0 ? torque_nm(now_ns) / torque_per_ampere_nm_ : 0.0;
  put_int16(frame, 0, measured_rad() * degrees_per_radian_ * 10.0, 32000.0);
  put_int16(frame, 2, shaft_rad_s_ * erpm_per_rad_s_ / 10.0, 32000.0);
  put_int16(frame, 4, amperes * 100.0, 6000.0);
  frame.data[6] =
      static_cast<std::uint8_t>(static_cast<std::int8_t>(std::clamp(celsius_, -128.0, 127.0)));
  frame.data[7] = static_cast<std::uint8_t>(error_);
  return frame;
}

}  // namespace geodesic::drivers::cubemars
