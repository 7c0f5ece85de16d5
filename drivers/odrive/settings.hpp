// The options that ODrives alone have, and what they say in numbers. What is wrong with them:
// family.cpp.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <string_view>

#include "drivers/drive.hpp"
#include "drivers/odrive/layout.hpp"

namespace geodesic::drivers::odrive {

inline constexpr double kTurn = 2.0 * std::numbers::pi;  ///< [rad/rev]

enum class TorqueFeedback : std::uint8_t { kNone, kTorques, kIq };

inline constexpr std::array<std::string_view, 2> kFirmwares = {"0.6", "0.5"};
inline constexpr std::array<std::string_view, 2> kFeedbacks = {"cyclic", "request"};
inline constexpr std::array<std::string_view, 3> kTorqueFeedbacks = {"none", "torques", "iq"};
inline constexpr std::array<std::string_view, 2> kProofs = {"silence", "trusted"};

enum class Key : std::uint8_t {
  kFirmware,
  kTorqueConstant,
  kCurrentLimit,
  kVelocityLimit,
  kVelocityGain,
  kFeedback,
  kTorqueFeedback,
  kWatchdogProof,
  kPositionPeriod,
  kRevision,
  kFirstEndpoint,  ///< in the order of Parameter
};

inline constexpr double kLastEndpoint = 65535.0;

inline constexpr std::array kSettings = {
    DriveSetting{.key = "firmware",
                 .doc = "Compared with what the drive tells.",
                 .unit = "",
                 .value = 0.0,
                 .choices = kFirmwares},
    DriveSetting{.key = "torque_constant_nm_a",
                 .doc = "The drive's motor.config.torque_constant.",
                 .unit = "N·m/A",
                 .lower = 1e-6,
                 .upper = 1e3,
                 .required = true},
    DriveSetting{.key = "current_limit_a",
                 .doc = "Motor current that the drive is told never to exceed (Set_Limits).",
                 .unit = "A",
                 .lower = 1e-3,
                 .upper = 1e3,
                 .required = true},
    DriveSetting{.key = "velocity_limit_rad_s",
                 .doc =
                     "The drive's own velocity limit (Set_Limits). 0: so high that all torque is "
                     "there up to velocity_range_rad_s.",
                 .unit = "rad/s",
                 .lower = 0.0,
                 .upper = 1e6,
                 .value = 0.0},
    DriveSetting{.key = "velocity_gain_nm_s_rev",
                 .doc = "The drive's controller.config.vel_gain: torque is never more than this "
                        "times what is left to its velocity limit.",
                 .unit = "N·m·s/rev",
                 .lower = 1e-6,
                 .upper = 1e6,
                 .value = 1.0 / 6.0},
    DriveSetting{.key = "feedback",
                 .doc = "Positions by the drive's timer, or asked for in every cycle by a remote "
                        "frame.",
                 .unit = "",
                 .value = 0.0,
                 .choices = kFeedbacks},
    DriveSetting{.key = "torque_feedback",
                 .doc =
                     "Where the reported torque comes from: the last command, Get_Torques (0.6), "
                     "or Get_Iq times torque_constant_nm_a.",
                 .unit = "",
                 .value = 0.0,
                 .choices = kTorqueFeedbacks},
    DriveSetting{.key = "watchdog_proof",
                 .doc = "Where no endpoint tells of the watchdog: fall silent at start-up until it "
                        "expires, or trust that it was set.",
                 .unit = "",
                 .value = 0.0,
                 .choices = kProofs},
    DriveSetting{.key = "position_period_rev",
                 .doc = "What the drive's position may be off by after power-on: whole multiples "
                        "of this. 0: it knows its turns.",
                 .unit = "rev",
                 .lower = 0.0,
                 .upper = 1e4,
                 .value = 1.0},
    DriveSetting{.key = "endpoint_revision",
                 .doc = "Firmware revision that the endpoints are of: 9 for 0.6.9.",
                 .unit = "",
                 .lower = 0.0,
                 .upper = 255.0,
                 .value = 0.0},
    DriveSetting{.key = "endpoint_watchdog_timeout",
                 .doc = "Id of axis0.config.watchdog_timeout; 0: not known.",
                 .unit = "",
                 .lower = 0.0,
                 .upper = kLastEndpoint},
    DriveSetting{.key = "endpoint_enable_watchdog",
                 .doc = "Id of axis0.config.enable_watchdog; 0: not known.",
                 .unit = "",
                 .lower = 0.0,
                 .upper = kLastEndpoint},
    DriveSetting{.key = "endpoint_encoder_rate",
                 .doc = "Id of axis0.config.can.encoder_msg_rate_ms; 0: not known.",
                 .unit = "",
                 .lower = 0.0,
                 .upper = kLastEndpoint},
    DriveSetting{.key = "endpoint_torque_rate",
                 .doc =
                     "Id of axis0.config.can.torques_msg_rate_ms, with torque_feedback \"iq\" of "
                     "iq_msg_rate_ms; 0: not known.",
                 .unit = "",
                 .lower = 0.0,
                 .upper = kLastEndpoint},
    DriveSetting{.key = "endpoint_heartbeat_rate",
                 .doc = "Id of axis0.config.can.heartbeat_msg_rate_ms, then set to 20 ms; 0: not "
                        "known.",
                 .unit = "",
                 .lower = 0.0,
                 .upper = kLastEndpoint},
    DriveSetting{.key = "endpoint_torque_constant",
                 .doc = "Id of axis0.config.motor.torque_constant, compared; 0: not known.",
                 .unit = "",
                 .lower = 0.0,
                 .upper = kLastEndpoint},
};

/// Milliseconds between heartbeats, by default and where endpoint_heartbeat_rate is known.
inline constexpr double kHeartbeatMs = 100.0;
inline constexpr double kQuickHeartbeatMs = 20.0;

/// Real-time.
struct Settings {
  explicit Settings(const DriveOptions& options) noexcept {
    const auto number = [&options](Key key) {
      return options.settings.get(kSettings, static_cast<std::size_t>(key));
    };
    firmware = number(Key::kFirmware) > 0.5 ? Firmware::k05 : Firmware::k06;
    torque_constant_nm_a = number(Key::kTorqueConstant);
    current_limit_a = number(Key::kCurrentLimit);
    const double limit = number(Key::kVelocityLimit);
    velocity_gain_nm_s_rev = number(Key::kVelocityGain);
    least_velocity_limit_rad_s =
        options.velocity_range_rad_s + options.torque_range_nm / velocity_gain_nm_s_rev * kTurn;
    velocity_limit_rad_s =
        limit > 0.0 ? limit
                    : std::max(2.0 * options.velocity_range_rad_s, least_velocity_limit_rad_s);
    by_request = number(Key::kFeedback) > 0.5;
    const double torque = number(Key::kTorqueFeedback);
    torque_feedback = torque > 1.5   ? TorqueFeedback::kIq
                      : torque > 0.5 ? TorqueFeedback::kTorques
                                     : TorqueFeedback::kNone;
    trusts_watchdog = number(Key::kWatchdogProof) > 0.5;
    position_period_rev = number(Key::kPositionPeriod);
    revision = static_cast<std::uint8_t>(number(Key::kRevision));
    for (std::size_t i = 0; i < kParameterCount; ++i) {
      const double id =
          options.settings.get(kSettings, static_cast<std::size_t>(Key::kFirstEndpoint) + i);
      endpoint[i] =
          id > 0.0 && id <= kLastEndpoint ? static_cast<std::uint16_t>(id) : std::uint16_t{0};
    }
  }

