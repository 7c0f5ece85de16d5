// All that tunes a controller in one piece, to be exchanged while it runs, and what of it may not
// be exchanged. The exchange itself is Controller::exchange().
#pragma once

#include <string>
#include <vector>

#include "control/mechanism/compiled_model.hpp"
#include "control/mechanism/mechanism.hpp"
#include "control/options.hpp"

namespace geodesic::control {

struct Setup {
  ControllerOptions options;
  Mechanism mechanism;
  /// Compiled for this very mechanism, taken in place of the algorithms; null: none. Outlives it.
  const CompiledModel* compiled = nullptr;
};

/// Why a controller that runs `from` cannot go over to `to`, each a sentence that names the joint
/// and what changed; empty: it can. What `to` gets wrong by itself counts too. Gains, friction,
/// limits, thresholds, times, inertias and gravity may change; which joints there are, how they
/// hang on each other, their arms, and what counts at the start only may not. Not real-time.
std::vector<std::string> unexchangeable(const Setup& from, const Setup& to);

}  // namespace geodesic::control
