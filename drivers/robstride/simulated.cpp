// A RobStride or CyberGear drive as the bus sees it, computed as its firmware would: float32,
// truncating encoders. See simulated.hpp; sources and what is assumed: README.md.
#include "drivers/robstride/simulated.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include "drivers/robstride/settings.hpp"

namespace geodesic::drivers::robstride {

namespace {

constexpr std::uint8_t kOverTemperatureFault = 1U << 2U;
constexpr double kHottest = 135.0;
constexpr double kHottestCyberGear = 80.0;
constexpr std::array<std::uint8_t, 8> kMcu{0x30, 0x35, 0x33, 0x36, 0x30, 0x31, 0x12, 0x34};

/// Anybody may configure anything; a drive goes on with its arithmetic.
float sane(double value) {
  return std::isfinite(value) && value > 1e-30 && value < 1e30 ? static_cast<float>(value) : 1.0F;
}

float uint_to_float(std::uint32_t code, float low, float high) {
  return static_cast<float>(code) * (high - low) / 65535.0F + low;
}

std::uint32_t float_to_uint(float value, float low, float high) {
  const float limited = std::min(std::max(value, low), high);
  return static_cast<std::uint32_t>((limited - low) * 65535.0F / (high - low)) & 0xFFFFU;
}

std::uint32_t word_at(const Frame& frame, std::size_t at) {
  return frame.data[at] * 256U + frame.data[at + 1];
}

void put_word(Frame& frame, std::size_t at, std::uint32_t word) {
  frame.data[at] = static_cast<std::uint8_t>(word / 256U & 0xFFU);
  frame.data[at + 1] = static_cast<std::uint8_t>(word % 256U);
}

void put_long(Frame& frame, std::size_t at, std::uint32_t value) {
  for (std::size_t i = 0; i < 4; ++i, value /= 256U) {
    frame.data[at + i] = static_cast<std::uint8_t>(value % 256U);
  }
}

std::uint32_t long_at(const Frame& frame, std::size_t at) {
  return frame.data[at] +
         256U * (frame.data[at + 1] +
                 256U * (frame.data[at + 2] + 256U * std::uint32_t{frame.data[at + 3]}));
}

std::uint32_t width_mask(Value value) {
  switch (value) {
    case Value::kU8:
      return 0xFF;
    case Value::kU16:
    case Value::kI16:
      return 0xFFFF;
    case Value::kU32:
    case Value::kFloat:
      break;
  }
  return 0xFFFFFFFF;
}

/// `angle` moved by whole spans into [low, low + span).
double wrapped(double angle, double low, double span) {
  return angle - span * std::floor((angle - low) / span);
}

}  // namespace

Simulated::Simulated(const DriveOptions& options)
    : scale_{.position = sane(options.position_range_rad),
             .velocity = sane(options.velocity_range_rad_s),
             .torque = sane(options.torque_range_nm),
             .stiffness = sane(options.settings.get(kSettings, kStiffnessRange)),
             .damping = sane(options.settings.get(kSettings, kDampingRange))},
      cybergear_(is_cybergear(options)),
      wraps_(wraps(options.position_range_rad)),
      motor_(options.id & 0xFFU),
      host_(static_cast<std::uint32_t>(options.settings.get(kSettings, kHostId)) & 0xFFU) {
  flash_[place_of(Index::kTorqueLimit)] = std::bit_cast<std::uint32_t>(scale_.torque);
  flash_[place_of(Index::kZeroState)] = 1;
  switch_on();
}

void Simulated::switch_on() {
  ram_ = flash_;
  mode_ = Mode::kReset;
  faults_ = 0;
  command_ = {};
  reports_ = false;
  report_due_ = 0;
  identity_due_ = true;
  zero_rad_ = saved_zero_rad_;
  // The encoder knows the angle within one turn, not the turn; zero_sta says which turn is taken.
  const bool centred = cybergear_ || ram_[place_of(Index::kZeroState)] != 0;
  const double since_zero = shaft_rad_ - zero_rad_;
  turns_rad_ =
      wrapped(since_zero, centred ? -std::numbers::pi : 0.0, 2.0 * std::numbers::pi) - since_zero;
}

void Simulated::power_cycle() {
  switch_on();
}

std::size_t Simulated::place_of(Index index) const {
  const auto* found = find_parameter(static_cast<std::uint16_t>(index));
  return static_cast<std::size_t>(found - kParameters.data());
}

float Simulated::real(Index index) const {
  return std::bit_cast<float>(ram_[place_of(index)]);
}

std::uint32_t Simulated::parameter_raw(std::uint16_t index) const {
  return find_parameter(index) != nullptr ? ram_[place_of(static_cast<Index>(index))] : 0;
}

void Simulated::set_parameter(std::uint16_t index, std::uint32_t raw) {
  if (find_parameter(index) != nullptr) {
    const std::size_t place = place_of(static_cast<Index>(index));
    flash_[place] = raw;
    ram_[place] = raw;
  }
}

bool Simulated::heats() const {
  return celsius_ > (cybergear_ ? kHottestCyberGear : kHottest);
}

void Simulated::set_temperature(double celsius) {
  celsius_ = celsius;
  if (heats()) {
    inject_error(3);
  }
}

void Simulated::stop() {
  mode_ = Mode::kReset;
}

void Simulated::inject_error(std::uint8_t code) {
  if (code == kRebooted) {
    power_cycle();
  } else if (code >= 1 && code <= kFaultBits) {
    faults_ |= 1U << (code - 1U);
    stop();
  } else if (code >= kFirstReported && code < kFirstReported + 32) {
    report_due_ |= 1U << (code - kFirstReported);
    stop();
  } else if (code != 0) {
    stop();
  }
}

void Simulated::set_shaft(double position_rad, double velocity_rad_s) {
  shaft_rad_ = position_rad;
  shaft_rad_s_ = velocity_rad_s;
}

double Simulated::turned() const {
  return shaft_rad_ - zero_rad_ + turns_rad_;
}

double Simulated::reported_position() const {
  return wraps_ ? wrapped(turned(), -0.5 * kWrapRad, kWrapRad) : turned();
}

void Simulated::watch(std::int64_t now_ns) {
  const std::int64_t timeout_ns =
      static_cast<std::int64_t>(ram_[place_of(timeout_index(cybergear_))]) * kTimeoutUnitNs;
  if (enabled() && timeout_ns > 0 && now_ns - last_command_ns_ > timeout_ns) {
    stop();
  }
}

double Simulated::torque_nm(std::int64_t now_ns) {
  watch(now_ns);
  if (!enabled() || (ram_[place_of(Index::kRunMode)] & 0xFFU) != 0) {
    return 0.0;
  }
  const auto position = static_cast<float>(reported_position());
  const auto velocity = static_cast<float>(shaft_rad_s_);
  const float wanted = command_.stiffness * (command_.position - position) +
                       command_.damping * (command_.velocity - velocity) + command_.torque;
  const float told = real(Index::kTorqueLimit);
  const float limit = told >= 0.0F && told < scale_.torque ? told : scale_.torque;
  return static_cast<double>(std::min(std::max(wanted, -limit), limit));
}

std::size_t Simulated::receive(const Frame& frame, std::int64_t now_ns, std::span<Frame> out) {
  if (frame.error || !frame.extended || frame.fd || frame.remote || frame.length != 8 ||
      out.empty() || frame.id % 256U != motor_) {
    return 0;
  }
  watch(now_ns);
  const auto type = static_cast<Type>(frame.id >> 24U);
  if (type == Type::kGetId) {
    identity_due_ = true;
    return speak(now_ns, out.first(1));
  }
  if (type != Type::kControl) {
    host_ = frame.id / 256U % 256U;
  }
  if (type == Type::kRead) {
    out[0] = answer_read(frame);
    return 1;
  }
  if (!obey(frame, now_ns)) {
    return 0;
  }
  out[0] = feedback(now_ns);
  if (type == Type::kStop && version_ && frame.data[0] == 0 &&
      std::equal(kVersionQuery.begin(), kVersionQuery.end(), frame.data.begin())) {
    std::copy(kVersionAnswer.begin(), kVersionAnswer.end(), out[0].data.begin());
    std::copy(version_->begin(), version_->end(), out[0].data.begin() + kVersionAnswer.size());
    out[0].data[7] = 0;
  }
  return 1;
}

/// @return whether it is answered with feedback.
bool Simulated::obey(const Frame& frame, std::int64_t now_ns) {
  last_command_ns_ = now_ns;
  switch (static_cast<Type>(frame.id >> 24U)) {
    case Type::kControl:
      take_command(frame);
      return true;
    case Type::kEnable:
      mode_ = faults_ == 0 ? Mode::kRun : mode_;
      return true;
    case Type::kStop:
      if (frame.data[0] == 1) {
        faults_ = heats() ? kOverTemperatureFault : 0;
      }
      stop();
      return true;
    case Type::kZero:
      if (frame.data[0] == 1) {
        zero_rad_ = shaft_rad_;
        turns_rad_ = 0.0;
      }
      return true;
    case Type::kWrite:
      write(frame);
      return true;
    case Type::kSave:
      flash_ = ram_;
      flash_[place_of(Index::kRunMode)] = 0;  // after power-on it is always operation control
      saved_zero_rad_ = zero_rad_;
      return true;
    case Type::kReport:
      reports_ = !cybergear_ && frame.data[6] == 1;
      next_report_ns_ = now_ns;
      return false;
    default:
      return false;
  }
}

void Simulated::take_command(const Frame& frame) {
  const auto both_ways = [](std::uint32_t code, float range) {
    return uint_to_float(code, -range, range);
  };
  command_.torque = both_ways(frame.id / 256U % 65536U, scale_.torque);
  command_.position = both_ways(word_at(frame, control_bytes::kPosition), scale_.position);
  command_.velocity = both_ways(word_at(frame, control_bytes::kVelocity), scale_.velocity);
  command_.stiffness =
      uint_to_float(word_at(frame, control_bytes::kStiffness), 0.0F, scale_.stiffness);
  command_.damping = uint_to_float(word_at(frame, control_bytes::kDamping), 0.0F, scale_.damping);
}

void Simulated::write(const Frame& frame) {
  const auto index = static_cast<std::uint16_t>(frame.data[0] + 256U * frame.data[1]);
  const Parameter* fact = find_parameter(index);
  if (fact == nullptr || !fact->writable || !knows(index, cybergear_)) {
    return;
  }
  std::uint32_t raw = long_at(frame, 4) & width_mask(fact->value);
  if (index == static_cast<std::uint16_t>(Index::kTorqueLimit)) {
    const float wanted = std::bit_cast<float>(raw);
    raw = std::bit_cast<std::uint32_t>(wanted >= 0.0F ? std::min(wanted, scale_.torque) : 0.0F);
  }
  ram_[place_of(static_cast<Index>(index))] = raw;
}

Frame Simulated::answer_read(const Frame& frame) const {
  const auto index = static_cast<std::uint16_t>(frame.data[0] + 256U * frame.data[1]);
  const Parameter* fact = find_parameter(index);
  const bool known = fact != nullptr && knows(index, cybergear_);
  std::uint32_t raw = known ? ram_[place_of(static_cast<Index>(index))] : 0;
  if (index == static_cast<std::uint16_t>(Index::kPosition)) {
    raw = std::bit_cast<std::uint32_t>(static_cast<float>(turned()));
  } else if (index == static_cast<std::uint16_t>(Index::kVelocity)) {
    raw = std::bit_cast<std::uint32_t>(static_cast<float>(shaft_rad_s_));
  }
  Frame reply = say(17, (known ? 0U : 256U) + motor_, host_);
  reply.data[0] = frame.data[0];
  reply.data[1] = frame.data[1];
  put_long(reply, 4, raw);
  return reply;
}

Frame Simulated::say(std::uint32_t type, std::uint32_t data, std::uint32_t to) const {
  Frame frame;
  frame.id = (type * 65536U + data) * 256U + to;
  frame.extended = true;
  frame.length = 8;
  return frame;
}

Frame Simulated::feedback(std::int64_t now_ns) {
  const auto torque = static_cast<float>(torque_nm(now_ns));
  const std::uint32_t how = static_cast<std::uint32_t>(mode_) * 64U + faults_;
  Frame frame = say(2, how * 256U + motor_, host_);
  const auto put = [&frame](std::size_t at, float value, float range) {
    put_word(frame, at, float_to_uint(value, -range, range));
  };
  put(feedback_bytes::kPosition, static_cast<float>(reported_position()), scale_.position);
  put(feedback_bytes::kVelocity, static_cast<float>(shaft_rad_s_), scale_.velocity);
  put(feedback_bytes::kTorque, torque, scale_.torque);
  put_word(frame, feedback_bytes::kTemperature,
           static_cast<std::uint32_t>(std::min(std::max(celsius_, 0.0), 6553.5) * 10.0));
  return frame;
}

std::size_t Simulated::speak(std::int64_t now_ns, std::span<Frame> out) {
  std::size_t count = 0;
  if (identity_due_ && count < out.size()) {
    identity_due_ = false;
    out[count] = say(0, motor_, kIdentityDestination);
    std::copy(kMcu.begin(), kMcu.end(), out[count++].data.begin());
  }
  if (report_due_ != 0 && count < out.size()) {
    out[count] = say(21, motor_, host_);
    put_long(out[count++], 0, report_due_);
    report_due_ = 0;
  }
  if (reports_ && now_ns >= next_report_ns_ && count < out.size()) {
    const std::uint32_t interval = ram_[place_of(static_cast<Index>(0x7026))];
    next_report_ns_ = now_ns + (10 + 5 * (std::max<std::int64_t>(interval, 1) - 1)) * 1'000'000;
    out[count++] = feedback(now_ns);
  }
  return count;
}

}  // namespace geodesic::drivers::robstride
