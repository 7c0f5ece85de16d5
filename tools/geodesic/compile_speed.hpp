// How long a compiled model takes, beside the model that needs no compiler, in one run.
#pragma once

#include "control/mechanism/mechanism.hpp"
#include "tools/compile/abi.hpp"

namespace geodesic::tools {

/// Nanoseconds a call, the fastest of many rounds on warm caches.
struct CompiledSpeed {
  struct Pair {
    double compiled_ns = 0.0;
    double plain_ns = 0.0;
  };
  Pair bias;
  Pair gravity;
  Pair metric;
  double bias_latency_ns = 0.0;  ///< compiled; the next call's input depends on the last output
};

/// Takes some tens of milliseconds.
CompiledSpeed measure(const geodesic_compiled& model, const control::Mechanism& mechanism);

}  // namespace geodesic::tools
