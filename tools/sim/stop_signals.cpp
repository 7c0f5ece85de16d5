// SIGINT and SIGTERM as a flag; see the header.
#include "tools/sim/stop_signals.hpp"

#include <pthread.h>

namespace geodesic::tools {
namespace {

std::atomic<bool> g_requested{false};
static_assert(std::atomic<bool>::is_always_lock_free, "set from a signal handler");

extern "C" void geodesic_request_stop(int /*signal*/) {
  g_requested.store(true);
}

}  // namespace

StopSignals::StopSignals() {
  g_requested.store(false);
  sigset_t blocked;
  sigemptyset(&blocked);
  sigaddset(&blocked, SIGINT);
  sigaddset(&blocked, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &blocked, &before_);
  sigdelset(&before_, SIGINT);
  sigdelset(&before_, SIGTERM);
  struct sigaction action {};
  action.sa_handler = geodesic_request_stop;
  sigaction(SIGINT, &action, &old_interrupt_);
  sigaction(SIGTERM, &action, &old_terminate_);
}

StopSignals::~StopSignals() {
  sigaction(SIGINT, &old_interrupt_, nullptr);
  sigaction(SIGTERM, &old_terminate_, nullptr);
  pthread_sigmask(SIG_SETMASK, &before_, nullptr);
}

const std::atomic<bool>& StopSignals::requested() const noexcept {
  return g_requested;
}

}  // namespace geodesic::tools
