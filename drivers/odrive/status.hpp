// What a drive last told of itself: heartbeat, error words, version. No decisions.
#pragma once

#include <cstdint>

#include "drivers/bus/frame.hpp"
#include "drivers/odrive/codec.hpp"
#include "drivers/odrive/errors.hpp"

namespace geodesic::drivers::odrive {

/// Real-time throughout.
class Status {
 public:
  explicit Status(Firmware firmware) noexcept : firmware_(firmware) {}

  /// Takes the frame if it is a heartbeat, an error word or a version; lengths that do not fit are
  /// not taken. @return it was taken.
  bool take(const ReceivedFrame& received) noexcept;
  void forget() noexcept { *this = Status(firmware_); }

  bool error() const noexcept;
  /// The only error is that the watchdog has expired, and, as far as the drive tells, not while it
  /// made torque.
  bool only_watchdog() const noexcept;
  bool watchdog_expired() const noexcept { return (axis_errors & watchdog_bit()) != 0; }
  /// 0: no error.
  std::uint8_t code() const noexcept;
  /// All error words have come since then.
  bool errors_known_since(std::int64_t asked_ns) const noexcept;
  bool position_invalid() const noexcept { return encoder_flag; }

  std::uint32_t heartbeats = 0;  ///< how many
  std::int64_t heartbeat_ns = 0;
  std::int64_t heartbeat_interval_ns = 0;
  std::uint8_t axis_state = kAxisUndefined;
  std::uint8_t result = 0;  ///< 0.6: procedure result
  std::uint32_t axis_errors = 0;
  std::uint32_t disarm_reason = 0;  ///< 0.6
  std::uint64_t motor_errors = 0;   ///< 0.5
  std::uint32_t encoder_errors = 0;
  std::uint32_t controller_errors = 0;
  bool motor_flag = false;
  bool encoder_flag = false;
  bool controller_flag = false;
  std::uint32_t error_answers = 0;  ///< to command 03, how many
  std::uint32_t versions = 0;       ///< answers to command 00
  std::int64_t version_ns = 0;
  std::uint8_t firmware_major = 0;
  std::uint8_t firmware_minor = 0;
  std::uint8_t firmware_revision = 0;

 private:
  std::uint32_t watchdog_bit() const noexcept {
    return firmware_ == Firmware::k06 ? kWatchdog06 : kWatchdog05;
  }
  bool take_heartbeat(const ReceivedFrame& received) noexcept;
  bool take_version(const ReceivedFrame& received) noexcept;

  Firmware firmware_;
  std::int64_t error_ns_ = 0;
  std::int64_t encoder_ns_ = 0;
  std::int64_t controller_ns_ = 0;
};

}  // namespace geodesic::drivers::odrive
