// The seal of the real-time thread: a system call filter (seccomp) after which the thread can
// sleep, send, receive, read the clock and exit, and nothing else. A refused call fails and is
// told; it does not end the process. Knows nothing of threads' starting.
#pragma once

#include <linux/filter.h>

#include <atomic>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "rt/refusal.hpp"
#include "rt/ring.hpp"

namespace geodesic::rt {

/// False in a build for a sanitizer, whose run time makes system calls of its own.
#if defined(GEODESIC_NO_SEAL)
inline constexpr bool kSealBuilt = false;
#else
inline constexpr bool kSealBuilt = true;
#endif

struct SealOptions {
  /// The only ones the thread may send to and receive from.
  std::vector<int> descriptors;
};

/// A system call that was not made.
struct RefusedCall {
  int number = 0;                  ///< as the kernel counts them on this machine
  std::uintptr_t instruction = 0;  ///< address of the instruction after the one that asked
};

/// The filter of one thread. prepare() on any thread, apply() on the thread that is to be sealed;
/// must outlive that thread.
class Seal {
 public:
  Seal() = default;
  Seal(const Seal&) = delete;
  Seal& operator=(const Seal&) = delete;

  /// Compiles the filter and makes the process ready to hear of refused calls (SIGSYS). Not
  /// real-time. @return why it cannot be had.
  std::optional<Refusal> prepare(const SealOptions& options);

  /// Seals the calling thread for the rest of its life, and proves it by a call that must be
  /// refused. Not real-time, allocates nothing. @return 0, or errno: then nothing is sealed.
  int apply() noexcept;

  /// Calls refused since apply(). Any thread.
  std::uint64_t refused() const noexcept { return refused_.load(std::memory_order_relaxed); }

  /// Number + 1 of the first call refused since this was last asked, 0 if there was none. The
  /// sealed thread only; real-time.
  int take() noexcept;

  /// The refused calls one by one, as far as they were kept. One other thread.
  bool pop(RefusedCall& call) noexcept { return calls_.pop(call); }

 private:
  friend struct SealSignal;
  void note(int number, std::uintptr_t instruction) noexcept;

  std::vector<sock_filter> program_;
  std::atomic<std::uint64_t> refused_{0};
  std::atomic<int> pending_{0};  // written by the signal handler, taken by the thread it interrupts
  Ring<RefusedCall, 64> calls_;
};

/// Why apply() was refused with `error_number`.
Refusal explain_seal(int error_number);

/// "openat", or "number 9999" where this machine has no such call. Not real-time.
std::string system_call_name(int number);

/// "geodesicd+0x1234", for addr2line; the bare address where no file is mapped. Not real-time.
std::string instruction_text(std::uintptr_t instruction);

/// Ends the calling thread, sealed or not, by one system call: no destructor of anything
/// thread-local runs.
[[noreturn]] void exit_thread() noexcept;

}  // namespace geodesic::rt
