// Reads the kernel's page fault counters: getrusage for the calling thread, /proc for another one.
#include "rt/thread_health.hpp"

#include <fcntl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <array>
#include <cinttypes>
#include <cstdio>
#include <cstring>

#include "rt/heap_counter.hpp"

namespace geodesic::rt {

ThreadHealth thread_health() noexcept {
  rusage usage{};
  getrusage(RUSAGE_THREAD, &usage);
  return {static_cast<std::uint64_t>(usage.ru_minflt) + static_cast<std::uint64_t>(usage.ru_majflt),
          heap_calls()};
}

std::optional<std::uint64_t> page_faults_of(pid_t thread) noexcept {
  std::array<char, 64> path{};
  std::snprintf(path.data(), path.size(), "/proc/self/task/%d/stat", static_cast<int>(thread));
  const int file = open(path.data(), O_RDONLY | O_CLOEXEC);
  if (file < 0) return std::nullopt;
  std::array<char, 1024> text{};
  const ssize_t length = read(file, text.data(), text.size() - 1);
  close(file);
  if (length <= 0) return std::nullopt;

  // "TID (NAME) STATE PPID PGRP SESSION TTY TPGID FLAGS MINFLT CMINFLT MAJFLT ...": a name may hold
  // anything, so count from its last bracket. See proc(5).
  const char* const after_name = std::strrchr(text.data(), ')');
  if (after_name == nullptr) return std::nullopt;
  std::uint64_t minor = 0;
  std::uint64_t major = 0;
  const int found = std::sscanf(  // NOLINT(cert-err34-c): the kernel writes numbers that fit
      after_name + 1, " %*c %*d %*d %*d %*d %*d %*u %" SCNu64 " %*u %" SCNu64, &minor, &major);
  if (found != 2) return std::nullopt;
  return minor + major;
}

std::string to_string(const ThreadHealth& health) {
  return std::to_string(health.allocations) + " heap calls, " + std::to_string(health.page_faults) +
         " page faults";
}

}  // namespace geodesic::rt
