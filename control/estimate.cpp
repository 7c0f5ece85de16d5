// Extrapolation to the common instant, velocity low pass, and the test for steps that no joint can
// make. What follows from such a step is the supervisor's business.
#include "control/estimate.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace geodesic::control {
namespace {

// Stamps are only compared; kept where their difference cannot overflow, whatever a caller hands
// in.
constexpr std::int64_t kLatestStamp = std::int64_t{1} << 61;
// A step is judged over no more than this: after a longer silence it would allow anything.
constexpr std::int64_t kLongestGap = 1'000'000'000;

std::int64_t tame(std::int64_t stamp_ns) noexcept {
  return std::clamp<std::int64_t>(stamp_ns, 0, kLatestStamp);
}

bool plausible(const JointState& joint) noexcept {
  // Written so that a NaN is implausible.
  return std::abs(joint.position) <= kImplausible && std::abs(joint.velocity) <= kImplausible &&
         std::abs(joint.torque) <= kImplausible && std::abs(joint.temperature_c) <= kImplausible;
}

}  // namespace

Estimator::Estimator(const ControllerOptions& options)
    : joints_(std::min(options.joints.size(), kMaxJoints)) {
  retune(options);
}

void Estimator::retune(const ControllerOptions& options) noexcept {
  filter_rad_s_ = 2.0 * std::numbers::pi * options.velocity_filter_hz;
  encoder_jump_ = options.safety.encoder_jump;
  carry_on_cycles_ = options.safety.carry_on_cycles;
  for (std::size_t i = 0; i < joints_; ++i) {
    joint_[i].velocity_limit = options.joints[i].velocity_limit;
  }
}

void Estimator::reset(std::uint32_t joints) noexcept {
  estimate_.known &= ~joints;
  for (std::size_t i = 0; i < kMaxJoints; ++i) {
    if ((joints >> i & 1U) != 0) {
      estimate_.velocity[i] = 0.0;
      joint_[i].velocity = 0.0;
      joint_[i].filtered = 0.0;
    }
  }
}

const Estimate& Estimator::update(const ArmState& state, std::int64_t period_ns) noexcept {
  const std::size_t reported = std::min(state.joints, joints_);
  std::int64_t newest_ns = 0;
  estimate_.fresh = 0;
  estimate_.jumped = 0;
  estimate_.not_finite = 0;
  for (std::size_t i = 0; i < joints_; ++i) {
    joint_[i].missed = std::min(joint_[i].missed, 1'000'000) + 1;
    if (i >= reported || !state.joint[i].fresh) {
      continue;
    }
    const JointState& measured = state.joint[i];
    if (!plausible(measured)) {
      estimate_.not_finite |= std::uint32_t{1} << i;
      continue;
    }
    measure(i, measured);
    newest_ns = std::max(newest_ns, joint_[i].stamp_ns);
  }
  // With no answer at all, time still passes.
  estimate_.instant_ns = estimate_.fresh != 0 ? newest_ns : tame(estimate_.instant_ns + period_ns);
  for (std::size_t i = 0; i < joints_; ++i) {
    predict(i, period_ns);
  }
  return estimate_;
}

void Estimator::measure(std::size_t index, const JointState& measured) noexcept {
  Joint& joint = joint_[index];
  const std::uint32_t self = std::uint32_t{1} << index;
  const std::int64_t stamp_ns = tame(measured.stamp_ns);
  const bool known = (estimate_.known & self) != 0;
  if (known) {
    const double dt =
        static_cast<double>(std::clamp<std::int64_t>(stamp_ns - joint.stamp_ns, 0, kLongestGap)) *
        1e-9;
    const double speed = std::min(std::max(std::abs(joint.velocity), std::abs(measured.velocity)),
                                  joint.velocity_limit);
    estimate_.step[index] = measured.position - joint.position;
    estimate_.allowed_step[index] = encoder_jump_ + speed * dt;
    if (std::abs(estimate_.step[index]) > estimate_.allowed_step[index]) {
      estimate_.jumped |= self;
    }
    // After a silence in which the joint was taken to be at rest, the old velocity means nothing.
    const bool continuous = joint.missed <= carry_on_cycles_ + 1;
    const double weight =
        filter_rad_s_ > 0.0 ? filter_rad_s_ * dt / (1.0 + filter_rad_s_ * dt) : 1.0;
    joint.filtered = continuous ? joint.filtered + weight * (measured.velocity - joint.filtered)
                                : measured.velocity;
  } else {
    joint.filtered = measured.velocity;
  }
  joint.position = measured.position;
  joint.velocity = measured.velocity;
  joint.stamp_ns = stamp_ns;
  joint.missed = 0;
  estimate_.known |= self;
  estimate_.fresh |= self;
}

void Estimator::predict(std::size_t index, std::int64_t period_ns) noexcept {
  const Joint& joint = joint_[index];
  const std::int64_t window_ns = carry_on_cycles_ * period_ns;
  const std::int64_t age_ns =
      std::clamp<std::int64_t>(estimate_.instant_ns - joint.stamp_ns, 0, window_ns);
  estimate_.position[index] =
      joint.position + joint.filtered * (static_cast<double>(age_ns) * 1e-9);
  estimate_.velocity[index] = joint.missed > carry_on_cycles_ ? 0.0 : joint.filtered;
}

}  // namespace geodesic::control
