// One periodic real-time thread: starts it with everything it needs or says why not, calls
// Cyclic::step at absolute deadlines that keep phase, and counts what happens. Knows nothing of
// what a step does.
#pragma once

#include <pthread.h>
#include <sys/types.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <semaphore>
#include <string>
#include <vector>

#include "rt/histogram.hpp"
#include "rt/realtime_setup.hpp"
#include "rt/refusal.hpp"
#include "rt/seal.hpp"

namespace geodesic::rt {

/// One cycle's place in time.
struct Tick {
  std::int64_t index = 0;    ///< due_ns = first due_ns + index * period: skipped periods count too
  std::int64_t due_ns = 0;   ///< CLOCK_MONOTONIC (simulated time: the simulated clock) [ns]
  std::int64_t woke_ns = 0;  ///< when the thread really woke; simulated time: due_ns [ns]
  std::int64_t skipped = 0;  ///< periods skipped just before this one
  int refused_call = 0;      ///< number + 1 of a system call refused since the last tick; 0: none
};

enum class Next : std::uint8_t { kContinue, kStop };

/// The work of a loop.
class Cyclic {
 public:
  virtual ~Cyclic() = default;
  /// One cycle. Real-time: no allocation, no lock, no throw, no log, bounded.
  virtual Next step(const Tick& tick) noexcept = 0;

 protected:
  Cyclic() = default;
  Cyclic(const Cyclic&) = default;
  Cyclic& operator=(const Cyclic&) = default;
};

struct ThreadOptions {
  std::string name = "realtime";       ///< as ps and perf show it, of which the first 15 bytes
  std::int64_t period_ns = 1'000'000;  ///< > 0
  int priority = 80;                   ///< SCHED_FIFO, 1 to 99
  std::vector<int> cpus;               ///< pin to these; empty: wherever the kernel likes
  /// Start even where real-time scheduling, locked memory or pinning is refused.
  bool best_effort = false;
  /// Do not sleep: time advances by exactly one period a cycle, however long a step takes. Takes no
  /// real-time priority: a thread that never sleeps would starve whom it waits for.
  bool simulated_time = false;
  /// First due_ns in simulated time. Not 0: a time stamp of 0 says "never" elsewhere in the house.
  std::int64_t simulated_start_ns = 1'000'000'000;
  std::size_t stack_bytes = std::size_t{1} << 20U;  ///< all of it is touched before the loop
  std::size_t heap_prefault_bytes = std::size_t{8} << 20U;  ///< the process' heap grows by it first
  bool hold_cpu_latency = true;  ///< keep processors out of deep sleep while the loop runs
  /// Seal the thread against system calls before its first step (not in a sanitizer's build).
  std::optional<SealOptions> seal;
  /// The process drops its capabilities once start() has returned: the loop's thread drops its own,
  /// and memory is locked so that the limits alone suffice from then on.
  bool drop_capabilities = false;
};

/// Written by the loop's thread, readable by any other one while the loop runs. Each number is
/// right by itself; two read one after the other may be a cycle apart.
struct LoopStatistics {
  std::atomic<std::uint64_t> cycles{0};   ///< steps made
  std::atomic<std::uint64_t> missed{0};   ///< of which overran: ended after the next deadline
  std::atomic<std::uint64_t> skipped{0};  ///< periods without a step, in consequence
  Histogram wake_latency_ns;              ///< from due to awake; empty in simulated time
  Histogram cycle_time_ns;                ///< from awake to the end of the step, on the real clock
  /// Of the loop's thread, minor and major, from the moment before its first step: there is no
  /// grace period. As fresh as the last call of CyclicThread::statistics().
  std::atomic<std::uint64_t> page_faults{0};
  /// Heap calls of the loop's thread (heap_counter.hpp), releases included, from the same moment.
  std::atomic<std::uint64_t> allocations{0};
  /// Whether the thread runs under SCHED_FIFO, pinned as asked, with all memory locked. Final once
  /// start() returns.
  std::atomic<bool> realtime{false};
  /// Whether the thread is sealed. Final once start() returns.
  std::atomic<bool> sealed{false};
  std::atomic<std::uint64_t> refused_calls{0};  ///< system calls the seal did not let through
};

class CyclicThread {
 public:
  explicit CyclicThread(ThreadOptions options);
  /// Requests the stop and waits for it.
  ~CyclicThread();
  CyclicThread(const CyclicThread&) = delete;
  CyclicThread& operator=(const CyclicThread&) = delete;

