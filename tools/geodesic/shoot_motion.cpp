// Implements shoot_motion.hpp.
#include "tools/geodesic/shoot_motion.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <ctime>

#include "control/mechanism/configuration.hpp"
#include "control/mechanism/energy.hpp"
#include "control/mechanism/kinematics.hpp"
#include "control/mechanism/momentum.hpp"
#include "control/mechanism/munthe_kaas.hpp"
#include "control/mechanism/musical.hpp"
#include "control/mechanism/variational.hpp"
#include "tools/geodesic/command.hpp"

namespace geodesic::tools {
namespace {

/// The opening's length in steps: what an eye can follow.
constexpr int kOpening = 4000;

class Recorder {
 public:
  Recorder(const control::Mechanism& mechanism, int frame)
      : mechanism_(mechanism), workspace_(mechanism), frame_(frame) {}

  Sample operator()(double time_s, const Eigen::VectorXd& q, const Eigen::VectorXd& v) {
    Sample sample;
    sample.time_s = time_s;
    sample.q = q;
    sample.v = v;
    sample.kinetic_j = kinetic_energy(mechanism_, workspace_, q, v);
    sample.energy_j = sample.kinetic_j + potential_energy(mechanism_, workspace_, q);
    const control::CentroidalMomentum h = centroidal_momentum(mechanism_, workspace_, q, v);
    sample.momentum << h.linear, h.angular + h.centre_of_mass.cross(h.linear);
    sample.place = link_pose(mechanism_, q, frame_).translation;
    return sample;
  }

