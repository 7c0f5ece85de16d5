// A Damiao drive as the bus sees it, computed as its firmware would: float32, truncating encoders.
// See simulated.hpp; sources and what is assumed: README.md.
#include "drivers/damiao/simulated.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

namespace geodesic::drivers::damiao {

namespace {

constexpr std::uint32_t kFactoryTimeout = 8000;  ///< 400 ms
constexpr float kFactoryOverTemperature = 100.0F;
constexpr std::uint32_t kFirmwareVersion = 5016;
constexpr std::uint32_t kClassic1M = 4;
constexpr std::uint32_t kFd5M = 9;

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
  const auto steps = static_cast<float>((1U << bits) - 1U);
  return static_cast<float>(code) * (high - low) / steps + low;
}

std::uint32_t float_to_uint(float value, float low, float high, unsigned bits) {
  const auto steps = static_cast<float>((1U << bits) - 1U);
  return static_cast<std::uint32_t>((std::clamp(value, low, high) - low) * steps / (high - low));
}

std::uint32_t little(const Frame& frame, std::size_t at) {
  return frame.data[at] | static_cast<std::uint32_t>(frame.data[at + 1]) << 8U |
         static_cast<std::uint32_t>(frame.data[at + 2]) << 16U |
         static_cast<std::uint32_t>(frame.data[at + 3]) << 24U;
}

bool ends_in_special(const Frame& frame) {
  return std::all_of(frame.data.begin(), frame.data.begin() + 7,
                     [](std::uint8_t byte) { return byte == 0xFF; }) &&
         frame.data[7] >= 0xFB && frame.data[7] <= 0xFE;
}

/// `angle` moved by whole spans into [-half, half).
double wrapped(double angle, double half) {
  return angle - 2.0 * half * std::floor((angle + half) / (2.0 * half));
}

}  // namespace

Simulated::Simulated(const DriveOptions& options) {
  const auto put = [this](Register number, std::uint32_t raw) {
    flash_[static_cast<std::size_t>(number)] = raw;
  };
  const auto put_real = [&put](Register number, double value) {
    put(number, std::bit_cast<std::uint32_t>(static_cast<float>(value)));
  };
  put(Register::kId, options.id);
  put(Register::kReplyId, options.reply_id);
  put(Register::kTimeout, kFactoryTimeout);
  put(Register::kControlMode, static_cast<std::uint32_t>(ControlMode::kMit));
  put(Register::kFirmware, kFirmwareVersion);
  put(Register::kHardware, 1);
  put(Register::kBitRate, options.fd ? kFd5M : kClassic1M);
  put_real(Register::kOverTemperature, static_cast<double>(kFactoryOverTemperature));
  put_real(Register::kPositionRange, options.position_range_rad);
  put_real(Register::kVelocityRange, options.velocity_range_rad_s);
  put_real(Register::kTorqueRange, options.torque_range_nm);
  switch_on();
}

void Simulated::switch_on() {
  ram_ = flash_;
  status_ = Status::kDisabled;
  command_ = {};
  fd_ = integer(Register::kBitRate) > kClassic1M;
  // The encoder knows the angle within one turn, not the turn.
  const double turned = shaft_rad_ - zero_rad_;
  turns_rad_ = wrapped(turned, std::numbers::pi) - turned;
}

void Simulated::power_cycle() {
  switch_on();
}

float Simulated::real(Register number) const {
  return std::bit_cast<float>(ram_[static_cast<std::size_t>(number)]);
}

// Anybody may write anything into a scaling register; a drive goes on with its arithmetic.
float Simulated::scale(Register number) const {
  constexpr float kMost = 1e30F;
  const float value = real(number);
  return value > 1.0F / kMost && value < kMost ? value : 1.0F;
}

std::uint32_t Simulated::integer(Register number) const {
  return ram_[static_cast<std::size_t>(number)];
}

std::uint32_t Simulated::register_raw(std::uint8_t number) const {
  return ram_[number];
}

void Simulated::set_register(std::uint8_t number, std::uint32_t raw) {
  if (find_register(number) != nullptr) {
    flash_[number] = raw;
    ram_[number] = raw;
  }
}

bool Simulated::enabled() const {
  return status_ == Status::kEnabled;
}

bool Simulated::heats() const {
  return celsius_ > static_cast<double>(real(Register::kOverTemperature));
}

void Simulated::set_temperature(double celsius) {
  celsius_ = celsius;
  if (heats()) {
    fall_into(Status::kRotorOverTemperature);
  }
}

void Simulated::inject_error(std::uint8_t code) {
  fall_into(static_cast<Status>(code & 0xFU));
}

void Simulated::fall_into(Status status) {
  status_ = status;
  command_ = {};
}

void Simulated::set_shaft(double position_rad, double velocity_rad_s) {
  shaft_rad_ = position_rad;
  shaft_rad_s_ = velocity_rad_s;
}

double Simulated::measured_position() const {
  return wrapped(shaft_rad_ - zero_rad_ + turns_rad_,
                 static_cast<double>(scale(Register::kPositionRange)));
}

void Simulated::watch(std::int64_t now_ns) {
  const std::int64_t timeout_ns =
      static_cast<std::int64_t>(integer(Register::kTimeout)) * kTimeoutUnitNs;
  if (enabled() && timeout_ns > 0 && now_ns - last_command_ns_ > timeout_ns) {
    fall_into(Status::kCommunicationLost);
  }
}

