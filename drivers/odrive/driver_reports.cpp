// What an ODrive's reports mean to its driver; see driver.hpp. What is sent: driver.cpp.
#include <algorithm>
#include <cmath>

#include "drivers/odrive/driver.hpp"

namespace geodesic::drivers::odrive {

using control::DriveCondition;

namespace {
/// An idle watchdog is told of in heartbeats that were on their way when it was cleared.
constexpr std::uint32_t kToleratedHeartbeats = 2;
}  // namespace

bool Driver::receive(const ReceivedFrame& received) noexcept {
  const Frame& frame = received.frame;
  if (frame.error || frame.extended || frame.remote || frame.fd || node_of(frame) != options_.id) {
    return false;
  }
  const Command command = command_of(frame);
  const bool heartbeat = command == Command::kHeartbeat && status_.take(received);
  if (!heartbeat) {
    status_.take(received);
  }
  last_heard_ns_ = received.stamp_ns;
  bool report = false;
  if (phase_ == Phase::kStartUp) {
    start_up_.receive(received, status_);
  } else if (heartbeat) {
    take_heartbeat();
  }
  if (command == Command::kEstimates) {
    report = take_estimates(received);
  } else if (command == settings_.torque_command()) {
    take_torque(frame);
  } else if (command == Command::kTemperature && settings_.firmware == Firmware::k06) {
    const double inverter_c = decode(frame, kTemperature06.fields[0]).value_or(0.0);
    const double motor_c = decode(frame, kTemperature06.fields[1]).value_or(0.0);
    state_.temperature_c = std::max(std::isfinite(inverter_c) ? inverter_c : 0.0,
                                    std::isfinite(motor_c) ? motor_c : 0.0);  // no thermistor: NaN
  }
  update_condition();
  return report;
}

bool Driver::take_estimates(const ReceivedFrame& received) noexcept {
  const auto position_rev = decode(received.frame, kEstimates.fields[0]);
  const auto velocity_rev_s = decode(received.frame, kEstimates.fields[1]);
  const bool meaningful =
      phase_ != Phase::kRefused && (phase_ != Phase::kStartUp || start_up_.firmware_verified());
  // 0.6 sends NaN without a valid estimate, 0.5 sends 0.
  if (!meaningful || !position_rev || !velocity_rev_s || !std::isfinite(*position_rev) ||
      !std::isfinite(*velocity_rev_s) || status_.position_invalid()) {
    return false;
  }
  state_.position_rad = *position_rev * kTurn;
  state_.velocity_rad_s = *velocity_rev_s * kTurn;
  state_.stamp_ns = received.stamp_ns;
  if (settings_.torque_feedback == TorqueFeedback::kNone && phase_ != Phase::kEnabled) {
    state_.torque_nm = 0.0;
  }
  return true;
}

void Driver::take_torque(const Frame& frame) noexcept {
  if (settings_.torque_feedback == TorqueFeedback::kNone) {
    return;
  }
  const bool by_current = settings_.torque_feedback == TorqueFeedback::kIq;
  const auto measured = decode(frame, by_current ? kIqReport.fields[1] : kTorques06.fields[1]);
  if (measured && std::isfinite(*measured)) {
    state_.torque_nm = by_current ? *measured * settings_.torque_constant_nm_a : *measured;
  }
}

void Driver::take_heartbeat() noexcept {
  const std::uint8_t state = status_.axis_state;
  const bool idle_watchdog = start_up_.idle_expires() && status_.only_watchdog();
  switch (phase_) {
    case Phase::kIdle:
      if (status_.error() && !idle_watchdog) {
        begin_start_up();
      }
      break;
    case Phase::kEnabling:
      if (enables_ == 0 || status_.heartbeat_ns <= requested_ns_) {
        break;
      }
      bad_heartbeats_ += status_.error() ? 1 : 0;
      if (status_.error() && !(idle_watchdog && bad_heartbeats_ <= kToleratedHeartbeats)) {
        leave(status_.heartbeat_ns);
      } else if (state == kAxisClosedLoop && !status_.error()) {
        phase_ = Phase::kEnabled;
      }
      break;
    case Phase::kEnabled:
      if (state != kAxisClosedLoop || status_.error()) {
        leave(status_.heartbeat_ns);
      }
      break;
    case Phase::kDisabling:
      if (zero_sent_ && state != kAxisClosedLoop) {
        phase_ = Phase::kIdle;
        if (status_.error()) {
          leave(status_.heartbeat_ns);
        }
      }
      break;
    case Phase::kStartUp:
    case Phase::kOut:
    case Phase::kRefused:
      break;
  }
}

void Driver::update_condition() noexcept {
  const bool idle_watchdog = start_up_.idle_expires() && status_.only_watchdog();
  state_.error = heartbeat_lost_                     ? kHeartbeatLost
                 : status_.error() && !idle_watchdog ? status_.code()
                                                     : std::uint8_t{0};
  const bool driving = phase_ == Phase::kEnabled ||
                       (phase_ == Phase::kDisabling && status_.axis_state == kAxisClosedLoop);
  if (phase_ == Phase::kRefused) {
    state_.condition = DriveCondition::kRefused;
  } else if (phase_ == Phase::kStartUp && !start_up_.heard()) {
    state_.condition = DriveCondition::kUnknown;
  } else if (phase_ == Phase::kStartUp) {
    state_.condition =
        start_up_.held_by_error() ? DriveCondition::kError : DriveCondition::kConfiguring;
  } else if (state_.error != 0) {
    state_.condition = DriveCondition::kError;
  } else if (driving) {
    state_.condition = DriveCondition::kEnabled;
  } else {
    state_.condition = DriveCondition::kDisabled;
  }
}

}  // namespace geodesic::drivers::odrive