 private:
  const control::Mechanism& mechanism_;
  control::Workspace workspace_;
  int frame_;
};

[[noreturn]] void refuse_singular(double time_s) {
  throw BadInput(fmt::format(
      "the metric is singular at {:.6g} s: some direction of v moves no mass (with --floating "
      "every "
      "direction of the base must; --rotors adds the motors' inertia of a robot's file)",
      time_s));
}

Eigen::VectorXd velocity_of(control::VariationalIntegrator& motion, double time_s) {
  const Eigen::VectorXd* v = motion.velocity();
  if (v == nullptr) refuse_singular(time_s);
  return *v;
}

Eigen::VectorXd velocity_of(control::MuntheKaasIntegrator& motion, double /*time_s*/) {
  return motion.velocity();
}

template <class Stepper>
Motion run(Stepper& stepper, const control::Mechanism& mechanism, const Eigen::VectorXd& q,
           const Eigen::VectorXd& v, const ShootOptions& options) {
  Motion motion;
  Recorder record(mechanism, options.frame);
  const double h = options.duration_s / options.steps;
  const int stride = (options.steps + options.samples - 1) / options.samples;
  const int opening = stride > 1 ? std::min(options.steps, kOpening) : 0;
  stepper.start(q, v);
  motion.samples.push_back(record(0.0, stepper.q(), v));
  if (opening > 0) motion.opening.push_back(motion.samples.front());
  std::clock_t busy = 0;  // processor time: other programs do not count
  for (int k = 0; k < options.steps;) {
    const int until = std::min(options.steps, k < opening ? k + 1 : (k / stride + 1) * stride);
    const std::clock_t begin = std::clock();
    for (; k < until; ++k) {
      if (!stepper.step(h)) {
        throw BadInput(fmt::format(
            "no motion beyond {:.6g} s: the step's equations have no solution nearby; smaller "
            "steps (--steps {}) may help",
            h * k, 4LL * options.steps));
      }
    }
    busy += std::clock() - begin;
    const bool sampled = k % stride == 0 || k == options.steps;
    if (!sampled && k > opening) continue;
    const Sample sample = record(h * k, stepper.q(), velocity_of(stepper, h * k));
    if (sampled) motion.samples.push_back(sample);
    if (k <= opening) motion.opening.push_back(sample);
    if (options.on_progress) options.on_progress(static_cast<double>(k) / options.steps);
  }
  motion.ns_per_step = 1e9 / CLOCKS_PER_SEC * static_cast<double>(busy) / options.steps;
  return motion;
}

}  // namespace

Motion shoot(const control::Mechanism& mechanism, const Eigen::VectorXd& q,
             const Eigen::VectorXd& v, const ShootOptions& options) {
  control::Workspace workspace(mechanism);
  if (sharp(mechanism, workspace, q, v) == nullptr) refuse_singular(0.0);
  if (options.integrator == Integrator::kVariational) {
    control::VariationalIntegrator stepper(mechanism);
    return run(stepper, mechanism, q, v, options);
  }
  control::MuntheKaasIntegrator stepper(mechanism);
  return run(stepper, mechanism, q, v, options);
}

std::vector<Sample> straight_samples(const control::Mechanism& mechanism, const Motion& motion,
                                     const Eigen::VectorXd& to, int frame) {
  Recorder record(mechanism, frame);
  const Eigen::VectorXd from = motion.samples.front().q;
  const double duration_s = motion.samples.back().time_s;
  const Eigen::VectorXd way = straight(mechanism, from, to);
  const Eigen::VectorXd v = way / duration_s;
  Eigen::VectorXd q(from);
  std::vector<Sample> samples;
  for (const Sample& instant : motion.samples) {
    integrate(mechanism, from, way, instant.time_s / duration_s, q);
    samples.push_back(record(instant.time_s, q, v));
  }
  return samples;
}

Conservation judge(const control::Mechanism& mechanism, const Motion& motion) {
  Conservation result;
  const Sample& first = motion.samples.front();
  const auto n = static_cast<double>(motion.samples.size());
  // Relative to the energy there is; where the sum may be zero, to the kinetic part.
  const double scale = std::max({std::abs(first.energy_j), first.kinetic_j, 1e-300});
  double mean_t = 0.0;
  double mean_e = 0.0;
  for (const Sample& sample : motion.samples) {
    const double change = (sample.energy_j - first.energy_j) / scale;
    result.energy_band = std::max(result.energy_band, std::abs(change));
    mean_t += sample.time_s / n;
    mean_e += change / n;
  }
  double tt = 0.0;
  double te = 0.0;
  double ee = 0.0;
  for (const Sample& sample : motion.samples) {
    const double t = sample.time_s - mean_t;
    const double e = (sample.energy_j - first.energy_j) / scale - mean_e;
    tt += t * t;
    te += t * e;
    ee += e * e;
  }
  const double duration_s = motion.samples.back().time_s;
  if (tt > 0.0 && n > 2.0) {
    const double slope = te / tt;
    // Neighbouring instants swing together, which the standard error of independent ones would
    // not know: it is widened as for a first-order process (Bartlett 1946).
    double neighbours = 0.0;
    double last = 0.0;
    for (const Sample& sample : motion.samples) {
      const double rest =
          (sample.energy_j - first.energy_j) / scale - mean_e - slope * (sample.time_s - mean_t);
      neighbours += last * rest;
      last = rest;
    }
    const double spread = std::max(0.0, ee - te * slope);
    const double likeness = spread > 0.0 ? std::clamp(neighbours / spread, 0.0, 0.999) : 0.0;
    result.energy_drift = slope * duration_s;
    result.drift_noise =
        std::sqrt(spread / (n - 2.0) / tt * (1.0 + likeness) / (1.0 - likeness)) * duration_s;
  }
  if (!mechanism.floating() || !mechanism.gravity().isZero(0.0)) return result;
  // Where there is no momentum to compare with: that of the same energy, on a lever of a metre.
  const double typical = std::sqrt(2.0 * mechanism.moving_mass() * first.kinetic_j);
  const auto magnitude = [&](double norm) {
    return norm > 1e-6 * typical ? norm : std::max(typical, 1e-300);
  };
  const double linear = magnitude(first.momentum.head<3>().norm());
  const double angular = magnitude(first.momentum.tail<3>().norm());
  result.linear = 0.0;
  result.angular = 0.0;
  for (const Sample& sample : motion.samples) {
    const Eigen::Matrix<double, 6, 1> change = sample.momentum - first.momentum;
    result.linear = std::max(*result.linear, change.head<3>().norm() / linear);
    result.angular = std::max(*result.angular, change.tail<3>().norm() / angular);
  }
  return result;
}

}  // namespace geodesic::tools
