// Runs a piece of a test in a child process, which may give up privileges without harm to the
// tests that follow.
#pragma once

#include <sys/capability.h>

#include <functional>
#include <string>
#include <vector>

namespace geodesic::rt::test {

/// Sanitizers make mlockall do nothing: there is no room to lock their shadow memory.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool kMemoryCanBeLocked = false;
#else
inline constexpr bool kMemoryCanBeLocked = true;
#endif

/// Whether a page fault on locked memory would be ours. Not under a sanitizer, and not in user-mode
/// Linux, which takes a fault at the first touch of a page that its kernel has long brought in.
bool locked_pages_never_fault();

/// Forks, runs `work` in the child and returns what it returned.
std::string in_child(const std::function<std::string()>& work);

/// Gives up capabilities for good.
void drop(const std::vector<cap_value_t>& capabilities);

/// Sets a resource's soft and hard limit.
void limit(int resource, unsigned long value);

}  // namespace geodesic::rt::test
