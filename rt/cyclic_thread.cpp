// How the real-time thread is started: options checked, privileges tried, memory prepared, and no
// thread left where something was refused. The loop itself is in cyclic_loop.cpp.
#include "rt/cyclic_thread.hpp"

#include <sched.h>
#include <csignal>

#include <cerrno>
#include <utility>

#include "rt/clock.hpp"

namespace geodesic::rt {
namespace {

constexpr std::int64_t kLookNs = 500'000;
/// Of the starting thread, touched where locked memory may not grow without limit.
constexpr std::size_t kStarterStackBytes = std::size_t{512} << 10U;

/// Signals are for the service thread, except those that a thread causes itself.
sigset_t signals_to_block() {
  sigset_t set;
  sigfillset(&set);
  for (const int own : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGTRAP, SIGABRT, SIGSYS}) {
    sigdelset(&set, own);
  }
  return set;
}

cpu_set_t cpu_set_of(const std::vector<int>& cpus) {
  cpu_set_t set;
  CPU_ZERO(&set);
  for (const int cpu : cpus) CPU_SET(static_cast<std::size_t>(cpu), &set);
  return set;
}

Refusal nonsense(const std::string& attempted, const std::string& missing, const std::string& fix,
                 int error_number = EINVAL) {
  return Refusal{attempted, error_number, missing, fix};
}

}  // namespace

CyclicThread::CyclicThread(ThreadOptions options) : options_(std::move(options)) {}

CyclicThread::~CyclicThread() {
  request_stop();
  join();
}

std::optional<Refusal> CyclicThread::start(Cyclic& work) {
  if (auto refusal = check_options()) return refusal;
  work_ = &work;
  not_realtime_reason_.clear();
  warnings_.clear();
  if (options_.simulated_time) {
    not_realtime_reason_ = "simulated time: the loop does not run by the clock";
  }
  // The thread first: it waits at the gate, so that its stack is there when memory is locked.
  if (auto refusal = launch_as_allowed()) return refusal;
  auto refusal = prepare_process();
  if (!refusal) refusal = prepare_seal();
  if (refusal) {
    abandon();
    return refusal;
  }
  statistics_.realtime.store(not_realtime_reason_.empty(), std::memory_order_relaxed);
  return open_gate();
}

std::optional<Refusal> CyclicThread::prepare_seal() {
  if (!options_.seal) {
    not_sealed_reason_ = "not asked for";
  } else if (!kSealBuilt) {
    not_sealed_reason_ = "built for a sanitizer, whose run time makes system calls of its own";
  } else if (auto refusal = seal_.prepare(*options_.seal)) {
    if (!options_.best_effort) return refusal;
    not_sealed_reason_ = to_string(*refusal);
  } else {
    sealing_ = true;
  }
  return std::nullopt;
}

std::optional<Refusal> CyclicThread::open_gate() {
  started_ = true;
  running_.store(true, std::memory_order_release);
  gate_.release();
  // By looking, not by being woken: that would be a system call of the sealed thread's.
  int error = kNotYet;
  while ((error = seal_error_.load(std::memory_order_acquire)) == kNotYet) {
    sleep_until_ns(now_ns() + kLookNs);
  }
  if (error == 0) return std::nullopt;
  const Refusal refusal = explain_seal(error);
  if (options_.best_effort) {
    not_sealed_reason_ = to_string(refusal);
    return std::nullopt;
  }
  running_.store(false, std::memory_order_release);
  join();
  return refusal;
}

void CyclicThread::join() {
  if (joinable_) {
    while (running()) sleep_until_ns(now_ns() + kLookNs);  // as above
    statistics();
    kernel_thread_.store(0, std::memory_order_release);
    joining_.store(true, std::memory_order_release);
    pthread_join(thread_, nullptr);
  }
  joinable_ = false;
  cpu_latency_.release();
}

std::optional<Refusal> CyclicThread::check_options() const {
  const std::string attempted = "to start the loop \"" + options_.name + "\"";
  if (started_) {
    return nonsense(attempted, "a thread object starts once, and this one has been started",
                    "make a new CyclicThread", EBUSY);
  }
  if (options_.period_ns <= 0) {
    return nonsense(attempted + " with a period of " + std::to_string(options_.period_ns) + " ns",
                    "a period above 0", "set a period such as 1000000 ns (1 kHz)");
  }
  if (options_.priority < 1 || options_.priority > 99) {
    return nonsense(attempted + " at priority " + std::to_string(options_.priority),
                    "a SCHED_FIFO priority from 1 to 99",
                    "set 80: above the kernel's interrupt threads (50), below its watchdogs (99)");
  }
  for (const int cpu : options_.cpus) {
    if (cpu < 0 || cpu >= CPU_SETSIZE) {
      return explain_pinning(options_.name, options_.cpus, EINVAL);
    }
  }
  return std::nullopt;
}

