// SIGINT and SIGTERM as a flag, without a moment in which one could be missed: blocked but while
// waiting in a call that takes a signal mask (ppoll). Starts no thread.
#pragma once

#include <atomic>
#include <csignal>

namespace geodesic::tools {

/// One at a time in a process; to be made before any thread is started, so that all inherit it.
class StopSignals {
 public:
  StopSignals();
  ~StopSignals();
  StopSignals(const StopSignals&) = delete;
  StopSignals& operator=(const StopSignals&) = delete;

  const std::atomic<bool>& requested() const noexcept;
  /// The mask to wait with: lets the two through.
  const sigset_t& waiting_mask() const noexcept { return before_; }

 private:
  sigset_t before_{};
  struct sigaction old_interrupt_ {};
  struct sigaction old_terminate_ {};
};

}  // namespace geodesic::tools