  /// Sets up memory and scheduling and starts the loop; an object runs one loop in its life. `work`
  /// must outlive the thread. Not real-time.
  /// @return nothing if the loop runs; else why it was refused, and then no thread is left. With
  ///   best_effort only nonsense (options out of range, no thread to be had) is refused, and
  ///   not_realtime_reason() tells what else would have been. Memory that was locked stays locked.
  std::optional<Refusal> start(Cyclic& work);

  /// No step begins after the next one. Any thread, signal handlers too.
  void request_stop() noexcept { stop_requested_.store(true, std::memory_order_relaxed); }
  /// Waits until the loop has ended, by request or by Next::kStop. At once if it never started. One
  /// thread only.
  void join();
  /// Whether the loop goes on: false before start() and once it has ended for whatever reason.
  bool running() const noexcept { return running_.load(std::memory_order_acquire); }

  /// Live figures; any thread. Brings page_faults up to date (reads /proc: not real-time, unless
  /// the loop's own thread calls it, which then is given the figure of the last call).
  const LoopStatistics& statistics() const noexcept;

  /// Why statistics().realtime is false; empty if it is true. Fixed once start() has returned.
  const std::string& not_realtime_reason() const noexcept { return not_realtime_reason_; }
  /// What could be better though the loop runs, a sentence each. Fixed once start() has returned.
  const std::vector<std::string>& warnings() const noexcept { return warnings_; }
  /// Why statistics().sealed is false; empty if it is true. Fixed once start() has returned.
  const std::string& not_sealed_reason() const noexcept { return not_sealed_reason_; }
  /// The next refused system call, as far as they were kept. One thread only, not the loop's.
  bool pop_refused_call(RefusedCall& call) noexcept { return seal_.pop(call); }

 private:
  std::optional<Refusal> check_options() const;
  std::optional<Refusal> launch_as_allowed();
  std::optional<Refusal> prepare_process();
  int launch(bool fifo, bool pinned);
  void abandon();
  std::optional<Refusal> prepare_seal();
  std::optional<Refusal> open_gate();
  void note_not_realtime(const Refusal& refusal);
  static void* enter(void* self);
  void prepare_thread() noexcept;
  bool seal() noexcept;
  void loop() noexcept;
  void linger() noexcept;
  void store_page_faults(std::uint64_t since_birth) const noexcept;

  const ThreadOptions options_;
  Cyclic* work_ = nullptr;
  bool started_ = false;   // a loop was started
  bool joinable_ = false;  // there is a thread to join
  pthread_t thread_{};
  const void* stack_end_ = nullptr;  // of thread_
  std::binary_semaphore gate_{0};    // the thread waits here until the process is prepared
  bool abandoned_ = false;           // written before the gate opens: leave without a step
  CpuLatencyRequest cpu_latency_;
  std::string not_realtime_reason_;
  std::vector<std::string> warnings_;
  Seal seal_;
  bool sealing_ = false;  // written before the gate opens: seal_ is prepared
  std::string not_sealed_reason_;

  std::atomic<bool> stop_requested_{false};
  std::atomic<bool> running_{false};
  std::atomic<bool> joining_{false};  // the ended thread may leave: nobody asks for its figures
  static constexpr int kNotYet = -1;
  std::atomic<int> seal_error_{kNotYet};  // by the loop's thread, once it knows
  std::atomic<pid_t> kernel_thread_{0};   // while the loop runs; 0 else
  std::atomic<std::uint64_t> page_faults_before_{0};
  mutable LoopStatistics statistics_;  // mutable: reading brings page_faults up to date
};

}  // namespace geodesic::rt
