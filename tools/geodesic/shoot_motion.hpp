// The motions that `geodesic shoot` computes and what it judges of them: energy, momentum, time a
// step. How they are found is in control/mechanism; how they are shown in shoot_output.hpp.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <vector>

#include "control/mechanism/geodesic_between.hpp"
#include "control/mechanism/mechanism.hpp"

namespace geodesic::tools {

enum class Integrator { kVariational, kMuntheKaas };

constexpr const char* to_string(Integrator integrator) noexcept {
  return integrator == Integrator::kVariational ? "variational" : "runge-kutta";
}

struct ShootOptions {
  double duration_s = 1.0;
  int steps = 1000;
  int samples = 1000;  ///< at most so many instants are kept, evenly; the start is one more
  Integrator integrator = Integrator::kVariational;
  int frame = 0;  ///< link whose way is kept
  /// Told now and then which share of the steps is done. May be empty.
  std::function<void(double)> on_progress;
};

/// One instant.
struct Sample {
  double time_s = 0.0;
  Eigen::VectorXd q;
  Eigen::VectorXd v;
  double kinetic_j = 0.0;
  double energy_j = 0.0;                            ///< kinetic and potential
  Eigen::Matrix<double, 6, 1> momentum;             ///< of all that moves, about the world's origin
  Eigen::Vector3d place = Eigen::Vector3d::Zero();  ///< of the frame [m], world
};

struct Motion {
  std::vector<Sample> samples;
  std::vector<Sample> opening;  ///< every one of the first steps, if samples are sparser
  double ns_per_step = 0.0;     ///< of the integrator alone
};

/// What should stay as it was, and how well it did.
struct Conservation {
  double energy_band = 0.0;       ///< largest |E / E0 - 1|
  double energy_drift = 0.0;      ///< slope of E / E0 (least squares) times the duration
  double drift_noise = 0.0;       ///< standard error of the same, swings included
  std::optional<double> linear;   ///< largest change of linear momentum, relative to its magnitude
  std::optional<double> angular;  ///< of angular momentum; both only where nothing holds the base
};

/// The motion that starts at q with v, no force but gravity (if the mechanism has any).
/// @throws BadInput if a step has no solution, naming the time.
Motion shoot(const control::Mechanism& mechanism, const Eigen::VectorXd& q,
             const Eigen::VectorXd& v, const ShootOptions& options);

/// The straight line between the ends of `motion`, at the same instants; energies without gravity.
std::vector<Sample> straight_samples(const control::Mechanism& mechanism, const Motion& motion,
                                     const Eigen::VectorXd& to, int frame);

Conservation judge(const control::Mechanism& mechanism, const Motion& motion);

}  // namespace geodesic::tools
