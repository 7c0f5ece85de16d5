// What a real-time thread must not do and did nevertheless: page faults and heap calls, for the
// calling thread or over a scope of code. Counts only; judging is the caller's.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <optional>
#include <string>

namespace geodesic::rt {

struct ThreadHealth {
  std::uint64_t page_faults = 0;  ///< minor and major
  std::uint64_t allocations = 0;  ///< heap calls, releases among them (heap_counter.hpp)
};

constexpr ThreadHealth operator-(const ThreadHealth& now, const ThreadHealth& then) noexcept {
  return {now.page_faults - then.page_faults, now.allocations - then.allocations};
}

/// Of the calling thread, since its birth. One system call (getrusage): not for inside the loop.
ThreadHealth thread_health() noexcept;

/// Page faults of a thread of this process, by its kernel identifier, since its birth; nothing if
/// there is no such thread. Reads /proc: neither allocates nor throws, but not for real time.
std::optional<std::uint64_t> page_faults_of(pid_t thread) noexcept;

/// "2 heap calls, 0 page faults".
std::string to_string(const ThreadHealth& health);

/// A scope that code under test must cross without a heap call or a page fault:
///   RealtimeGuard guard;
///   controller.update(state, period_s);
///   const ThreadHealth seen = guard.seen();
///   EXPECT_EQ(seen.allocations, 0u) << to_string(seen);
/// Page faults are a proof only where the pages were touched or locked before the scope.
class RealtimeGuard {
 public:
  RealtimeGuard() noexcept : start_(thread_health()) {}
  /// What the calling thread did since the guard was made; call it from the thread that made it.
  ThreadHealth seen() const noexcept { return thread_health() - start_; }
  /// Whether it did neither.
  bool clean() const noexcept {
    const ThreadHealth since = seen();
    return since.page_faults == 0 && since.allocations == 0;
  }

 private:
  ThreadHealth start_;
};

}  // namespace geodesic::rt