double Simulated::torque_nm(std::int64_t now_ns) {
  watch(now_ns);
  if (!enabled()) {
    return 0.0;
  }
  const auto position = static_cast<float>(measured_position());
  const auto velocity = static_cast<float>(shaft_rad_s_);
  const float wanted = command_.stiffness * (command_.position - position) +
                       command_.damping * (command_.velocity - velocity) + command_.torque;
  const float limit = scale(Register::kTorqueRange);
  return static_cast<double>(std::clamp(wanted, -limit, limit));
}

std::size_t Simulated::receive(const Frame& frame, std::int64_t now_ns, std::span<Frame> out) {
  if (frame.error || frame.extended || frame.fd != fd_ || out.empty()) {
    return 0;
  }
  watch(now_ns);
  if (frame.id == kRegisterId) {
    return serve_register(frame, now_ns, out[0]);
  }
  const std::uint32_t id = integer(Register::kId);
  const std::uint32_t mode = integer(Register::kControlMode);
  if (frame.id == id && frame.length == 8) {
    obey(frame, now_ns);
  } else if (mode > 1 && mode <= 4 && frame.id == id + kModeOffset * (mode - 1)) {
    last_command_ns_ = now_ns;  // answered; the drive's own loops are not simulated
  } else {
    return 0;
  }
  out[0] = state_report(now_ns);
  return 1;
}

void Simulated::obey(const Frame& frame, std::int64_t now_ns) {
  last_command_ns_ = now_ns;
  if (!ends_in_special(frame)) {
    if (enabled() && integer(Register::kControlMode) == 1) {
      const auto signed_value = [this, &frame](Field field, Register range) {
        return uint_to_float(bits_at(frame, field), -scale(range), scale(range), field.bits);
      };
      command_.position = signed_value(mit::kPosition, Register::kPositionRange);
      command_.velocity = signed_value(mit::kVelocity, Register::kVelocityRange);
      command_.torque = signed_value(mit::kTorque, Register::kTorqueRange);
      command_.stiffness =
          uint_to_float(bits_at(frame, mit::kStiffness), 0.0F,
                        static_cast<float>(mit::kMaxStiffness), mit::kStiffness.bits);
      command_.damping = uint_to_float(bits_at(frame, mit::kDamping), 0.0F,
                                       static_cast<float>(mit::kMaxDamping), mit::kDamping.bits);
    }
    return;
  }
  switch (static_cast<Special>(frame.data[7])) {
    case Special::kEnable:
      if (status_ == Status::kDisabled) {
        status_ = Status::kEnabled;
        command_ = {};
      }
      break;
    case Special::kDisable:
      if (enabled()) {
        fall_into(Status::kDisabled);
      }
      break;
    case Special::kSetZero:
      zero_rad_ = shaft_rad_;
      turns_rad_ = 0.0;
      break;
    case Special::kClearError:
      if (!enabled()) {
        fall_into(heats() ? Status::kRotorOverTemperature : Status::kDisabled);
      }
      break;
  }
}

std::size_t Simulated::serve_register(const Frame& frame, std::int64_t now_ns, Frame& out) {
  const std::uint32_t addressed = frame.data[0] | static_cast<std::uint32_t>(frame.data[1]) << 8U;
  if (frame.length != 8 || addressed != integer(Register::kId)) {
    return 0;
  }
  const auto operation = static_cast<Operation>(frame.data[2]);
  if (operation == Operation::kState) {
    out = state_report(now_ns);
    return 1;
  }
  const std::uint8_t number = frame.data[3];
  const RegisterFact* fact = find_register(number);
  if (operation == Operation::kSave) {
    if (enabled()) {
      return 0;
    }
    flash_ = ram_;
  } else if (fact == nullptr || (operation != Operation::kRead && operation != Operation::kWrite)) {
    return 0;
  } else if (operation == Operation::kWrite && fact->writable) {
    ram_[number] = little(frame, 4);
  }
  out = reply();
  std::copy_n(frame.data.begin(), 4, out.data.begin());
  if (operation == Operation::kSave) {
    out.data[3] = 1;
    return 1;
  }
  for (std::size_t i = 0; i < 4; ++i) {
    out.data[4 + i] = static_cast<std::uint8_t>(ram_[number] >> (8U * i) & 0xFFU);
  }
  return 1;
}

Frame Simulated::reply() const {
  Frame frame;
  frame.id = integer(Register::kReplyId) & 0x7FFU;  // whatever is written there, it has 11 bits
  frame.fd = fd_;
  frame.bit_rate_switch = fd_;
  frame.length = 8;
  return frame;
}

Frame Simulated::state_report(std::int64_t now_ns) {
  const auto torque = static_cast<float>(torque_nm(now_ns));
  Frame frame = reply();
  const auto put = [this, &frame](Field field, float value, Register range) {
    put_bits(frame, field, float_to_uint(value, -scale(range), scale(range), field.bits));
  };
  put_bits(frame, report::kStatus, static_cast<std::uint32_t>(status_));
  put_bits(frame, report::kMotor, integer(Register::kId) & 0xFU);
  put(report::kPosition, static_cast<float>(measured_position()), Register::kPositionRange);
  put(report::kVelocity, static_cast<float>(shaft_rad_s_), Register::kVelocityRange);
  put(report::kTorque, torque, Register::kTorqueRange);
  const auto celsius = static_cast<std::uint32_t>(std::clamp(celsius_, 0.0, 255.0));
  put_bits(frame, report::kMosfetTemperature, celsius);
  put_bits(frame, report::kRotorTemperature, celsius);
  return frame;
}

}  // namespace geodesic::drivers::damiao
