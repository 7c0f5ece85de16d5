// What the real-time thread does: prepares itself, then sleeps, steps and counts. All of it but the
// preparation is real-time code; starting the thread is in cyclic_thread.cpp.
#include <sched.h>
#include <sys/prctl.h>
#include <unistd.h>

#include "rt/capabilities.hpp"
#include "rt/clock.hpp"
#include "rt/cyclic_thread.hpp"
#include "rt/heap_counter.hpp"
#include "rt/schedule.hpp"
#include "rt/thread_health.hpp"

namespace geodesic::rt {
namespace {

/// One writer: a load and a store will do, and cost no locked instruction.
void add(std::atomic<std::uint64_t>& counter, std::int64_t amount) noexcept {
  counter.store(counter.load(std::memory_order_relaxed) + static_cast<std::uint64_t>(amount),
                std::memory_order_relaxed);
}

}  // namespace

void* CyclicThread::enter(void* self) {
  auto& thread = *static_cast<CyclicThread*>(self);
  thread.gate_.acquire();
  if (thread.abandoned_) return nullptr;
  thread.prepare_thread();
  if (!thread.seal()) return nullptr;
  thread.loop();
  thread.linger();
  if (thread.sealing_) exit_thread();
  return nullptr;
}

/// @return whether the loop may begin.
bool CyclicThread::seal() noexcept {
  const int error = sealing_ ? seal_.apply() : 0;
  statistics_.sealed.store(sealing_ && error == 0, std::memory_order_relaxed);
  seal_error_.store(error, std::memory_order_release);
  return error == 0 || options_.best_effort;
}

/// Stays until it is joined: a sealed thread cannot count its own page faults, others can only
/// while it is there.
void CyclicThread::linger() noexcept {
  constexpr std::int64_t kLookNs = 1'000'000;
  running_.store(false, std::memory_order_release);
  while (!joining_.load(std::memory_order_acquire)) sleep_until_ns(now_ns() + kLookNs);
}

void CyclicThread::prepare_thread() noexcept {
  prctl(PR_SET_NAME, options_.name.c_str());
  // Without a real-time class the kernel may delay a timer by 50 us to save power; with one it
  // does not, and this changes nothing.
  prctl(PR_SET_TIMERSLACK, 1UL);
  if (options_.drop_capabilities) drop_thread_capabilities();
  prefault_stack(stack_end_);
  if (options_.simulated_time) {
    // Replies must not interrupt us one by one while we still send: all of them are wanted at once.
    const sched_param none{};
    sched_setscheduler(0, SCHED_BATCH, &none);
  }
  // First calls bind their symbols and bring in their pages here and not in the first cycle.
  sleep_until_ns(now_ns());
  page_faults_before_.store(thread_health().page_faults, std::memory_order_relaxed);
  kernel_thread_.store(gettid(), std::memory_order_release);
}

void CyclicThread::loop() noexcept {
  const bool simulated = options_.simulated_time;
  Schedule schedule(simulated ? options_.simulated_start_ns : now_ns() + options_.period_ns,
                    options_.period_ns);
  const std::uint64_t heap_calls_before = heap_calls();

  Next next = Next::kContinue;
  while (next == Next::kContinue && !stop_requested_.load(std::memory_order_relaxed)) {
    if (!simulated) sleep_until_ns(schedule.due_ns());
    // Simulated time reads no clock: where that is a slow call, it would be most of the cycle.
    const std::int64_t begin_ns = simulated ? schedule.due_ns() : now_ns();
    Tick tick;
    tick.index = schedule.index();
    tick.due_ns = schedule.due_ns();
    tick.woke_ns = begin_ns;
    tick.skipped = schedule.skipped();
    tick.refused_call = seal_.take();
    add(statistics_.skipped, tick.skipped);

    next = work_->step(tick);

    // A simulated cycle ends when it began: it cannot be late.
    const std::int64_t end_ns = simulated ? begin_ns : now_ns();
    if (!simulated) {
      statistics_.wake_latency_ns.add(begin_ns - tick.due_ns);
      statistics_.cycle_time_ns.add(end_ns - begin_ns);
    }
    statistics_.allocations.store(heap_calls() - heap_calls_before, std::memory_order_relaxed);
    statistics_.refused_calls.store(seal_.refused(), std::memory_order_relaxed);
    if (schedule.finish(end_ns)) add(statistics_.missed, 1);
    add(statistics_.cycles, 1);
  }
}

const LoopStatistics& CyclicThread::statistics() const noexcept {
  const pid_t thread = kernel_thread_.load(std::memory_order_acquire);
  if (thread != 0 && pthread_equal(pthread_self(), thread_) == 0) {
    if (const auto faults = page_faults_of(thread)) store_page_faults(*faults);
  }
  return statistics_;
}

void CyclicThread::store_page_faults(std::uint64_t since_birth) const noexcept {
  // Several threads may come with figures of different age: the counter only ever rises.
  const std::uint64_t fresh = since_birth - page_faults_before_.load(std::memory_order_relaxed);
  std::uint64_t known = statistics_.page_faults.load(std::memory_order_relaxed);
  while (known < fresh &&
         !statistics_.page_faults.compare_exchange_weak(known, fresh, std::memory_order_relaxed)) {
  }
}

}  // namespace geodesic::rt
