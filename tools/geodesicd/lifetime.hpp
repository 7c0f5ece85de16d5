// When the daemon's run ends, and how: never but by a controlled stop, unless somebody insists. It
// decides; Daemon acts. Pure in its inputs but for two flags that other threads may raise.
#pragma once

#include <atomic>
#include <cstdint>

#include "control/options.hpp"
#include "control/safety/supervisor.hpp"

namespace geodesic::tools {

struct LifetimeOptions {
  std::int64_t run_ns = 0;  ///< a controlled stop so long after the first `active`; 0: no end
  bool exit_on_fault = false;
  control::SafetyOptions safety;
};

/// What the real-time thread is to do after this cycle.
enum class Course : std::uint8_t {
  kOnward,     ///< go on; also while a stop is under way
  kAskStop,    ///< ask the controller for a controlled stop
  kTorqueOff,  ///< disable every drive, whatever the controller says
  kOver,       ///< drives are disabled, or do not answer any more: end
};

class Lifetime {
 public:
  explicit Lifetime(const LifetimeOptions& options) noexcept;

  /// Ends the run by a controlled stop. Any thread, any number of times.
  void ask_exit() noexcept { exit_asked_.store(true, std::memory_order_relaxed); }
  /// Ends the run with torque off at once: an arm that is not at rest falls. Any thread.
  void ask_torque_off() noexcept { torque_off_asked_.store(true, std::memory_order_relaxed); }
  /// The run is about to end. Any thread.
  bool ending() const noexcept { return ending_.load(std::memory_order_relaxed); }

  /// Torque was taken off without a controlled stop. Once the real-time thread has ended.
  bool forced() const noexcept { return torque_off_; }

  /// One cycle. Real-time thread only.
  Course update(control::SupervisorState state, bool any_drive_enabled,
                std::int64_t tick_ns) noexcept;

  /// A stop's times have changed. Real-time thread only.
  void retune(const control::SafetyOptions& safety) noexcept;

  /// Longest a controlled stop may take before torque is taken off [ns of ticks].
  std::int64_t stop_bound_ns() const noexcept { return stop_bound_ns_; }
  /// How long drives are asked to disable before the run ends without their answer [ns].
  static constexpr std::int64_t kDisableGraceNs = 200'000'000;

 private:
  Course disabling(Course meanwhile, bool any_drive_enabled, std::int64_t tick_ns) noexcept;

  LifetimeOptions options_;
  std::int64_t stop_bound_ns_ = 0;
  std::atomic<bool> exit_asked_{false};
  std::atomic<bool> torque_off_asked_{false};
  std::atomic<bool> ending_{false};
  bool was_active_ = false;
  bool torque_off_ = false;
  bool disabling_ = false;
  std::int64_t active_ns_ = 0;
  std::int64_t ending_ns_ = 0;
  std::int64_t disabling_ns_ = 0;
};

}  // namespace geodesic::tools
