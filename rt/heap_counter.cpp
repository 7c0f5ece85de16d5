// The malloc family of the whole program: counts the calls of each thread and passes them on to
// glibc's allocator, which stays the only heap. Reached by every program that uses heap_calls(),
// since both are in this one object file.
#include "rt/heap_counter.hpp"

#include <cerrno>
#include <cstddef>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define GEODESIC_SANITIZER_HOOKS 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define GEODESIC_SANITIZER_HOOKS 1
#endif
#endif

namespace geodesic::rt {
namespace {

// initial-exec: the first use must not itself allocate, or malloc would call malloc.
[[gnu::tls_model("initial-exec")]] constinit thread_local std::uint64_t calls = 0;

}  // namespace

std::uint64_t heap_calls() noexcept {
  return calls;
}

}  // namespace geodesic::rt

#ifdef GEODESIC_SANITIZER_HOOKS

// From sanitizer/allocator_interface.h, which g++ does not install though its libraries have it.
// NOLINTNEXTLINE(bugprone-reserved-identifier,readability-identifier-naming): the sanitizers' name
extern "C" int __sanitizer_install_malloc_and_free_hooks(
    void (*allocated)(const volatile void* block, std::size_t size),
    void (*released)(const volatile void* block));

namespace geodesic::rt {
namespace {

// A sanitizer owns malloc in its builds; it tells of every call after the fact.
__attribute__((no_sanitize("address", "thread"))) void allocated(const volatile void* /*block*/,
                                                                 std::size_t /*size*/) {
  ++calls;
}
__attribute__((no_sanitize("address", "thread"))) void released(const volatile void* block) {
  if (block != nullptr) ++calls;
}

[[maybe_unused]] const int hooks_installed =
    __sanitizer_install_malloc_and_free_hooks(allocated, released);

}  // namespace
}  // namespace geodesic::rt

#else

// NOLINTBEGIN(bugprone-reserved-identifier,readability-identifier-naming): glibc's names.
extern "C" {
void* __libc_malloc(std::size_t size) noexcept;
void* __libc_calloc(std::size_t count, std::size_t size) noexcept;
void* __libc_realloc(void* block, std::size_t size) noexcept;
void __libc_free(void* block) noexcept;
void* __libc_memalign(std::size_t alignment, std::size_t size) noexcept;
void* __libc_valloc(std::size_t size) noexcept;
void* __libc_pvalloc(std::size_t size) noexcept;
}
// NOLINTEND(bugprone-reserved-identifier,readability-identifier-naming)

namespace {

using geodesic::rt::calls;

bool is_power_of_two(std::size_t value) {
  return value != 0 && (value & (value - 1)) == 0;
}

}  // namespace

extern "C" {

void* malloc(std::size_t size) noexcept {
  ++calls;
  return __libc_malloc(size);
}

void* calloc(std::size_t count, std::size_t size) noexcept {
  ++calls;
  return __libc_calloc(count, size);
}

void* realloc(void* block, std::size_t size) noexcept {
  ++calls;
  return __libc_realloc(block, size);
}

void free(void* block) noexcept {
  if (block == nullptr) return;
  ++calls;
  __libc_free(block);
}

void* memalign(std::size_t alignment, std::size_t size) noexcept {
  ++calls;
  return __libc_memalign(alignment, size);
}

void* aligned_alloc(std::size_t alignment, std::size_t size) noexcept {
  ++calls;
  if (!is_power_of_two(alignment)) {
    errno = EINVAL;
    return nullptr;
  }
  return __libc_memalign(alignment, size);
}

int posix_memalign(void** block, std::size_t alignment, std::size_t size) noexcept {
  ++calls;
  if (!is_power_of_two(alignment) || alignment % sizeof(void*) != 0) return EINVAL;
  void* const memory = __libc_memalign(alignment, size);
  if (memory == nullptr) return ENOMEM;
  *block = memory;
  return 0;
}

void* valloc(std::size_t size) noexcept {
  ++calls;
  return __libc_valloc(size);
}

void* pvalloc(std::size_t size) noexcept {
  ++calls;
  return __libc_pvalloc(size);
}
}

#endif
