// Implements variational.hpp.
//
// How the step's equations come about. Displacements of q0, q1 and the centre c, each carried into
// the centre's frame as a twist, obey eta1 = eta + dtau(x) dx, eta0 = eta - dtau(-x) dx, with dtau
// trivialised from the right and split into E (even in x) and O (odd). Hence 2 dx = E^-1 (eta1 -
// eta0) and eta = (eta0 + eta1)/2 - O E^-1 (eta1 - eta0)/2; put into the variation of h L(c, xi),
//   d(h L) = dL/dv . 2 dx + h f . eta,
// the factors of eta1 and -eta0 are the momenta at both ends, in the centre's frame:
//   E^-T dL/dv - h/2 (O E^-1)^T f + h/2 f    and    E^-T dL/dv - h/2 (O E^-1)^T f - h/2 f.
// Their difference h f, carried to the joint's resting axes, changes the spatial momentum.
//   line:   E = 1, O = 0.
//   SO(3), Cayley's map with dtau = (1 + w^/2) / (1 + w.w/4):  E^-1 = 1 + w.w/4,  O E^-1 = w^/2.
//   SE(3), (u, w) -> (translation u, Cayley w):
//     E^-1 (a, b) = (a - u x (w x b)/2, (1 + w.w/4) b),  O E^-1 (a, b) = (u x b, w x b / 2).
#include "control/mechanism/variational.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cassert>
#include <cmath>

#include "control/mechanism/elimination.hpp"
#include "control/mechanism/metric.hpp"
#include "control/mechanism/musical.hpp"

namespace geodesic::control {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// Squared relative residual below which nothing is left to gain.
constexpr double kTolerance = 1e-31;
/// Squared relative residual that an iteration may stop at once it gains nothing more, and the one
/// that it may stop at when it has gained nothing twice: far from the world's origin the moment
/// about the base is a small difference of large numbers.
constexpr double kRoundingFloor = 1e-28;
constexpr double kFarFloor = 1e-20;
/// Steps after which the metric is factored anew: by then it has turned by some percent.
constexpr int kMetricSteps = 8;

/// Cayley's map: the rotation about w by the angle with tan(angle / 2) = |w| / 2.
Quaterniond cayley(const Vector3d& w) noexcept {
  const double scale = 1.0 / std::sqrt(1.0 + 0.25 * w.squaredNorm());
  Quaterniond turn;
  turn.w() = scale;
  turn.vec() = (0.5 * scale) * w;
  return turn;
}

Quaterniond quaternion_at(const VectorXd& q, int i) noexcept {
  return Quaterniond(q[i + 3], q[i], q[i + 1], q[i + 2]);
}

/// sum += change; what rounding loses of it is kept for the next time (Kahan 1965).
inline void add(double& sum, double& lost, double change) noexcept {
  const double wanted = change - lost;
  const double next = sum + wanted;
  lost = (next - sum) - wanted;
  sum = next;
}

}  // namespace

VariationalIntegrator::VariationalIntegrator(const Mechanism& mechanism)
    : mechanism_(&mechanism),
      workspace_(mechanism),
      lagrangian_(mechanism),
      metric_factor_(mechanism),
      jacobian_(mechanism.dof(), mechanism.dof()),
      pivots_(static_cast<std::size_t>(mechanism.dof())) {
  for (VectorXd* vector : {&q_, &q_lost_, &centre_}) {
    vector->setZero(mechanism.nq());
  }
  for (VectorXd* vector : {&no_force_, &momentum_, &momentum_lost_, &xi_, &x_, &target_, &force_,
                           &residual_, &correction_, &last_xi_, &trial_}) {
    vector->setZero(mechanism.dof());
  }
  past_.setZero(mechanism.dof(), 3);
  int next = 0;  // degree of freedom; mimic joints repeat earlier ones
  for (const Body& body : mechanism.bodies()) {
    if (body.dof < next) continue;
    const Group group = body.motion == Motion::kFree        ? Group::kSe3
                        : body.motion == Motion::kSpherical ? Group::kSo3
                                                            : Group::kLine;
    factors_.push_back({group, body.coordinate, body.dof});
    next = body.dof + freedoms(body.motion);
  }
}

