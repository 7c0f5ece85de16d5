// One piece of code built three times, for the registers and vectors of the machine at hand. It
// computes the same operations in the same order each time (-ffp-contract=off forbids fusing them),
// so the same bits; only their number of instructions differs. Nothing of mechanics.
#pragma once

#include <cstddef>
#include <type_traits>

namespace geodesic::control {

enum class Registers : unsigned char {
  kBaseline,  ///< what every processor of the architecture has
  kAvx2,      ///< 16 registers of 4 numbers, operations that spare their operands
  kAvx512,    ///< 32 registers of 8 numbers: a body's whole motion stays in them
};

/// The most that this machine has. Not real-time: asks the processor.
inline Registers widest_registers() noexcept {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512dq")) {
    return Registers::kAvx512;
  }
  if (__builtin_cpu_supports("avx2")) {
    return Registers::kAvx2;
  }
#endif
  return Registers::kBaseline;
}

/// The longest vector of numbers: buffers that are worked on in vectors have so many to spare.
inline constexpr std::size_t kMostLanes = 8;

/// As many numbers as a vector holds.
template <std::size_t n>
using Lanes = std::integral_constant<std::size_t, n>;

#if defined(__x86_64__)
/// Attributes take no constants, hence a macro: what Registers::kAvx512 is built for.
#if defined(__clang__)
#define GEODESIC_AVX512 "avx512f,avx512vl,avx512dq"
#else
#define GEODESIC_AVX512 "avx512f,avx512vl,avx512dq,prefer-vector-width=512"
#endif

template <typename Run>
[[gnu::target("avx2"), gnu::flatten, gnu::noinline]] void run_with_avx2(const Run& run) noexcept {
  run(Lanes<4>{});
}
template <typename Run>
[[gnu::target(GEODESIC_AVX512), gnu::flatten, gnu::noinline]] void run_with_avx512(
    const Run& run) noexcept {
  run(Lanes<8>{});
}
#endif
template <typename Run>
[[gnu::flatten, gnu::noinline]] void run_with_baseline(const Run& run) noexcept {
  run(Lanes<2>{});
}

/// run(Lanes<n>{}) with everything it calls inlined and built for `registers`, which this machine
/// must have. Real-time if `run` is.
template <typename Run>
inline void run_with(Registers registers, const Run& run) noexcept {
#if defined(__x86_64__)
  if (registers == Registers::kAvx512) {
    return run_with_avx512(run);
  }
  if (registers == Registers::kAvx2) {
    return run_with_avx2(run);
  }
#endif
  static_cast<void>(registers);
  run_with_baseline(run);
}

}  // namespace geodesic::control
