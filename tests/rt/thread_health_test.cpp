// The counters that prove a loop clean must themselves be seen to catch every kind of dirt.
#include "rt/thread_health.hpp"

#include <gtest/gtest.h>
#include <malloc.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "rt/heap_counter.hpp"

namespace geodesic::rt {
namespace {

// ThreadSanitizer's hooks do not tell of aligned allocations, only of their release.
#if defined(__SANITIZE_THREAD__)
constexpr std::uint64_t kAlignedCalls = 1;
#else
constexpr std::uint64_t kAlignedCalls = 2;
#endif

/// Keeps the compiler from leaving out an allocation that nobody looks at.
void keep(void* pointer) {
  asm volatile("" : : "g"(pointer) : "memory");
}

std::uint64_t calls_of(const std::function<void()>& work) {
  const std::uint64_t before = heap_calls();
  work();
  return heap_calls() - before;
}

TEST(RealtimeGuard, SeesNothingInPlainArithmetic) {
  volatile double x = 1.0;
  RealtimeGuard warm;
  EXPECT_TRUE(warm.clean() || !warm.clean());  // brings in the pages of the guard itself
  RealtimeGuard guard;
  for (int i = 0; i < 1000; ++i) x = x * 1.0001;
  const ThreadHealth seen = guard.seen();
  EXPECT_EQ(seen.allocations, 0U) << to_string(seen);
  EXPECT_EQ(seen.page_faults, 0U) << to_string(seen);
  EXPECT_TRUE(guard.clean());
}

TEST(RealtimeGuard, CatchesNewAndDelete) {
  RealtimeGuard guard;
  auto* const number = new int(1);
  keep(number);
  EXPECT_EQ(guard.seen().allocations, 1U);
  delete number;
  EXPECT_EQ(guard.seen().allocations, 2U);
  EXPECT_FALSE(guard.clean());
}

TEST(RealtimeGuard, CatchesAPageFault) {
  const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  void* const memory =
      mmap(nullptr, page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  ASSERT_NE(memory, MAP_FAILED);
  munlock(memory, page);  // another test may have locked all that is mapped from then on
  madvise(memory, page, MADV_DONTNEED);
  RealtimeGuard guard;
  *static_cast<volatile char*>(memory) = 1;
  const ThreadHealth seen = guard.seen();
  munmap(memory, page);
  EXPECT_GE(seen.page_faults, 1U);
  EXPECT_EQ(seen.allocations, 0U);
}

TEST(RealtimeGuard, SpeaksPlainly) {
  EXPECT_EQ(to_string(ThreadHealth{3, 2}), "2 heap calls, 3 page faults");
}

TEST(HeapCounter, EveryWayToTheHeapCounts) {
  EXPECT_EQ(calls_of([] {
              void* const p = std::malloc(100);
              keep(p);
              std::free(p);
            }),
            2U);
  EXPECT_EQ(calls_of([] {
              void* const p = std::calloc(10, 10);
              keep(p);
              std::free(p);
            }),
            2U);
  EXPECT_GE(calls_of([] {
              void* p = std::malloc(10);
              keep(p);
              p = std::realloc(p, 100'000);
              keep(p);
              std::free(p);
            }),
            3U);
  EXPECT_EQ(calls_of([] {
              void* p = nullptr;
              ASSERT_EQ(posix_memalign(&p, 64, 100), 0);
              keep(p);
              EXPECT_EQ(reinterpret_cast<std::uintptr_t>(p) % 64, 0U);
              std::free(p);
            }),
            kAlignedCalls);
  EXPECT_EQ(calls_of([] {
              void* const p = std::aligned_alloc(256, 512);
              keep(p);
              EXPECT_EQ(reinterpret_cast<std::uintptr_t>(p) % 256, 0U);
              std::free(p);
            }),
            kAlignedCalls);
  EXPECT_EQ(calls_of([] {
              void* const p = memalign(128, 100);
              keep(p);
              EXPECT_EQ(reinterpret_cast<std::uintptr_t>(p) % 128, 0U);
              std::free(p);
            }),
            kAlignedCalls);
}

struct alignas(128) Aligned {
  double value = 0.0;
};

TEST(HeapCounter, LibrariesAndContainersCountToo) {
  EXPECT_EQ(calls_of([] {
              auto aligned = std::make_unique<Aligned>();
              keep(aligned.get());
            }),
            2U);
  EXPECT_EQ(calls_of([] {
              std::vector<int> vector(1000);
              keep(vector.data());
            }),
            2U);
  EXPECT_EQ(calls_of([] {  // allocated inside libstdc++.so
              std::string text(1000, 'x');
              keep(text.data());
            }),
            2U);
  EXPECT_EQ(calls_of([] {  // allocated inside libc.so
              char* const copy = strdup("a longer text than fits anywhere else");
              keep(copy);
              std::free(copy);
            }),
            2U);
}

TEST(HeapCounter, ReleasingNothingIsNoCall) {
  EXPECT_EQ(calls_of([] { std::free(nullptr); }), 0U);
}

TEST(HeapCounter, BadAlignmentIsRefusedAsTheStandardSays) {
  void* p = nullptr;
  const volatile std::size_t odd = 3;  // volatile: the compiler knows these functions too well
  EXPECT_EQ(calls_of([&] {
              EXPECT_EQ(posix_memalign(&p, sizeof(void*), 16), 0);
              std::free(p);
            }),
            kAlignedCalls);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  EXPECT_EQ(posix_memalign(&p, odd, 16), EINVAL);
  errno = 0;
  EXPECT_EQ(std::aligned_alloc(odd, 16), nullptr);
  EXPECT_EQ(errno, EINVAL);
#else
  EXPECT_EQ(odd, 3U);  // there the sanitizer's malloc answers, by ending the program
#endif
}

TEST(HeapCounter, CountsTheCallingThreadOnly) {
  EXPECT_EQ(calls_of([] {
              volatile bool go = true;
              RealtimeGuard guard;
              std::thread([&go] {
                for (int i = 0; i < 1000 && go; ++i) {
                  void* const p = std::malloc(100);
                  keep(p);
                  std::free(p);
                }
              }).join();
              EXPECT_LT(guard.seen().allocations, 100U);  // making the thread itself costs a few
            }) < 100U,
            true);
}

TEST(ThreadHealth, AnotherThreadsFaultsAreReadable) {
  const std::uint64_t own = thread_health().page_faults;
  const auto read = page_faults_of(gettid());
  ASSERT_TRUE(read.has_value());
  EXPECT_GE(*read, own);
  EXPECT_FALSE(page_faults_of(-1).has_value());
}

}  // namespace
}  // namespace geodesic::rt
