// Implements watch.hpp.
#include "control/safety/watch.hpp"

#include <algorithm>
#include <cmath>

namespace geodesic::control {
namespace {

BitSet& present(Flags& flags, Fault fault) noexcept {
  return flags.present[static_cast<std::size_t>(fault)];
}

/// The link that a payload of the joints in `group` would be on.
int payload_link(const Mechanism& mechanism, const ControllerOptions& options,
                 BitSet group) noexcept {
  const auto& links = mechanism.links();
  const auto belongs = [&](const LinkFrame& link) {
    return link.body != kWorld &&
           has(group, static_cast<std::size_t>(
                          mechanism.bodies()[static_cast<std::size_t>(link.body)].dof));
  };
  int last = 0;
  for (std::size_t i = 0; i < links.size(); ++i) {
    if (belongs(links[i])) {
      last = static_cast<int>(i);
      if (links[i].name == options.tool_link) {
        break;
      }
    }
  }
  return last;
}

}  // namespace

Watch::Watch(const Mechanism& mechanism)
    : coupled_(coupled_joints(mechanism)),
      external_(mechanism),
      vibration_(coupled_),
      static_(coupled_) {}

void Watch::restart() noexcept {
  external_.rebase();
  encoder_.reset();
  vibration_.recover();
}

void Watch::observe(const ControllerOptions& options, const Mechanism& mechanism,
                    Workspace& workspace, const WatchInput& input) noexcept {
  const double period_s = static_cast<double>(input.period_ns) * 1e-9;
  const std::size_t joints = std::min(options.joints.size(), kMaxJoints);
  std::array<double, kMaxJoints> velocity{};
  BitSet whole = 0;
  for (std::size_t i = 0; i < joints; ++i) {
    acted_[i] = external_.acting(i);
    velocity[i] =
        has(input.estimate.fresh, i) ? input.state.joint[i].velocity : input.estimate.velocity[i];
    whole |= input.authority[i] >= 1.0 ? bit(i) : 0;
  }
  external_.update(options, mechanism, workspace, input.state, input.estimate, input.sent,
                   input.period_ns);
  encoder_.update(options, input.state, input.estimate);
  vibration_.update(options, velocity, acted_, input.torque & input.estimate.fresh, period_s);
  // While the ramp lasts, what carried the arm before pushes against it: that is no contact.
  contact_.update(options, external_.torque(), external_.observed() & input.active & whole,
                  period_s);
  check_statics(options, mechanism, workspace, input, period_s);
}

void Watch::check_statics(const ControllerOptions& options, const Mechanism& mechanism,
                          Workspace& workspace, const WatchInput& input, double period_s) noexcept {
  const BitSet entering = input.active & ~active_before_;
  active_before_ = input.active;
  if (entering != 0) {
    static_.begin(options, mechanism, workspace, input.estimate.position, entering);
  }
  const BitSet failed_before = static_.failed();
  static_.update(options, {.position = input.estimate.position,
                           .velocity = input.estimate.velocity,
                           .external = external_.torque(),
                           .drive = external_.drive_torque(),
                           .model = input.model,
                           .authority = input.authority,
                           .observed = external_.observed() & input.active,
                           .period_s = period_s});
  const BitSet failed = static_.failed() & ~failed_before;
  for (std::size_t i = 0; failed != 0 && i < options.joints.size(); ++i) {
    if (has(static_.reversed(), i)) {
      suspicion_[i] = {Suspect::kWrongSign, 0.0};
    } else if (has(failed, i)) {
      suspicion_[i] = suspect_load(mechanism, workspace,
                                   {.position = input.estimate.position,
                                    .velocity = input.estimate.velocity,
                                    .external = static_.proven_external(),
                                    .drive = static_.proven_drive()},
                                   coupled_[i], payload_link(mechanism, options, coupled_[i]));
    }
  }
}

void Watch::add_to(Flags& flags) const noexcept {
  present(flags, Fault::kContact) = contact_.touched();
  present(flags, Fault::kVibration) = vibration_.vibrating();
  present(flags, Fault::kVibrationPersists) = vibration_.persistent();
  present(flags, Fault::kStaticTorque) = static_.failed();
  present(flags, Fault::kEncoderStuck) = encoder_.stuck();
}

void Watch::add_evidence(FaultEvent& event, const ControllerOptions& options) const noexcept {
  const auto i = static_cast<std::size_t>(std::max(event.joint, 0));
  if (event.joint < 0 || i >= options.joints.size()) {
    return;
  }
  const JointTuning& tuning = options.joints[i];
  const auto set = [&event](double found, double limit) {
    event.found = std::isfinite(found) ? found : 0.0;
    event.limit = std::isfinite(limit) ? limit : 0.0;
  };
  switch (event.fault) {
    case Fault::kContact:
      return set(external_.torque()[i], tuning.contact_torque);
    case Fault::kVibration:
    case Fault::kVibrationPersists:
      return set(vibration_.swing(i), tuning.vibration_velocity);
    case Fault::kStaticTorque:
      set(static_.excess(i), tuning.static_torque_tolerance);
      event.suspicion = suspicion_[i];
      return;
    case Fault::kEncoderStuck:
      return set(encoder_.way(i), options.safety.encoder_stuck);
    default:
      break;
  }
}

}  // namespace geodesic::control
