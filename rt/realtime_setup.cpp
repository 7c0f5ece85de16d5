// Memory locking, prefaulting and the processor latency request, as the kernel wants them.
#include "rt/realtime_setup.hpp"

#include <alloca.h>
#include <fcntl.h>
#include <malloc.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstdlib>

namespace geodesic::rt {
namespace {

void touch(volatile unsigned char* bytes, std::size_t count) noexcept {
  const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  for (std::size_t i = 0; i < count; i += page) bytes[i] = 0;
  if (count > 0) bytes[count - 1] = 0;
}

}  // namespace

int lock_memory(LockScope scope) noexcept {
  const int flags = scope == LockScope::kPresent ? MCL_CURRENT : MCL_CURRENT | MCL_FUTURE;
  return mlockall(flags) == 0 ? 0 : errno;
}

void prefault_heap(std::size_t bytes) noexcept {
  mallopt(M_TRIM_THRESHOLD, -1);
  mallopt(M_MMAP_MAX, 0);
  void* const block = std::malloc(bytes);
  if (block == nullptr) return;  // then there is not that much to be had, now or later
  touch(static_cast<unsigned char*>(block), bytes);
  std::free(block);
}

const void* stack_end(pthread_t thread) noexcept {
  // Asked of the library and not reckoned from an option: thread-local storage, which may be large,
  // is cut out of the same block.
  pthread_attr_t attributes;
  if (pthread_getattr_np(thread, &attributes) != 0) return nullptr;
  void* lowest = nullptr;
  std::size_t size = 0;
  pthread_attr_getstack(&attributes, &lowest, &size);
  pthread_attr_destroy(&attributes);
  return lowest;
}

[[gnu::noinline]] std::size_t prefault_stack(const void* end) noexcept {
  constexpr std::uintptr_t kSpared = std::uintptr_t{64} << 10U;
  const auto here = reinterpret_cast<std::uintptr_t>(__builtin_frame_address(0));
  const auto stop = reinterpret_cast<std::uintptr_t>(end) + kSpared;
  if (end == nullptr || here <= stop) return 0;
  touch(static_cast<unsigned char*>(alloca(here - stop)), here - stop);
  return here - stop;
}

int CpuLatencyRequest::hold() noexcept {
  if (file_ >= 0) return 0;
  const int file = open("/dev/cpu_dma_latency", O_WRONLY | O_CLOEXEC);
  if (file < 0) return errno;
  const std::int32_t latency_us = 0;
  if (write(file, &latency_us, sizeof(latency_us)) != static_cast<ssize_t>(sizeof(latency_us))) {
    const int error = errno;
    close(file);
    return error;
  }
  file_ = file;
  return 0;
}

void CpuLatencyRequest::release() noexcept {
  if (file_ >= 0) close(file_);
  file_ = -1;
}

}  // namespace geodesic::rt