std::optional<Refusal> CyclicThread::launch_as_allowed() {
  bool fifo = !options_.simulated_time;
  bool pinned = !options_.cpus.empty();
  while (true) {
    const int error = launch(fifo, pinned);
    if (error == 0) return std::nullopt;
    Refusal refusal;
    if (pinned && error == EINVAL) {
      refusal = explain_pinning(options_.name, options_.cpus, error);
      pinned = false;
    } else if (fifo && error == EPERM) {
      refusal = explain_scheduling(read_privileges(), options_.name, options_.priority, error);
      fifo = false;
    } else {
      return nonsense("to start a thread \"" + options_.name + "\" with a stack of " +
                          std::to_string(options_.stack_bytes) + " bytes (pthread_create)",
                      "room for one more thread, or a stack of a sensible size",
                      "see ulimit -u, TasksMax= of the unit, and the memory that is free", error);
    }
    if (!options_.best_effort) return refusal;
    note_not_realtime(refusal);
  }
}

int CyclicThread::launch(bool fifo, bool pinned) {
  pthread_attr_t attributes;
  if (const int error = pthread_attr_init(&attributes); error != 0) return error;
  int error = pthread_attr_setstacksize(&attributes, options_.stack_bytes);
  const cpu_set_t cpus = cpu_set_of(options_.cpus);
  if (error == 0 && pinned) error = pthread_attr_setaffinity_np(&attributes, sizeof(cpus), &cpus);
  if (error == 0) {
    if (fifo) {  // else inherited, without a call: a container's filter may forbid even to ask
      sched_param parameter{};
      parameter.sched_priority = options_.priority;
      pthread_attr_setinheritsched(&attributes, PTHREAD_EXPLICIT_SCHED);
      pthread_attr_setschedpolicy(&attributes, SCHED_FIFO);
      pthread_attr_setschedparam(&attributes, &parameter);
    }
    const sigset_t blocked = signals_to_block();
    sigset_t before;
    pthread_sigmask(SIG_BLOCK, &blocked, &before);  // inherited by the new thread
    error = pthread_create(&thread_, &attributes, &CyclicThread::enter, this);
    pthread_sigmask(SIG_SETMASK, &before, nullptr);
  }
  pthread_attr_destroy(&attributes);
  if (error != 0) return error;
  joinable_ = true;

  // A cpuset silently takes away processors from the set that was asked for.
  cpu_set_t given;
  CPU_ZERO(&given);
  if (pinned && (pthread_getaffinity_np(thread_, sizeof(given), &given) != 0 ||
                 CPU_EQUAL(&given, &cpus) == 0)) {
    abandon();
    return EINVAL;
  }
  return 0;
}

void CyclicThread::abandon() {
  abandoned_ = true;
  gate_.release();
  join();
  abandoned_ = false;
}

std::optional<Refusal> CyclicThread::prepare_process() {
  const Privileges privileges = read_privileges();
  const bool without_limit = options_.drop_capabilities ? privileges.memlock_limit == kUnlimited
                                                        : privileges.memory_lock_unlimited();
  stack_end_ = stack_end(thread_);
  prefault_heap(options_.heap_prefault_bytes);
  if (!without_limit) {
    // The process' first stack grows by itself, and beyond a limit on locked memory it must not.
    prefault_stack(static_cast<const char*>(__builtin_frame_address(0)) - kStarterStackBytes);
  }
  // In simulated time nothing depends on it: lock only where that cannot get in anybody's way.
  if (!options_.simulated_time || without_limit) {
    const int error =
        lock_memory(without_limit ? LockScope::kPresentAndFuture : LockScope::kPresent);
    if (error != 0 && !options_.simulated_time) {
      const Refusal refusal = explain_memory_lock(privileges, error);
      if (!options_.best_effort) return refusal;
      note_not_realtime(refusal);
    }
    if (error == 0 && !without_limit) {
      warnings_.push_back("RLIMIT_MEMLOCK (" + std::to_string(privileges.memlock_limit) +
                          " bytes) is not unlimited: memory is locked as it was at the start, and "
                          "what this process maps later is not");
    }
  }
  if (options_.hold_cpu_latency && !options_.simulated_time) {
    if (const int error = cpu_latency_.hold(); error != 0) {
      warnings_.push_back(
          "/dev/cpu_dma_latency cannot be held, " + error_text(error) +
          ": processors may sleep deeply and wake tens of microseconds late; let " +
          privileges.user + " write it: echo 'KERNEL==\"cpu_dma_latency\", OWNER=\"" +
          privileges.user + "\"' | sudo tee /etc/udev/rules.d/90-geodesic.rules; " +
          "sudo udevadm control --reload; sudo udevadm trigger --name-match=cpu_dma_latency");
    }
  }
  return std::nullopt;
}

void CyclicThread::note_not_realtime(const Refusal& refusal) {
  if (!not_realtime_reason_.empty()) not_realtime_reason_ += '\n';
  not_realtime_reason_ += to_string(refusal);
}

}  // namespace geodesic::rt
