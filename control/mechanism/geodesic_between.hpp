// The geodesic between two configurations: the free motion that leads from one to the other in a
// given time, found by shooting with Jacobi fields. Potential energy plays no part.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>

#include "control/mechanism/mechanism.hpp"
#include "control/mechanism/workspace.hpp"

namespace geodesic::control {

struct GeodesicOptions {
  double duration_s = 1.0;
  int steps = 400;           ///< Runge-Kutta steps from end to end
  double tolerance = 1e-10;  ///< of the end: largest number of difference() [rad or m]
  int most_shots = 400;      ///< rounds of Newton's iteration in all
  /// Told after every round how much of the way is solved for, 0..1. May be empty.
  std::function<void(double)> on_progress;
};

enum class GeodesicOutcome {
  kFound,
  kConjugate,      ///< Newton's iteration met a singular derivative: a conjugate point, or nearly
  kNotFound,       ///< no root within most_shots
  kSingularMetric  ///< M is singular on the way
};

struct GeodesicBetween {
  GeodesicOutcome outcome = GeodesicOutcome::kNotFound;
  Eigen::VectorXd start_velocity;  ///< [nv]; of the part solved for, where it was not found
  double solved = 0.0;             ///< share of the way that was solved for: 1 if found
  double miss = 0.0;               ///< largest number of difference() at the end [rad or m]
  int shots = 0;                   ///< rounds of Newton's iteration
  /// First time at which Jacobi fields that vanish at the start have a common direction less
  /// (determinant changes sign): beyond it the geodesic is no shortest way. Empty: none up to the
  /// end; conjugate points of even multiplicity are not seen.
  std::optional<double> conjugate_s;
};

/// What one motion from `from` to `to` costs.
struct Action {
  double action = 0.0;          ///< integral of kinetic energy over time [J·s]
  double length = 0.0;          ///< integral of |v| in the metric, sqrt(2 T) [kg^1/2·m]
  double lowest_energy = 0.0;   ///< [J]
  double highest_energy = 0.0;  ///< [J]
};

/// v [nv] with q1 = integrate(q0, v, 1): per factor the logarithm of q0^-1 q1, the turns of joints
/// as the numbers say (no wrapping).
Eigen::VectorXd straight(const Mechanism& mechanism, const VectorIn& q0, const VectorIn& q1);

/// Shooting: the start velocity is a root of the end's miss; its derivative is made of the Jacobi
/// fields that vanish at the start, each by central differences of the motion. Where the whole way
/// is too far for Newton's iteration, it goes there in parts (continuation along straight()).
/// @param mechanism  without gravity    @param from, to  size nq
/// @throws std::invalid_argument if the mechanism has gravity or an option is out of range.
/// Not real-time. Sources: do Carmo 1992, "Riemannian geometry", chapter 5 (Jacobi fields and
/// conjugate points); Keller 1968, "Numerical methods for two-point boundary-value problems".
GeodesicBetween geodesic_between(const Mechanism& mechanism, const VectorIn& from,
                                 const VectorIn& to, const GeodesicOptions& options = {});

/// Of the geodesic that starts at q [nq] with v [nv], by Simpson's rule over the steps.
Action geodesic_action(const Mechanism& mechanism, const VectorIn& q, const VectorIn& v,
                       double duration_s, int steps);

/// Of the straight line of straight(): every joint at a constant rate, a base along a screw.
Action straight_action(const Mechanism& mechanism, const VectorIn& from, const VectorIn& to,
                       double duration_s, int steps);

}  // namespace geodesic::control
