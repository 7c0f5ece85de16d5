// Implements geodesic_between.hpp.
#include "control/mechanism/geodesic_between.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>
#include <vector>

#include "control/geometry/so3.hpp"
#include "control/mechanism/configuration.hpp"
#include "control/mechanism/elimination.hpp"
#include "control/mechanism/energy.hpp"
#include "control/mechanism/kinematics.hpp"
#include "control/mechanism/munthe_kaas.hpp"

namespace geodesic::control {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Newton's rounds for one part of the way before the part is halved.
constexpr int kRounds = 12;
/// The smallest part of the way tried.
constexpr double kSmallestPart = 1.0 / 256.0;

class Shooting {
 public:
  Shooting(const Mechanism& mechanism, const VectorIn& from, const GeodesicOptions& options)
      : mechanism_(mechanism),
        from_(from),
        options_(options),
        motion_(mechanism),
        jacobian_(mechanism.dof(), mechanism.dof()),
        pivots_(static_cast<std::size_t>(mechanism.dof())) {}

  /// End of the motion with start velocity v; false if M is singular on the way.
  bool shoot(const VectorXd& v, VectorXd& end) {
    motion_.start(from_, v);
    const double h = options_.duration_s / options_.steps;
    for (int k = 0; k < options_.steps; ++k) {
      if (!motion_.step(h)) return false;
    }
    end = motion_.q();
    return end.allFinite();
  }

  /// Newton's iteration for `target` from v, which it improves.
  GeodesicOutcome solve(const VectorXd& target, VectorXd& v, double& miss, int& shots) {
    VectorXd end;
    if (!shoot(v, end)) return GeodesicOutcome::kSingularMetric;
    VectorXd gap = straight(mechanism_, end, target);
    miss = largest(gap);
    for (int round = 0; round < kRounds && shots < options_.most_shots; ++round) {
      if (miss <= options_.tolerance) return GeodesicOutcome::kFound;
      ++shots;
      if (!differentiate(v, target, gap)) return GeodesicOutcome::kSingularMetric;
      if (!eliminate(jacobian_, pivots_)) return GeodesicOutcome::kConjugate;
      VectorXd stride = gap;
      back_substitute(jacobian_, pivots_, stride);
      // The whole stride, or as much of it as brings the end nearer.
      bool nearer = false;
      for (double share = 1.0; share > 0.05 && !nearer; share *= 0.5) {
        const VectorXd trial = v + share * stride;
        if (!shoot(trial, end)) continue;
        const VectorXd trial_gap = straight(mechanism_, end, target);
        if (largest(trial_gap) < (1.0 - 0.25 * share) * miss) {
          nearer = true;
          v = trial;
          gap = trial_gap;
          miss = largest(gap);
        }
      }
      if (!nearer) break;
    }
    return miss <= options_.tolerance ? GeodesicOutcome::kFound : GeodesicOutcome::kNotFound;
  }

  /// First step at which the determinant of the Jacobi fields changes sign.
  std::optional<double> conjugate(const VectorXd& v) {
    const Eigen::Index n = v.size();
    std::vector<MuntheKaasIntegrator> fields;
    for (Eigen::Index j = 0; j < 2 * n; ++j) {
      VectorXd beside = v;
      beside[j / 2] += (j % 2 == 0 ? 1.0 : -1.0) * width(v);
      fields.emplace_back(mechanism_);
      fields.back().start(from_, beside);
    }
    const double h = options_.duration_s / options_.steps;
    for (int k = 0; k < options_.steps; ++k) {
      for (MuntheKaasIntegrator& field : fields) {
        if (!field.step(h)) return std::nullopt;
      }
      for (Eigen::Index j = 0; j < n; ++j) {
        const auto at = static_cast<std::size_t>(2 * j);
        jacobian_.col(j) = straight(mechanism_, fields[at + 1].q(), fields[at].q());
      }
      // Near the start the fields are h times the unit matrix: positive.
      if (!eliminate(jacobian_, pivots_) || determinant_sign(jacobian_, pivots_) < 0) {
        return h * (k + 1);
      }
    }
    return std::nullopt;
  }

 private:
  static double largest(const VectorXd& x) { return x.size() == 0 ? 0.0 : x.cwiseAbs().maxCoeff(); }
  double width(const VectorXd& v) const {
    return 1e-5 * std::max(1.0 / options_.duration_s, largest(v));
  }

  /// Derivative of -gap(v) = straight(target, end): the Jacobi fields at the end, as the gap sees
  /// them.
  bool differentiate(const VectorXd& v, const VectorXd& target, const VectorXd& gap) {
    VectorXd end;
    const double w = width(v);
    for (Eigen::Index j = 0; j < v.size(); ++j) {
      VectorXd beside = v;
      beside[j] = v[j] + w;
      if (!shoot(beside, end)) return false;
      jacobian_.col(j) = -straight(mechanism_, end, target);
      beside[j] = v[j] - w;
      if (!shoot(beside, end)) return false;
      jacobian_.col(j) = (jacobian_.col(j) + straight(mechanism_, end, target)) / (2.0 * w);
    }
    return gap.allFinite();
  }

