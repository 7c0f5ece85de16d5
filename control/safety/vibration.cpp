// Implements vibration.hpp.
#include "control/safety/vibration.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace geodesic::control {
namespace {

constexpr double kPauseSeconds = 0.2;  // the gains settle before they are judged again
constexpr double kFallPerSecond = 20.0;
constexpr double kRisePerSecond = 1.0;
// A crossing is one when the swing has come this part of the threshold to the other side: no
// encoder noise about zero.
constexpr double kCrossing = 0.25;

}  // namespace

Vibration::Vibration(const std::array<BitSet, kMaxJoints>& coupled) noexcept : coupled_(coupled) {}

void Vibration::recover() noexcept {
  for (Joint& joint : joint_) {
    joint.target = 1.0;
    joint.count = 0;
  }
  persistent_ = 0;
}

void Vibration::update(const ControllerOptions& options,
                       const std::array<double, kMaxJoints>& velocity,
                       const std::array<double, kMaxJoints>& torque, BitSet watched,
                       double period_s) noexcept {
  const std::size_t joints = std::min(options.joints.size(), kMaxJoints);
  BitSet found = 0;
  const double slow = std::numbers::pi * options.vibration.lowest_hz * period_s;
  const double weight = slow / (1.0 + slow);  // corner lowest_hz / 2
  for (std::size_t i = 0; i < joints; ++i) {
    Joint& joint = joint_[i];
    const double fall = kFallPerSecond * period_s;
    const double rise = kRisePerSecond * period_s;
    joint.authority = std::clamp(joint.target, joint.authority - fall, joint.authority + rise);
    joint.pause_s = std::max(0.0, joint.pause_s - period_s);
    if (joint.pause_s == 0.0) {
      vibrating_ &= ~bit(i);
    }
    if (!has(watched, i)) {
      continue;
    }
    if (swings(options.vibration, options.joints[i].vibration_velocity, joint, velocity[i],
               torque[i], weight, period_s)) {
      found |= bit(i);
    }
  }
  for (std::size_t i = 0; i < joints; ++i) {
    if (has(found, i) && joint_[i].pause_s == 0.0) {
      lower(options.vibration, i);
    }
  }
}

bool Vibration::swings(const VibrationOptions& options, double threshold, Joint& joint,
                       double velocity, double torque, double weight, double period_s) noexcept {
  if (!joint.started) {
    joint.started = true;
    joint.slow_velocity = velocity;
    joint.slow_torque = torque;
  }
  joint.slow_velocity += weight * (velocity - joint.slow_velocity);
  joint.slow_torque += weight * (torque - joint.slow_torque);
  const double swing = velocity - joint.slow_velocity;
  joint.work += (torque - joint.slow_torque) * 0.5 * (swing + joint.before) * period_s;
  joint.before = swing;
  joint.duration_s += period_s;

  const bool crossed =
      joint.positive ? swing < -kCrossing * threshold : swing > kCrossing * threshold;
  if (!crossed) {
    joint.peak = std::max(joint.peak, std::abs(swing));
    if (joint.duration_s > 0.5 / options.lowest_hz) {
      joint.count = 0;
    }
    return false;
  }
  const bool counts = joint.peak >= threshold && joint.work > 0.0 &&
                      joint.duration_s <= 0.5 / options.lowest_hz &&
                      joint.duration_s >= 0.5 / options.highest_hz;
  joint.count = counts ? std::min(joint.count + 1, 10'000) : joint.count / 2;
  joint.last_peak = counts ? joint.peak : joint.last_peak;
  joint.positive = !joint.positive;
  joint.duration_s = 0.0;
  joint.peak = std::abs(swing);
  joint.work = 0.0;
  return joint.count >= options.half_cycles;
}

void Vibration::lower(const VibrationOptions& options, std::size_t index) noexcept {
  vibrating_ |= bit(index);
  const bool lowest = joint_[index].target <= options.lowest_authority;
  persistent_ |= lowest ? bit(index) : 0;
  const double target = std::max(options.lowest_authority, 0.5 * joint_[index].target);
  for (std::size_t k = 0; k < kMaxJoints; ++k) {
    if (has(coupled_[index], k)) {
      joint_[k].target = target;
      joint_[k].pause_s = kPauseSeconds;
      joint_[k].count = 0;
    }
  }
}

}  // namespace geodesic::control
