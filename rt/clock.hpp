// The one clock of the house, CLOCK_MONOTONIC in nanoseconds, and sleeping on it. No schedule here.
#pragma once

#include <cerrno>
#include <cstdint>
#include <ctime>

namespace geodesic::rt {

inline constexpr std::int64_t kNanosecondsPerSecond = 1'000'000'000;

/// CLOCK_MONOTONIC [ns]. Real-time: no system call where the kernel has a vDSO.
inline std::int64_t now_ns() noexcept {
  timespec time{};
  clock_gettime(CLOCK_MONOTONIC, &time);  // cannot fail for this clock
  return static_cast<std::int64_t>(time.tv_sec) * kNanosecondsPerSecond + time.tv_nsec;
}

/// Sleeps until CLOCK_MONOTONIC reads `due_ns` (>= 0); returns at once if it already does. A signal
/// does not end the sleep. Real-time: the loop's one sleeping system call.
inline void sleep_until_ns(std::int64_t due_ns) noexcept {
  timespec due{};
  due.tv_sec = static_cast<decltype(due.tv_sec)>(due_ns / kNanosecondsPerSecond);
  due.tv_nsec = static_cast<decltype(due.tv_nsec)>(due_ns % kNanosecondsPerSecond);
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &due, nullptr) == EINTR) {
  }
}

}  // namespace geodesic::rt
