// Functions that were compiled for one mechanism, as plain pointers. Where they come from, and how
// it is made sure that they compute what this folder's own algorithms do, is in tools/compile.
#pragma once

namespace geodesic::control {

/// Real-time, O(n). Arrays as the functions of the same names have them; they must not overlap.
/// Equal to those functions to rounding, not to the bit.
struct CompiledModel {
  void (*bias)(const double* q, const double* v, double* out) = nullptr;
  void (*gravity)(const double* q, double* out) = nullptr;
  void (*metric)(const double* q, double* out) = nullptr;
};

}  // namespace geodesic::control
