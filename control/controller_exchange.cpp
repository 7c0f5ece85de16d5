// Going over from one setup to another while the arm runs, without a step in torque.
#include <cmath>
#include <type_traits>

#include "control/controller_impl.hpp"
#include "control/safety/limits.hpp"

namespace geodesic::control {

/// Whether the arm is within the limits that `next` sets, as far as it is within those of today.
bool Controller::Impl::takes(const Setup& next) const noexcept {
  for (std::size_t i = 0; i < joints; ++i) {
    const SupervisorState state = memory_of(i).state;
    if (state == SupervisorState::kOff || state == SupervisorState::kFault) {
      continue;
    }
    const JointTuning& from = options().joints[i];
    const JointTuning& to = next.options.joints[i];
    const double speed = std::abs(report.velocity[i]);
    if ((outside_limits(to, report.position[i]) && !outside_limits(from, report.position[i])) ||
        (speed > to.velocity_limit && speed <= from.velocity_limit)) {
      return false;
    }
  }
  return true;
}

const Setup* Controller::Impl::exchange(const Setup* next) noexcept {
  const Setup* const before = lent;
  const Setup& from = *setup;
  const Setup& to = next != nullptr ? *next : built_in;
  if (!takes(to)) {
    return next;
  }
  observe();  // the last cycle, by the setup it was made with
  setup = &to;
  lent = next;
  watch.rebase();
  static_assert(std::is_trivially_copyable_v<SafetyOptions>, "copied in the loop");
  for (std::size_t a = 0; a < arms.count; ++a) {
    supervisor.arm[a].safety = to.options.safety;
  }
  estimator.retune(to.options);
  // What the new setup would have wanted in the last cycle, beside what left in it.
  const Eigen::VectorXd& model = compensation(to);
  for (std::size_t i = 0; i < joints; ++i) {
    if (!makes_torque(memory_of(i).state)) {
      continue;
    }
    const JointTuning& tuning = to.options.joints[i];
    const double damping =
        retune[i].damping(from.options.joints[i].drive_damping) - tuning.drive_damping;
    const double wanted =
        memory_of(i).drives_only ? 0.0 : wanted_torque(i, model[static_cast<Eigen::Index>(i)]);
    retune[i].begin(last_torque[i], std::isfinite(wanted) ? wanted : 0.0, tuning.torque_limit,
                    tuning.torque_rate_limit, damping, to.options.retune_s, lowering_scale(i));
  }
  return before;
}

}  // namespace geodesic::control
