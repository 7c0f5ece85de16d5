// Judges whether a URDF's figures are plausible: inertia no body can have, masses that are slips of
// a unit, limits of zero. Structure is checked before (urdf_check.hpp).
#pragma once

#include "config/findings.hpp"
#include "config/urdf.hpp"
#include "config/urdf_check.hpp"

namespace geodesic::config {

/// Adds a warning (strict: an error) for everything odd in `result.tree`, which is used as written.
void lint_urdf(const UrdfResult& result, const UrdfDocument& document, const UrdfIndex& index,
               bool strict, Findings& findings);

}  // namespace geodesic::config
