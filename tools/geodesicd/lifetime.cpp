// The end of the daemon's run.
#include "tools/geodesicd/lifetime.hpp"

namespace geodesic::tools {

using control::SupervisorState;

namespace {

constexpr double kMarginS = 1.0;

bool at_the_end(SupervisorState state) noexcept {
  return state == SupervisorState::kOff || state == SupervisorState::kFault;
}

bool on_the_way(SupervisorState state) noexcept {
  return state == SupervisorState::kStopping || state == SupervisorState::kLowering;
}

}  // namespace

Lifetime::Lifetime(const LifetimeOptions& options) noexcept : options_(options) {
  retune(options.safety);
}

void Lifetime::retune(const control::SafetyOptions& safety) noexcept {
  stop_bound_ns_ = static_cast<std::int64_t>(
      1e9 * (safety.stop_timeout_s + safety.lower_s + safety.settle_timeout_s + kMarginS));
}

Course Lifetime::update(SupervisorState state, bool any_drive_enabled,
                        std::int64_t tick_ns) noexcept {
  if (state == SupervisorState::kActive && !was_active_) {
    was_active_ = true;
    active_ns_ = tick_ns;
  }
  if (torque_off_asked_.load(std::memory_order_relaxed)) {
    torque_off_ = true;
  }
  const bool time_is_up =
      options_.run_ns > 0 && was_active_ && tick_ns - active_ns_ >= options_.run_ns;
  const bool faulted = options_.exit_on_fault && state == SupervisorState::kFault;
  if (!ending() &&
      (time_is_up || faulted || torque_off_ || exit_asked_.load(std::memory_order_relaxed))) {
    ending_.store(true, std::memory_order_relaxed);
    ending_ns_ = tick_ns;
  }
  if (!ending()) {
    return Course::kOnward;
  }
  if (torque_off_ || tick_ns - ending_ns_ > stop_bound_ns_) {
    torque_off_ = true;
    return disabling(Course::kTorqueOff, any_drive_enabled, tick_ns);
  }
  if (at_the_end(state)) {
    return disabling(Course::kOnward, any_drive_enabled, tick_ns);
  }
  return on_the_way(state) ? Course::kOnward : Course::kAskStop;
}

Course Lifetime::disabling(Course meanwhile, bool any_drive_enabled,
                           std::int64_t tick_ns) noexcept {
  if (!disabling_) {
    disabling_ = true;
    disabling_ns_ = tick_ns;
    return meanwhile;  // the command to disable leaves in the next cycle at the earliest
  }
  const bool waited = tick_ns - disabling_ns_ > kDisableGraceNs;
  return !any_drive_enabled || waited ? Course::kOver : meanwhile;
}

}  // namespace geodesic::tools
