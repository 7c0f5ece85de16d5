// How often the calling thread has gone to the heap. Only counts; who may go there and who may not
// is decided elsewhere.
#pragma once

#include <cstdint>

namespace geodesic::rt {

/// Calls of the calling thread, since its birth, that allocate, resize or release heap memory:
/// malloc, calloc, realloc, free (of a non-null pointer), posix_memalign, aligned_alloc, memalign,
/// valloc and pvalloc, whoever made them: operator new and delete, the C library and every shared
/// library come here too. In a build for AddressSanitizer or ThreadSanitizer the sanitizer's own
/// hooks count instead: there a realloc counts as two, and ThreadSanitizer does not tell of
/// posix_memalign, aligned_alloc and memalign, only of their release. Real-time.
std::uint64_t heap_calls() noexcept;

}  // namespace geodesic::rt
