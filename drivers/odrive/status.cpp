// What a drive last told of itself; see status.hpp.
#include "drivers/odrive/status.hpp"

namespace geodesic::drivers::odrive {

namespace {

/// The message's field `index` as an integer of that width; 0 if the frame is too short.
template <class T>
T integer(const Frame& frame, const Message& message, std::size_t index) noexcept {
  return static_cast<T>(decode_bits(frame, message.fields[index]).value_or(0));
}

}  // namespace

bool Status::take(const ReceivedFrame& received) noexcept {
  const Frame& frame = received.frame;
  if (frame.remote || frame.length < 8) {
    return false;
  }
  const bool old = firmware_ == Firmware::k05;
  switch (command_of(frame)) {
    case Command::kVersion:
      return take_version(received);
    case Command::kHeartbeat:
      return take_heartbeat(received);
    case Command::kError:
      ++error_answers;
      error_ns_ = received.stamp_ns;
      if (old) {
        motor_errors = integer<std::uint64_t>(frame, kMotorError05, 0);
      } else {
        axis_errors = integer<std::uint32_t>(frame, kError06, 0);
        disarm_reason = integer<std::uint32_t>(frame, kError06, 1);
      }
      return true;
    case Command::kRxSdo:
      if (old) {
        encoder_errors = integer<std::uint32_t>(frame, kEncoderError05, 0);
        encoder_ns_ = received.stamp_ns;
      }
      return old;
    case Command::kPowers:
      if (old) {
        controller_errors = integer<std::uint32_t>(frame, kControllerError05, 0);
        controller_ns_ = received.stamp_ns;
      }
      return old;
    default:
      return false;
  }
}

bool Status::take_heartbeat(const ReceivedFrame& received) noexcept {
  const Frame& frame = received.frame;
  heartbeat_interval_ns = heartbeats > 0 ? received.stamp_ns - heartbeat_ns : 0;
  ++heartbeats;
  heartbeat_ns = received.stamp_ns;
  axis_errors = integer<std::uint32_t>(frame, kHeartbeat06, 0);
  axis_state = integer<std::uint8_t>(frame, kHeartbeat06, 1);
  if (firmware_ == Firmware::k06) {
    result = integer<std::uint8_t>(frame, kHeartbeat06, 2);
    return true;
  }
  motor_flag = integer<int>(frame, kHeartbeat05, 2) != 0;
  encoder_flag = integer<int>(frame, kHeartbeat05, 3) != 0;
  controller_flag = integer<int>(frame, kHeartbeat05, 4) != 0;
  motor_errors = motor_flag ? motor_errors : 0;
  encoder_errors = encoder_flag ? encoder_errors : 0;
  controller_errors = controller_flag ? controller_errors : 0;
  return true;
}

bool Status::take_version(const ReceivedFrame& received) noexcept {
  ++versions;
  version_ns = received.stamp_ns;
  firmware_major = integer<std::uint8_t>(received.frame, kVersionReport, 4);
  firmware_minor = integer<std::uint8_t>(received.frame, kVersionReport, 5);
  firmware_revision = integer<std::uint8_t>(received.frame, kVersionReport, 6);
  return true;
}

bool Status::error() const noexcept {
  return axis_errors != 0 || disarm_reason != 0 || motor_errors != 0 || encoder_errors != 0 ||
         controller_errors != 0 || motor_flag || encoder_flag || controller_flag;
}

bool Status::only_watchdog() const noexcept {
  return axis_errors == watchdog_bit() && disarm_reason == 0 && motor_errors == 0 &&
         encoder_errors == 0 && controller_errors == 0 && !motor_flag && !encoder_flag &&
         !controller_flag;
}

std::uint8_t Status::code() const noexcept {
  // An expired watchdog follows from many another error, and says less.
  const auto other = [this](std::uint32_t word) {
    return (word & ~watchdog_bit()) != 0 ? word & ~watchdog_bit() : word;
  };
  if (firmware_ == Firmware::k06) {
    return code_of(other(axis_errors != 0 ? axis_errors : disarm_reason), kActiveBase);
  }
  // "motor failed" says less than the motor's own word.
  if (motor_errors != 0) {
    return code_of(motor_errors, kMotorBase);
  }
  if (encoder_errors != 0) {
    return code_of(encoder_errors, kEncoderBase);
  }
  if (controller_errors != 0) {
    return code_of(controller_errors, kControllerBase);
  }
  if (axis_errors != 0) {
    return code_of(other(axis_errors), kAxisBase);
  }
  constexpr unsigned kMotorFailed = 6;
  constexpr unsigned kEncoderFailed = 8;
  constexpr unsigned kControllerFailed = 9;
  const auto at = [](unsigned bit) { return static_cast<std::uint8_t>(kAxisBase + bit); };
  return motor_flag        ? at(kMotorFailed)
         : encoder_flag    ? at(kEncoderFailed)
         : controller_flag ? at(kControllerFailed)
                           : std::uint8_t{0};
}

bool Status::errors_known_since(std::int64_t asked_ns) const noexcept {
  return error_ns_ >= asked_ns &&
         (firmware_ == Firmware::k06 || (encoder_ns_ >= asked_ns && controller_ns_ >= asked_ns &&
                                         heartbeat_ns >= asked_ns && heartbeats > 0));
}

}  // namespace geodesic::drivers::odrive
