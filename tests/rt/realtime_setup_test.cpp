// Locking and prefaulting, seen by their effect: what was prepared is touched without a page fault.
#include "rt/realtime_setup.hpp"

#include <gtest/gtest.h>
#include <pthread.h>
#include <sys/mman.h>
#include <sys/resource.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <thread>

#include "rt/thread_health.hpp"
#include "tests/rt/child.hpp"

namespace geodesic::rt {
namespace {

[[gnu::noinline]] void use_stack() {
  std::array<volatile char, std::size_t{256} << 10U> deep;
  for (std::size_t i = 0; i < deep.size(); i += 1024) deep[deep.size() - 1 - i] = 1;
}

TEST(RealtimeSetup, StackIsThereBeforeItIsUsed) {
  ThreadHealth seen{1, 1};
  std::size_t touched = 0;
  std::thread([&] {
    touched = prefault_stack(stack_end(pthread_self()));
    use_stack();  // the pages of its code
    const RealtimeGuard guard;
    use_stack();
    seen = guard.seen();
  }).join();
  EXPECT_GT(touched, std::size_t{256} << 10U);
  EXPECT_EQ(seen.page_faults, 0U);
  EXPECT_EQ(prefault_stack(nullptr), 0U);
}

TEST(RealtimeSetup, HeapIsThereBeforeItIsUsed) {
  constexpr std::size_t kBytes = std::size_t{4} << 20U;
  prefault_heap(2 * kBytes);
  const RealtimeGuard guard;
  auto* const block = static_cast<volatile char*>(std::malloc(kBytes));
  ASSERT_NE(block, nullptr);
  for (std::size_t i = 0; i < kBytes; i += 1024) block[i] = 1;
  const ThreadHealth seen = guard.seen();
  std::free(const_cast<char*>(block));
  if (test::kMemoryCanBeLocked) {  // a sanitizer's heap ignores the request
    EXPECT_EQ(seen.page_faults, 0U) << to_string(seen);
  }
}

TEST(RealtimeSetup, LockedMemoryTakesNoFaultLater) {
  const std::string report = test::in_child([]() -> std::string {
    if (const int error = lock_memory(LockScope::kPresentAndFuture); error != 0) return "refused";
    constexpr std::size_t kBytes = std::size_t{1} << 16U;
    void* const later =
        mmap(nullptr, kBytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (later == MAP_FAILED) return "refused";
    const RealtimeGuard guard;
    for (std::size_t i = 0; i < kBytes; i += 1024) static_cast<volatile char*>(later)[i] = 1;
    return guard.seen().page_faults == 0 ? "no fault" : "faults";
  });
  if (test::locked_pages_never_fault()) {
    EXPECT_TRUE(report == "no fault" || report == "refused") << report;
  }
}

TEST(RealtimeSetup, LockingBeyondTheLimitIsAnError) {
  const std::string report = test::in_child([] {
    test::drop({CAP_IPC_LOCK});
    test::limit(RLIMIT_MEMLOCK, 4096);
    return std::to_string(lock_memory(LockScope::kPresent));
  });
  if (test::kMemoryCanBeLocked) {
    EXPECT_EQ(report, std::to_string(ENOMEM));
  }
}

TEST(RealtimeSetup, LatencyRequestIsHeldOnceAndReleased) {
  CpuLatencyRequest request;
  const int first = request.hold();  // 0, or errno where this user may not
  EXPECT_GE(first, 0);
  EXPECT_EQ(request.hold(), first);
  request.release();
  request.release();
}

}  // namespace
}  // namespace geodesic::rt
