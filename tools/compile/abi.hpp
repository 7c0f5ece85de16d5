// What a compiled model's shared object offers, in plain C. The emitted file repeats this struct.
#pragma once

#include <cstdint>

extern "C" {

/// Configurations q have nq numbers, velocities, accelerations and torques nv. No function keeps,
/// allocates or throws anything; arrays need no alignment and must not overlap. A number that is
/// not finite makes every result NaN that depends on its arm.
// NOLINTNEXTLINE(readability-identifier-naming): C's own style, as the emitted file has it
struct geodesic_compiled {
  std::uint32_t abi;        ///< kCompiledAbi
  std::uint32_t isa_level;  ///< needs x86-64-vN; 0: the architecture's base
  const char* robot;
  const char* fingerprint;  ///< of the mechanism (fingerprint.hpp)
  std::int32_t nq;
  std::int32_t nv;
  void (*bias)(const double* q, const double* v, double* out);  ///< C v + g
  void (*gravity)(const double* q, double* out);                ///< g
  void (*metric)(const double* q, double* out);                 ///< M, nv x nv, both triangles
  /// M a + C v + g, rotor inertias included.
  void (*inverse_dynamics)(const double* q, const double* v, const double* a, double* out);
};

}  // extern "C"

namespace geodesic::tools::compile {

inline constexpr std::uint32_t kCompiledAbi = 1;
/// const geodesic_compiled* (*)(void)
inline constexpr const char* kCompiledSymbol = "geodesic_compiled_model";

}  // namespace geodesic::tools::compile