void VariationalIntegrator::start(const VectorIn& q, const VectorIn& v) noexcept {
  assert(q.size() == mechanism_->nq() && v.size() == mechanism_->dof());
  q_ = q;
  q_lost_.setZero();
  momentum_lost_.setZero();
  xi_ = v;
  past_count_ = 0;
  metric_age_ = 0;
  lagrangian_.update(q_, v);
  momentum_ = lagrangian_.momentum();
  for (const Factor& factor : factors_) {
    if (factor.group == Group::kLine) continue;
    const bool free = factor.group == Group::kSe3;
    const int angular = factor.v + (free ? 3 : 0);
    auto orientation = q_.segment<4>(factor.q + (free ? 3 : 0));
    orientation.normalize();
    const Quaterniond turn = quaternion_at(q_, factor.q + (free ? 3 : 0));
    momentum_.segment<3>(angular) = turn * Vector3d(momentum_.segment<3>(angular));
    if (!free) continue;
    momentum_.segment<3>(factor.v) = turn * Vector3d(momentum_.segment<3>(factor.v));
    momentum_.segment<3>(angular) +=
        Vector3d(q_.segment<3>(factor.q)).cross(Vector3d(momentum_.segment<3>(factor.v)));
  }
}

/// c = q tau(-x)^-1.
void VariationalIntegrator::centre() noexcept {
  for (const Factor& factor : factors_) {
    if (factor.group == Group::kLine) {
      centre_[factor.q] = q_[factor.q] + (x_[factor.v] - q_lost_[factor.q]);
      continue;
    }
    const bool free = factor.group == Group::kSe3;
    const int turn = factor.q + (free ? 3 : 0);
    const Vector3d w = x_.segment<3>(factor.v + (free ? 3 : 0));
    const Quaterniond orientation = (quaternion_at(q_, turn) * cayley(w)).normalized();
    centre_.segment<4>(turn) = orientation.coeffs();
    if (!free) continue;
    centre_.segment<3>(factor.q) =
        q_.segment<3>(factor.q) +
        (orientation * Vector3d(x_.segment<3>(factor.v)) - q_lost_.segment<3>(factor.q));
  }
}

/// The spatial momentum in the axes of the centre, about its origin.
void VariationalIntegrator::carry_to_centre() noexcept {
  for (const Factor& factor : factors_) {
    if (factor.group == Group::kLine) {
      target_[factor.v] = momentum_[factor.v];
      continue;
    }
    const bool free = factor.group == Group::kSe3;
    const int angular = factor.v + (free ? 3 : 0);
    const Quaterniond back = quaternion_at(centre_, factor.q + (free ? 3 : 0)).conjugate();
    Vector3d moment = momentum_.segment<3>(angular);
    if (free) {
      const Vector3d force = momentum_.segment<3>(factor.v);
      moment -= Vector3d(centre_.segment<3>(factor.q)).cross(force);
      target_.segment<3>(factor.v) = back * force;
    }
    target_.segment<3>(angular) = back * moment;
  }
}

/// The equation's two sides at xi_: their difference into residual_, the force into force_.
void VariationalIntegrator::evaluate(double h, const VectorIn& force) noexcept {
  ++evaluations_;
  x_ = (0.5 * h) * xi_;
  centre();
  carry_to_centre();
  lagrangian_.update(centre_, xi_);
  force_ = lagrangian_.force() + force;
  residual_ = lagrangian_.momentum() - (0.5 * h) * force_ - target_;
  for (const Factor& factor : factors_) {
    if (factor.group == Group::kLine) continue;
    const bool free = factor.group == Group::kSe3;
    const int angular = factor.v + (free ? 3 : 0);
    const Vector3d w = x_.segment<3>(angular);
    Vector3d more = (0.25 * w.squaredNorm()) * lagrangian_.momentum().segment<3>(angular) +
                    (0.25 * h) * w.cross(Vector3d(force_.segment<3>(angular)));
    if (free) {
      const Vector3d u = x_.segment<3>(factor.v);
      more -= 0.5 * w.cross(u.cross(Vector3d(lagrangian_.momentum().segment<3>(factor.v))));
      more += (0.5 * h) * u.cross(Vector3d(force_.segment<3>(factor.v)));
    }
    residual_.segment<3>(angular) += more;
  }
}

bool VariationalIntegrator::refresh_metric() noexcept {
  metric_age_ = metric_factor_.factor(metric(*mechanism_, workspace_, centre_)) ? 1 : 0;
  return metric_age_ > 0;
}

/// The derivative of the residual by central differences, factored.
bool VariationalIntegrator::refresh_jacobian(double h, const VectorIn& force) noexcept {
  constexpr double kCubeRoot = 6e-6;  // of the rounding unit
  trial_ = xi_;
  const double width = kCubeRoot * std::max(1.0, trial_.cwiseAbs().maxCoeff());
  for (Eigen::Index j = 0; j < trial_.size(); ++j) {
    xi_[j] = trial_[j] + width;
    evaluate(h, force);
    jacobian_.col(j) = residual_;
    xi_[j] = trial_[j] - width;
    evaluate(h, force);
    jacobian_.col(j) = (jacobian_.col(j) - residual_) / (2.0 * width);
    xi_[j] = trial_[j];
  }
  return eliminate(jacobian_, pivots_);
}

