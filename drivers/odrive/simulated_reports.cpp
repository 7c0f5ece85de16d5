// What a simulated ODrive says, asked and unasked; see simulated.hpp.
#include <algorithm>
#include <cmath>
#include <utility>

#include "drivers/odrive/simulated.hpp"
#include "drivers/odrive/simulated_bytes.hpp"

namespace geodesic::drivers::odrive {

namespace {

constexpr std::uint8_t kConfirmsWrites = 11;  ///< 0.6.11 and on
constexpr std::int64_t kMillisecond = 1'000'000;
constexpr double kBusVoltage = 24.0;

}  // namespace

std::size_t Simulated::serve_sdo(const Frame& frame, std::span<Frame> out) {
  constexpr std::size_t kHead = 4;
  if (frame.length < kHead) {
    return 0;
  }
  const std::uint32_t endpoint = frame.data[1] + 256U * frame.data[2];
  std::size_t at = 0;
  while (at < kParameterCount &&
         (settings_.endpoint[at] == 0 || settings_.endpoint[at] != endpoint)) {
    ++at;
  }
  if (at == kParameterCount) {
    return 0;
  }
  const ParameterType type = kParameterTypes[at];
  const std::size_t bytes = type == ParameterType::kBool ? 1 : 4;
  const bool write = frame.data[0] == kSdoWrite;
  if (write && frame.length >= kHead + bytes) {
    const float real = float_at(frame, kHead);
    ram_.parameters[at] = type == ParameterType::kBool  ? (frame.data[kHead] != 0 ? 1.0 : 0.0)
                          : type == ParameterType::kU32 ? static_cast<double>(word_at(frame, kHead))
                          : std::isfinite(real)         ? static_cast<double>(real)
                                                        : ram_.parameters[at];
  }
  if (write && revision_ < kConfirmsWrites) {
    return 0;
  }
  Frame& reply = out[0];
  reply = {};
  reply.id = node_ << kCommandBits | static_cast<std::uint32_t>(Command::kTxSdo);
  reply.length = static_cast<std::uint8_t>(kHead + (write ? 0 : bytes));
  put_word(reply, 1, endpoint, 2);
  if (!write) {
    const double value = ram_.parameters[at];
    if (type == ParameterType::kFloat) {
      put_float(reply, kHead, value);
    } else {
      put_word(reply, kHead, static_cast<std::uint64_t>(value), bytes);
    }
  }
  return 1;
}

bool Simulated::report(Command command, std::int64_t now_ns, Frame& out) {
  out = {};
  out.id = node_ << kCommandBits | static_cast<std::uint32_t>(command);
  out.length = 8;
  switch (command) {
    case Command::kVersion:
      out.data = {2, 4, 4, 58, 0, 6, revision_, 0};
      return true;
    case Command::kHeartbeat:
      put_word(out, 0, errors_.axis);
      out.data[4] = state_;
      out.data[5] = old() ? (errors_.motor != 0 ? 1 : 0) : result_;
      out.data[6] = old() && errors_.encoder != 0 ? 1 : 0;
      out.data[7] = old() ? static_cast<std::uint8_t>(128 + (errors_.controller != 0 ? 1 : 0)) : 0;
      return true;
    case Command::kError:
      if (old()) {
        put_word(out, 0, errors_.motor, 8);
      } else {
        put_word(out, 0, errors_.axis);
        put_word(out, 4, errors_.disarm);
      }
      return true;
    case Command::kRxSdo:
      put_word(out, 0, errors_.encoder);
      return true;
    case Command::kTxSdo:
      return true;
    case Command::kEstimates:
      put_float(out, 0, estimate_valid_ ? position_rev() : (old() ? 0.0 : std::nan("")));
      put_float(out, 4, estimate_valid_ ? shaft_rev_s_ : (old() ? 0.0 : std::nan("")));
      return true;
    case Command::kIq:
      put_float(out, 0, current_a(now_ns));
      put_float(out, 4, current_a(now_ns));
      return true;
    case Command::kTemperature:
      put_float(out, 0, celsius_);
      put_float(out, 4, celsius_);
      return true;
    case Command::kBus:
      put_float(out, 0, kBusVoltage);
      return true;
    case Command::kTorques:
      put_float(out, 0, enabled() ? static_cast<double>(input_torque_nm_) : 0.0);
      put_float(out, 4, torque_nm(now_ns));
      return true;
    case Command::kPowers:
      put_word(out, 0, old() ? errors_.controller : 0);
      return true;
    default:
      return false;
  }
}

std::size_t Simulated::speak(std::int64_t now_ns, std::span<Frame> out) {
  if (!awake(now_ns)) {
    return 0;
  }
  watch(now_ns);
  const bool cyclic_torque = !old() && settings_.torque_feedback != TorqueFeedback::kNone;
  const std::array<std::pair<Command, double>, 3> timers = {{
      {Command::kHeartbeat, parameter(Parameter::kHeartbeatRate)},
      {Command::kEstimates, parameter(Parameter::kEncoderRate)},
      {settings_.torque_command(), cyclic_torque ? parameter(Parameter::kTorqueRate) : 0.0},
  }};
  std::size_t count = 0;
  for (std::size_t i = 0; i < timers.size() && count < out.size(); ++i) {
    const double milliseconds = std::min(timers[i].second, 1e6);
    const std::int64_t period_ns = static_cast<std::int64_t>(milliseconds) * kMillisecond;
    std::int64_t& next_ns = next_ns_[i];
    if (period_ns <= 0) {
      next_ns = -1;
      continue;
    }
    if (next_ns < 0 || next_ns > now_ns + period_ns) {
      // Its clock is its own: nobody's phase is another's. A heartbeat tells that it has booted.
      const std::int64_t phase_ns =
          (static_cast<std::int64_t>(node_) * 7 + 3) % 10 * period_ns / 10;
      next_ns = i == 0 && ready_ns_ >= 0 ? now_ns : now_ns + phase_ns;
    }
    if (now_ns < next_ns) {
      continue;
    }
    next_ns += period_ns;
    next_ns = next_ns + 4 * period_ns < now_ns ? now_ns + period_ns : next_ns;
    count += report(timers[i].first, now_ns, out[count]) ? 1 : 0;
  }
  return count;
}

}  // namespace geodesic::drivers::odrive