  const Mechanism& mechanism_;
  VectorXd from_;
  const GeodesicOptions& options_;
  MuntheKaasIntegrator motion_;
  MatrixXd jacobian_;
  std::vector<Eigen::Index> pivots_;
};

/// Simpson's rule over energies at 2n + 1 equal distances in time.
Action sum(const std::vector<double>& energy, double duration_s) {
  Action result;
  result.lowest_energy = *std::min_element(energy.begin(), energy.end());
  result.highest_energy = *std::max_element(energy.begin(), energy.end());
  const std::size_t last = energy.size() - 1;
  for (std::size_t k = 0; k <= last; ++k) {
    const double weight = k == 0 || k == last ? 1.0 : k % 2 == 1 ? 4.0 : 2.0;
    result.action += weight * energy[k];
    result.length += weight * std::sqrt(2.0 * std::max(0.0, energy[k]));
  }
  const double share = duration_s / (3.0 * static_cast<double>(last));
  result.action *= share;
  result.length *= share;
  return result;
}

void check(const Mechanism& mechanism, const VectorIn& from, const VectorIn& to,
           const GeodesicOptions& options) {
  if (!mechanism.gravity().isZero(0.0)) {
    throw std::invalid_argument("geodesic_between: the mechanism must have no gravity");
  }
  if (from.size() != mechanism.nq() || to.size() != mechanism.nq()) {
    throw std::invalid_argument("geodesic_between: a configuration has the wrong size");
  }
  if (!(options.duration_s > 0.0) || options.steps < 1 || !(options.tolerance > 0.0)) {
    throw std::invalid_argument("geodesic_between: duration, steps and tolerance must be positive");
  }
}

}  // namespace

VectorXd straight(const Mechanism& mechanism, const VectorIn& q0, const VectorIn& q1) {
  VectorXd v(mechanism.dof());
  for (const Factor& factor : mechanism.factors()) {
    if (factor.nq == factor.nv) {
      v.segment(factor.v, factor.nv) =
          q1.segment(factor.q, factor.nq) - q0.segment(factor.q, factor.nq);
      continue;
    }
    const int at = factor.q + factor.nq - 4;
    const auto turn = [at](const VectorIn& q) {
      return Eigen::Quaterniond(q[at + 3], q[at], q[at + 1], q[at + 2]).normalized();
    };
    const Eigen::Quaterniond back = turn(q0).conjugate();
    const Eigen::Vector3d w = log(back * turn(q1));
    v.segment<3>(factor.v + factor.nv - 3) = w;
    if (factor.kind != JointKind::kFloating) continue;
    v.segment<3>(factor.v) =
        left_jacobian_inverse(w) *
        (back * Eigen::Vector3d(q1.segment<3>(factor.q) - q0.segment<3>(factor.q)));
  }
  return v;
}

GeodesicBetween geodesic_between(const Mechanism& mechanism, const VectorIn& from,
                                 const VectorIn& to, const GeodesicOptions& options) {
  check(mechanism, from, to, options);
  const VectorXd way = straight(mechanism, from, to);
  GeodesicBetween result;
  result.start_velocity = VectorXd::Zero(mechanism.dof());
  Shooting shooting(mechanism, from, options);
  VectorXd target(mechanism.nq());
  double part = 1.0;
  GeodesicOutcome outcome = GeodesicOutcome::kNotFound;
  while (result.solved < 1.0 && part >= kSmallestPart && result.shots < options.most_shots) {
    const double wanted = std::min(1.0, result.solved + part);
    integrate(mechanism, from, way, wanted, target);
    if (wanted == 1.0) target = to;
    // From rest the straight line is the better guess, later the geodesic scaled.
    VectorXd v = result.solved > 0.0 ? VectorXd(result.start_velocity * (wanted / result.solved))
                                     : VectorXd(way * (wanted / options.duration_s));
    double miss = 0.0;
    outcome = shooting.solve(target, v, miss, result.shots);
    if (outcome == GeodesicOutcome::kFound) {
      result.solved = wanted;
      result.start_velocity = std::move(v);
      result.miss = miss;
      part = std::min(2.0 * part, 1.0);
    } else {
      part *= 0.5;
    }
    if (options.on_progress) options.on_progress(result.solved);
  }
  result.outcome = result.solved == 1.0 ? GeodesicOutcome::kFound : outcome;
  if (result.outcome == GeodesicOutcome::kFound) {
    result.conjugate_s = shooting.conjugate(result.start_velocity);
  } else {
    VectorXd end;
    if (shooting.shoot(result.start_velocity, end)) {
      result.miss = straight(mechanism, end, to).cwiseAbs().maxCoeff();
    }
  }
  return result;
}

Action geodesic_action(const Mechanism& mechanism, const VectorIn& q, const VectorIn& v,
                       double duration_s, int steps) {
  Workspace workspace(mechanism);
  MuntheKaasIntegrator motion(mechanism);
  motion.start(q, v);
  const int even = steps + steps % 2;
  std::vector<double> energy;
  for (int k = 0;; ++k) {
    energy.push_back(kinetic_energy(mechanism, workspace, motion.q(), motion.velocity()));
    if (k == even) break;
    if (!motion.step(duration_s / even)) {
      throw std::invalid_argument("geodesic_action: M is singular on the way");
    }
  }
  return sum(energy, duration_s);
}

Action straight_action(const Mechanism& mechanism, const VectorIn& from, const VectorIn& to,
                       double duration_s, int steps) {
  Workspace workspace(mechanism);
  const VectorXd way = straight(mechanism, from, to);
  const VectorXd v = way / duration_s;
  VectorXd q(mechanism.nq());
  const int even = steps + steps % 2;
  std::vector<double> energy;
  for (int k = 0; k <= even; ++k) {
    integrate(mechanism, from, way, static_cast<double>(k) / even, q);
    energy.push_back(kinetic_energy(mechanism, workspace, q, v));
  }
  return sum(energy, duration_s);
}

}  // namespace geodesic::control
