// Can a body have this inertia? A verdict with figures, and the nearest inertia that a body can
// have. Not real-time in use, though nothing here allocates.
#pragma once

#include <Eigen/Core>

#include "control/mechanism/tree.hpp"

namespace geodesic::control {

struct InertiaVerdict {
  bool physical = false;
  /// Principal moments about the centre of mass, ascending [kg·m²].
  Eigen::Vector3d principal = Eigen::Vector3d::Zero();
  /// What is wrong, for people: "A + B < C ..."; "" if physical. Static text.
  const char* reason = "";
  /// The description itself if physical, else the nearest that is.
  LinkInertia nearest;
};

/// Physical is: mass > 0, finite, symmetric, principal moments A <= B <= C all >= 0 with A + B >=
/// C, each to 1e-9 of A + B + C, so that rods, plates and points pass. A link without mass and
/// inertia is a mere frame, and passes. Equivalent to a positive semidefinite pseudo-inertia.
/// Source: Wensing, Kim, Slotine 2018, "Linear matrix inequalities for physically consistent
/// inertial parameter identification: a statistical perspective on the mass distribution".
InertiaVerdict check_inertia(const LinkInertia& inertia) noexcept;

/// Same mass, centre of mass and principal axes; principal moments moved by the least Frobenius
/// distance onto {A + B >= C, B + C >= A, C + A >= B}. Asymmetric parts are dropped. Without
/// positive mass, or with a number that is not finite, nothing can be kept: all zero.
LinkInertia nearest_physical_inertia(const LinkInertia& inertia) noexcept;

}  // namespace geodesic::control