  bool knows(Parameter parameter) const noexcept {
    return endpoint[static_cast<std::size_t>(parameter)] != 0;
  }
  /// Torque is reported by the drive's timer: 0.5 has none for it.
  bool cyclic_torque() const noexcept {
    return torque_feedback != TorqueFeedback::kNone && !by_request && firmware == Firmware::k06;
  }
  bool requests_torque() const noexcept {
    return torque_feedback != TorqueFeedback::kNone && !cyclic_torque();
  }
  Command torque_command() const noexcept {
    return torque_feedback == TorqueFeedback::kIq ? Command::kIq : Command::kTorques;
  }
  double heartbeat_ms() const noexcept {
    return knows(Parameter::kHeartbeatRate) ? kQuickHeartbeatMs : kHeartbeatMs;
  }

  Firmware firmware = Firmware::k06;
  double torque_constant_nm_a = 0.0;
  double current_limit_a = 0.0;
  double velocity_limit_rad_s = 0.0;
  double velocity_gain_nm_s_rev = 0.0;
  double least_velocity_limit_rad_s = 0.0;  ///< below it torque is taken away within the range
  bool by_request = false;
  TorqueFeedback torque_feedback = TorqueFeedback::kNone;
  bool trusts_watchdog = false;
  double position_period_rev = 1.0;
  std::uint8_t revision = 0;
  std::array<std::uint16_t, kParameterCount> endpoint{};
};

}  // namespace geodesic::drivers::odrive