/// First guess of the mean velocity: the parabola through the last three.
void VariationalIntegrator::predict() noexcept {
  if (past_count_ >= 3) {
    xi_ = 3.0 * (past_.col(0) - past_.col(1)) + past_.col(2);
  } else if (past_count_ == 2) {
    xi_ = 2.0 * past_.col(0) - past_.col(1);
  }
}

/// Newton's iteration with the metric of a recent centre in place of the derivative, from which it
/// differs by the order of h; where that converges slowly, with the derivative itself, damped.
bool VariationalIntegrator::solve(double h, const VectorIn& force) noexcept {
  bool newton = false;
  bool was_slow = false;
  double last = 0.0;
  for (int round = 0; round < kMostIterations; ++round) {
    evaluate(h, force);
    if (round == 0 && (metric_age_ == 0 || metric_age_ > kMetricSteps) && !refresh_metric()) {
      return false;
    }
    // The residual's size in the metric of momenta, against that of the momentum itself.
    correction_ = residual_;
    metric_factor_.solve(correction_);
    const double size = std::abs(residual_.dot(correction_));
    const double scale = std::abs(lagrangian_.momentum().dot(xi_));
    if (size <= kTolerance * scale) return true;
    const bool slow = last > 0.0 && !(size <= 0.01 * last);
    const bool worse = last > 0.0 && !(size <= last);
    if (slow && size <= (was_slow ? kFarFloor : kRoundingFloor) * scale) return true;
    if (last == 0.0 && !std::isfinite(size)) return false;
    was_slow = slow;
    if (newton && worse) {  // too far: half the way back
      xi_ += 0.5 * trial_;
      trial_ *= 0.5;
      continue;
    }
    if (!newton && slow && metric_age_ <= 1 && (worse || round > 4)) {
      newton = true;
      xi_ = last_xi_;
      last = 0.0;
      continue;
    }
    if (newton) {
      correction_ = residual_;
      if (!refresh_jacobian(h, force)) return false;
      back_substitute(jacobian_, pivots_, correction_);
      trial_ = correction_;
    } else if (slow && metric_age_ > 1) {
      if (!refresh_metric()) return false;
      correction_ = residual_;
      metric_factor_.solve(correction_);
    }
    xi_ -= correction_;
    last = size;
  }
  return false;
}

/// Takes the step whose equation xi_ solves.
void VariationalIntegrator::advance(double h) noexcept {
  for (const Factor& factor : factors_) {
    if (factor.group == Group::kLine) {
      add(q_[factor.q], q_lost_[factor.q], 2.0 * x_[factor.v]);
      add(momentum_[factor.v], momentum_lost_[factor.v], h * force_[factor.v]);
      continue;
    }
    const bool free = factor.group == Group::kSe3;
    const int turn = factor.q + (free ? 3 : 0);
    const int angular = factor.v + (free ? 3 : 0);
    const Quaterniond orientation = quaternion_at(centre_, turn);
    Vector3d moment = orientation * Vector3d(force_.segment<3>(angular));
    if (free) {
      const Vector3d push = orientation * Vector3d(force_.segment<3>(factor.v));
      const Vector3d way = orientation * Vector3d(x_.segment<3>(factor.v));
      moment += Vector3d(centre_.segment<3>(factor.q)).cross(push);
      for (int k = 0; k < 3; ++k) {
        add(q_[factor.q + k], q_lost_[factor.q + k], 2.0 * way[k]);
        add(momentum_[factor.v + k], momentum_lost_[factor.v + k], h * push[k]);
      }
    }
    for (int k = 0; k < 3; ++k) {
      add(momentum_[angular + k], momentum_lost_[angular + k], h * moment[k]);
    }
    q_.segment<4>(turn) = (orientation * cayley(x_.segment<3>(angular))).normalized().coeffs();
  }
}

void VariationalIntegrator::remember() noexcept {
  past_.col(2) = past_.col(1);
  past_.col(1) = past_.col(0);
  past_.col(0) = xi_;
  past_count_ = std::min(past_count_ + 1, 3);
  ++metric_age_;
}

bool VariationalIntegrator::step(double h, const VectorIn& force) noexcept {
  assert(force.size() == mechanism_->dof());
  if (h != past_h_) {
    past_count_ = 0;
    metric_age_ = 0;
    past_h_ = h;
  }
  evaluations_ = 0;
  last_xi_ = xi_;
  predict();
  if (!solve(h, force)) {
    xi_ = last_xi_;
    past_count_ = 0;
    metric_age_ = 0;
    return false;
  }
  advance(h);
  remember();
  return true;
}

const VectorXd* VariationalIntegrator::velocity() noexcept {
  centre_ = q_;
  carry_to_centre();
  return sharp(*mechanism_, workspace_, q_, target_);
}

}  // namespace geodesic::control
