// The real thread on the real kernel: it starts, keeps phase, stays clean, or is refused in words.
// The machine may be busy: nothing here asserts how long anything takes.
#include "rt/cyclic_thread.hpp"

#include <gtest/gtest.h>
#include <sched.h>
#include <sys/capability.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "rt/clock.hpp"
#include "tests/rt/child.hpp"

namespace geodesic::rt {
namespace {

/// Counts to a number of cycles and keeps every tick.
class Counter : public Cyclic {
 public:
  explicit Counter(std::size_t cycles) { ticks_.reserve(cycles); }
  Next step(const Tick& tick) noexcept override {
    ticks_.push_back(tick);  // within what was reserved: does not allocate
    sched_getparam(0, &parameter_);
    policy_ = sched_getscheduler(0);
    pthread_getname_np(pthread_self(), name_.data(), name_.size());
    if (on_step) on_step(tick);
    return ticks_.size() < ticks_.capacity() ? Next::kContinue : Next::kStop;
  }
  std::function<void(const Tick&)> on_step;
  std::vector<Tick> ticks_;
  sched_param parameter_{};
  int policy_ = -1;
  std::array<char, 16> name_{};
};

ThreadOptions options_of(std::int64_t period_ns) {
  ThreadOptions options;
  options.name = "test loop";
  options.period_ns = period_ns;
  options.best_effort = true;  // the tests also run where nobody is privileged
  return options;
}

std::size_t threads_of_this_process() {
  const std::filesystem::directory_iterator tasks("/proc/self/task");
  return static_cast<std::size_t>(std::distance(begin(tasks), end(tasks)));
}

TEST(CyclicThread, CleanLoopOf200Cycles) {
  Counter work(200);
  CyclicThread thread(options_of(1'000'000));
  ASSERT_FALSE(thread.start(work).has_value());
  while (thread.running()) {
    const LoopStatistics& live = thread.statistics();  // under the loop's feet, for ThreadSanitizer
    EXPECT_LE(live.cycles.load(), 200U);
    EXPECT_GE(live.wake_latency_ns.percentile(99.9), 0);
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  thread.join();

  const LoopStatistics& statistics = thread.statistics();
  EXPECT_EQ(statistics.cycles, 200U);
  EXPECT_EQ(statistics.wake_latency_ns.count(), 200U);
  EXPECT_EQ(statistics.cycle_time_ns.count(), 200U);
  EXPECT_EQ(statistics.allocations, 0U);
  EXPECT_STREQ(work.name_.data(), "test loop");
  EXPECT_EQ(statistics.realtime, thread.not_realtime_reason().empty());
  if (statistics.realtime) {
    EXPECT_EQ(work.policy_, SCHED_FIFO);
    EXPECT_EQ(work.parameter_.sched_priority, 80);
  }
  if (statistics.realtime && test::locked_pages_never_fault()) {
    EXPECT_EQ(statistics.page_faults, 0U);
  }

  std::int64_t skipped = 0;
  for (const Tick& tick : work.ticks_) {
    EXPECT_EQ(tick.due_ns, work.ticks_[0].due_ns + tick.index * 1'000'000);
    EXPECT_GE(tick.woke_ns, tick.due_ns);
    skipped += tick.skipped;
  }
  EXPECT_EQ(work.ticks_.back().index, 199 + skipped);
  EXPECT_EQ(statistics.skipped, static_cast<std::uint64_t>(skipped));
}

TEST(CyclicThread, OverrunsSkipWholePeriods) {
  Counter work(20);
  work.on_step = [](const Tick& tick) {
    // The fifth cycle takes three and a half periods.
    if (tick.index == 5) sleep_until_ns(tick.due_ns + 7'000'000);
  };
  CyclicThread thread(options_of(2'000'000));
  ASSERT_FALSE(thread.start(work).has_value());
  thread.join();
  std::int64_t skipped = 0;
  for (const Tick& tick : work.ticks_) {
    EXPECT_EQ((tick.due_ns - work.ticks_[0].due_ns) % 2'000'000, 0);
    skipped += tick.skipped;
  }
  // On a busy machine the loop may have skipped the fifth itself, and more than once.
  EXPECT_GE(skipped, 1);
  EXPECT_EQ(thread.statistics().skipped, static_cast<std::uint64_t>(skipped));
  EXPECT_GE(thread.statistics().missed, 1U);
  EXPECT_LE(thread.statistics().missed, thread.statistics().skipped);
}

TEST(CyclicThread, DirtIsCounted) {
  constexpr std::size_t kBytes = std::size_t{1} << 16U;
  void* const fresh =
      mmap(nullptr, kBytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  ASSERT_NE(fresh, MAP_FAILED);
  Counter work(10);
  work.on_step = [&work, fresh](const Tick&) {
    if (work.ticks_.size() != 1) return;  // the very first cycle: no grace period
    void* const block = std::malloc(100);
    asm volatile("" : : "g"(block) : "memory");
    std::free(block);
    munlock(fresh, kBytes);
    madvise(fresh, kBytes, MADV_DONTNEED);
    *static_cast<volatile char*>(fresh) = 1;
  };
  CyclicThread thread(options_of(1'000'000));
  ASSERT_FALSE(thread.start(work).has_value());
  while (thread.running()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  thread.join();
  munmap(fresh, kBytes);
  EXPECT_EQ(thread.statistics().allocations, 2U);
  EXPECT_GE(thread.statistics().page_faults, 1U);
}

TEST(CyclicThread, RequestStopsIt) {
  Counter work(1'000'000);
  CyclicThread thread(options_of(1'000'000));
  EXPECT_FALSE(thread.running());
  ASSERT_FALSE(thread.start(work).has_value());
  EXPECT_TRUE(thread.running());
  while (thread.statistics().cycles < 3) std::this_thread::yield();
  thread.request_stop();
  thread.join();
  EXPECT_FALSE(thread.running());
  EXPECT_EQ(thread.statistics().cycles, work.ticks_.size());
}

TEST(CyclicThread, SignalsGoToOtherThreads) {
  Counter work(1);
  sigset_t blocked;
  sigemptyset(&blocked);
  work.on_step = [&blocked](const Tick&) { pthread_sigmask(SIG_SETMASK, nullptr, &blocked); };
  CyclicThread thread(options_of(1'000'000));
  ASSERT_FALSE(thread.start(work).has_value());
  thread.join();
  EXPECT_EQ(sigismember(&blocked, SIGINT), 1);
  EXPECT_EQ(sigismember(&blocked, SIGTERM), 1);
  EXPECT_EQ(sigismember(&blocked, SIGSEGV), 0);
}

TEST(CyclicThread, SimulatedTimeAdvancesOnePeriodACycle) {
  Counter work(500);
  work.on_step = [](const Tick& tick) {
    if (tick.index == 5) sleep_until_ns(now_ns() + 5'000'000);  // however long a step takes
  };
  ThreadOptions options = options_of(1'000'000);
  options.simulated_time = true;
  options.best_effort = false;
  CyclicThread thread(options);
  ASSERT_FALSE(thread.start(work).has_value());
  thread.join();
  for (std::size_t i = 0; i < work.ticks_.size(); ++i) {
    const auto index = static_cast<std::int64_t>(i);
    EXPECT_EQ(work.ticks_[i].index, index);
    EXPECT_EQ(work.ticks_[i].due_ns, options.simulated_start_ns + index * 1'000'000);
    EXPECT_EQ(work.ticks_[i].woke_ns, work.ticks_[i].due_ns);
    EXPECT_EQ(work.ticks_[i].skipped, 0);
  }
  const LoopStatistics& statistics = thread.statistics();
  EXPECT_EQ(statistics.cycles, 500U);
  EXPECT_EQ(statistics.missed, 0U);
  EXPECT_EQ(statistics.skipped, 0U);
  EXPECT_EQ(statistics.allocations, 0U);
  EXPECT_EQ(statistics.wake_latency_ns.count(), 0U);
  EXPECT_EQ(statistics.cycle_time_ns.count(), 0U);
  EXPECT_FALSE(statistics.realtime);
  EXPECT_NE(thread.not_realtime_reason().find("simulated time"), std::string::npos);
  EXPECT_NE(work.policy_, SCHED_FIFO);
}

TEST(CyclicThread, NonsenseIsRefusedEvenByBestEffort) {
  const auto refusal_of = [](const std::function<void(ThreadOptions&)>& spoil) {
    ThreadOptions options = options_of(1'000'000);
    spoil(options);
    Counter work(1);
    CyclicThread thread(options);
    const auto refusal = thread.start(work);
    EXPECT_TRUE(work.ticks_.empty() || !refusal);
    return refusal ? to_string(*refusal) : std::string();
  };
  EXPECT_NE(refusal_of([](auto& options) { options.period_ns = 0; }).find("period above 0"),
            std::string::npos);
  EXPECT_NE(refusal_of([](auto& options) { options.priority = 100; }).find("from 1 to 99"),
            std::string::npos);
  EXPECT_NE(refusal_of([](auto& options) { options.cpus = {-1}; }).find("processors -1"),
            std::string::npos);
  EXPECT_NE(refusal_of([](auto& options) { options.stack_bytes = 100; }).find("stack of 100 bytes"),
            std::string::npos);
}

TEST(CyclicThread, StartsOnce) {
  Counter work(1);
  CyclicThread thread(options_of(1'000'000));
  ASSERT_FALSE(thread.start(work).has_value());
  const auto again = thread.start(work);
  ASSERT_TRUE(again.has_value());
  EXPECT_EQ(again->error_number, EBUSY);
}

TEST(CyclicThread, AbsentProcessorIsRefused) {
  const std::size_t before = threads_of_this_process();
  ThreadOptions options = options_of(1'000'000);
  options.simulated_time = true;  // needs no privilege, so that pinning alone is in question
  options.best_effort = false;
  options.cpus = {0, CPU_SETSIZE - 1};
  {
    Counter work(1);
    CyclicThread thread(options);
    const auto refusal = thread.start(work);
    ASSERT_TRUE(refusal.has_value());
    EXPECT_NE(to_string(*refusal).find("it may use " + usable_cpus()), std::string::npos);
    EXPECT_EQ(threads_of_this_process(), before);
    EXPECT_TRUE(work.ticks_.empty());
  }
  options.best_effort = true;
  Counter work(1);
  CyclicThread thread(options);
  EXPECT_FALSE(thread.start(work).has_value());
  thread.join();
  EXPECT_EQ(work.ticks_.size(), 1U);
  EXPECT_NE(thread.not_realtime_reason().find("to pin the thread"), std::string::npos);
}

TEST(CyclicThread, RefusedWithoutCapSysNice) {
  const std::string report = test::in_child([] {
    test::drop({CAP_SYS_NICE, CAP_IPC_LOCK});
    test::limit(RLIMIT_RTPRIO, 0);
    const std::size_t before = threads_of_this_process();
    Counter work(1);
    ThreadOptions options = options_of(1'000'000);
    options.best_effort = false;
    CyclicThread thread(options);
    const auto refusal = thread.start(work);
    std::string text = refusal ? to_string(*refusal) : "started";
    thread.join();  // at once if it was refused, as it should be
    text += "\nthreads left: " + std::to_string(threads_of_this_process() - before);
    return text + "\nsteps: " + std::to_string(work.ticks_.size());
  });
  for (const std::string part :
       {"SCHED_FIFO at priority 80", "EPERM (1, Operation not permitted)",
        "CAP_SYS_NICE is not effective", "RLIMIT_RTPRIO is 0", "threads left: 0", "steps: 0"}) {
    EXPECT_NE(report.find(part), std::string::npos) << "\"" << part << "\" is not in:\n" << report;
  }
}

TEST(CyclicThread, BestEffortStartsWithoutPrivileges) {
  const std::string report = test::in_child([] {
    test::drop({CAP_SYS_NICE, CAP_IPC_LOCK});
    test::limit(RLIMIT_RTPRIO, 0);
    test::limit(RLIMIT_MEMLOCK, 0);
    Counter work(20);
    CyclicThread thread(options_of(1'000'000));
    if (const auto refusal = thread.start(work)) return "refused: " + to_string(*refusal);
    thread.join();
    return "steps: " + std::to_string(work.ticks_.size()) +
           "\nrealtime: " + (thread.statistics().realtime ? "yes" : "no") + "\n" +
           thread.not_realtime_reason();
  });
  for (const std::string part : {"steps: 20", "realtime: no", "CAP_SYS_NICE is not effective"}) {
    EXPECT_NE(report.find(part), std::string::npos) << "\"" << part << "\" is not in:\n" << report;
  }
  if (test::kMemoryCanBeLocked) {
    EXPECT_NE(report.find("RLIMIT_MEMLOCK is 0 KiB"), std::string::npos) << report;
  }
}

TEST(CyclicThread, RefusedWithoutCapIpcLock) {
  const std::string report = test::in_child([] {
    test::drop({CAP_IPC_LOCK});
    test::limit(RLIMIT_MEMLOCK, 0);
    const std::size_t before = threads_of_this_process();
    Counter work(1);
    ThreadOptions options = options_of(1'000'000);
    options.best_effort = false;
    CyclicThread thread(options);
    const auto refusal = thread.start(work);
    std::string text = refusal ? to_string(*refusal) : "started";
    thread.join();  // at once if it was refused, as it should be
    text += "\nthreads left: " + std::to_string(threads_of_this_process() - before);
    return text + "\nsteps: " + std::to_string(work.ticks_.size());
  });
  // Where this test itself may not schedule in real time, that refusal comes first.
  const bool scheduling = report.find("SCHED_FIFO") != std::string::npos;
  if (test::kMemoryCanBeLocked && !scheduling) {
    for (const std::string part : {"mlockall", "EPERM (1, ", "CAP_IPC_LOCK is not effective",
                                   "RLIMIT_MEMLOCK is 0 KiB", "threads left: 0", "steps: 0"}) {
      EXPECT_NE(report.find(part), std::string::npos) << "\"" << part << "\" is not in:\n"
                                                      << report;
    }
  }
}

}  // namespace
}  // namespace geodesic::rt
