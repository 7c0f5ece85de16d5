// What a process does once so that its real-time thread never waits for memory or for a sleeping
// processor. Knows nothing of threads' scheduling.
#pragma once

#include <pthread.h>

#include <cstddef>
#include <cstdint>

namespace geodesic::rt {

/// Which memory to lock.
enum class LockScope : std::uint8_t {
  kPresentAndFuture,  ///< every page this process has or will have, its threads' stacks among them
  kPresent,  ///< what it has now: where a limit applies, a later allocation must not run into it
};

/// mlockall: those pages are brought in now and stay in memory. @return 0 or errno. Not real-time.
int lock_memory(LockScope scope) noexcept;

/// Makes the heap grow by `bytes` now and keep what it has: no trimming, no mapping of its own for
/// big blocks. What the service threads allocate later then comes without page faults. Not
/// real-time.
void prefault_heap(std::size_t bytes) noexcept;

/// The lowest address of a thread's stack; null if that cannot be told. Allocates: not for the
/// thread itself, whose first allocation would reserve a heap of its own.
const void* stack_end(pthread_t thread) noexcept;

/// Touches what is left of the calling thread's stack above `end`, but for the last 64 KiB (the
/// guard page is there, and nothing in a loop goes that deep). @return bytes touched.
std::size_t prefault_stack(const void* end) noexcept;

/// While it lives, no processor goes into a sleep state from which waking takes time
/// (/dev/cpu_dma_latency holds a request for 0 us as long as it is open).
class CpuLatencyRequest {
 public:
  CpuLatencyRequest() = default;
  ~CpuLatencyRequest() { release(); }
  CpuLatencyRequest(const CpuLatencyRequest&) = delete;
  CpuLatencyRequest& operator=(const CpuLatencyRequest&) = delete;

  /// @return 0 or errno. Not real-time.
  int hold() noexcept;
  void release() noexcept;

 private:
  int file_ = -1;
};

}  // namespace geodesic::rt
