// Torque for a jogged joint; see the header.
#include "tools/geodesic/jog_law.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace geodesic::tools {

using control::DriveCondition;
using control::DriveMode;

void JogLaw::fail(std::string reason) {
  if (phase_ != JogPhase::kFault) reason_ = std::move(reason);
  phase_ = JogPhase::kFault;
}

/// What makes it end. Figures that are not numbers compare false, so each test asks for the good.
void JogLaw::judge(std::int64_t now_ns, const control::JointState& joint) {
  const bool torque = phase_ == JogPhase::kPushing;
  const std::int64_t silent_ns = std::max(kSilentNs, 5 * options_.period_ns);
  if (torque && last_ns_ != 0 && now_ns - last_ns_ > kHeldUpNs) {
    fail(fmt::format("this program was held up for {} ms; the machine is too busy",
                     (now_ns - last_ns_) / 1'000'000));
  } else if (joint.condition == DriveCondition::kRefused) {
    fail("the drive contradicts the robot file");
  } else if (joint.condition == DriveCondition::kError) {
    fail("the drive reports an error");
  } else if (now_ns - joint.stamp_ns > (torque ? silent_ns : 5 * silent_ns)) {
    fail(fmt::format("the drive has been silent for {} ms", (now_ns - joint.stamp_ns) / 1'000'000));
  } else if (!std::isfinite(joint.position) || !std::isfinite(joint.velocity)) {
    fail("the drive's position or velocity is no number");
  } else if (!(joint.temperature_c < options_.temperature_limit_c)) {
    fail(fmt::format("the drive has {:.0f} °C; its limit is {:.0f}", joint.temperature_c,
                     options_.temperature_limit_c));
  } else if (torque && !(std::abs(joint.velocity) <= kOverspeed * options_.velocity)) {
    fail(fmt::format("the joint moves at {:+.3f} a second, {:g} times the bound of {:.3f}",
                     joint.velocity, kOverspeed, options_.velocity));
  } else if (torque && !(joint.position >= options_.lower - options_.overrun &&
                         joint.position <= options_.upper + options_.overrun)) {
    fail(fmt::format("the joint stands at {:+.3f}, beyond the travel from {:+.3f} to {:+.3f}",
                     joint.position, options_.lower, options_.upper));
  } else if (torque && joint.condition != DriveCondition::kEnabled) {
    fail("the drive has left enabled by itself");
  } else if (phase_ == JogPhase::kEnabling && now_ns - since_ns_ > kEnableNs) {
    fail("the drive does not become enabled");
  } else if (phase_ == JogPhase::kIdle && joint.condition == DriveCondition::kEnabled &&
             now_ns - since_ns_ > kDisableNs) {
    fail("the drive does not become disabled");
  }
}

void JogLaw::follow(std::int64_t now_ns, const control::JointState& joint, bool wanted) {
  const JogPhase before = phase_;
  switch (phase_) {
    case JogPhase::kIdle:
      if (wanted && joint.condition == DriveCondition::kDisabled) phase_ = JogPhase::kEnabling;
      break;
    case JogPhase::kEnabling:
      if (joint.condition == DriveCondition::kEnabled) phase_ = JogPhase::kPushing;
      [[fallthrough]];
    case JogPhase::kPushing:
      if (!wanted) phase_ = JogPhase::kIdle;
      break;
    case JogPhase::kFault:
      break;
  }
  if (phase_ != before) {
    since_ns_ = now_ns;
    sign_ = 0.0;
  }
}

double JogLaw::push(std::int64_t now_ns, const control::JointState& joint, double asked) {
  const double sign = asked > 0.0 ? 1.0 : -1.0;
  if (sign != sign_) {
    sign_ = sign;
    ramp_ns_ = now_ns;
  }
  const double bound = std::min(std::abs(asked), options_.torque);
  const double left =
      sign > 0.0 ? options_.upper - joint.position : joint.position - options_.lower;
  const double allowed = sign * std::min(options_.velocity, kApproach * std::max(left, 0.0));
  const double error = std::clamp((allowed - joint.velocity) / options_.velocity, -1.0, 1.0);
  // What brakes does so at once: a load that falls, and the way back after turning round.
  const bool brakes = error * joint.velocity < 0.0;
  const double ramp =
      std::min(1.0, static_cast<double>(now_ns - ramp_ns_) / static_cast<double>(kRampNs));
  return bound * error * (brakes ? 1.0 : ramp);
}

control::JointCommand JogLaw::update(std::int64_t now_ns, const control::JointState& joint,
                                     const JogRequest& request) {
  const std::int64_t age_ns = now_ns - request.stamp_ns;
  const bool wanted = request.torque != 0.0 && std::isfinite(request.torque) &&
                      request.stamp_ns != 0 && age_ns <= kDeadManNs;
  judge(now_ns, joint);
  follow(now_ns, joint, wanted);
  last_ns_ = now_ns;
  torque_ = phase_ == JogPhase::kPushing ? push(now_ns, joint, request.torque) : 0.0;
  const bool enable = phase_ == JogPhase::kPushing || phase_ == JogPhase::kEnabling;
  return {.mode = enable ? DriveMode::kEnable : DriveMode::kDisable, .torque = torque_};
}

const char* to_string(JogPhase phase) {
  switch (phase) {
    case JogPhase::kIdle:
      return "idle";
    case JogPhase::kEnabling:
      return "enabling";
    case JogPhase::kPushing:
      return "pushing";
    case JogPhase::kFault:
      return "fault";
  }
  return "?";
}

}  // namespace geodesic::tools
