// Motion by the Runge-Kutta method of Munthe-Kaas on the configuration manifold, order four: more
// accurate than variational.hpp for a short while, without its conserved quantities.
#pragma once

#include <Eigen/Core>
#include <array>

#include "control/mechanism/mechanism.hpp"
#include "control/mechanism/workspace.hpp"

namespace geodesic::control {

/// One motion of one mechanism, step by step.
///
/// Within a step q = q0 exp(u), factor by factor of Q, and the classical method of order four runs
/// on the pair (u, v) of numbers: du/dt = dexp^-1_{-u}(v), dv/dt = forward dynamics at (q0 exp(u),
/// v). No projection is needed: q stays on the manifold. Sources: Munthe-Kaas 1999, "High order
/// Runge-Kutta methods on manifolds"; Hairer, Lubich, Wanner 2006, section IV.8.
class MuntheKaasIntegrator {
 public:
  /// Keeps a reference: the mechanism must outlive it. Not real-time: allocates all there is.
  explicit MuntheKaasIntegrator(const Mechanism& mechanism);

  /// Starts at q [nq] with velocity v [nv]. Real-time.
  void start(const VectorIn& q, const VectorIn& v) noexcept;

  /// One step of `h` seconds; negative: back in time.
  /// @param force  covector that acts all along the step, size nv [N·m, N]
  /// @return  false, the state left as it was, if M is singular. Real-time: four calls of
  ///   forward_dynamics().
  bool step(double h, const VectorIn& force) noexcept;
  bool step(double h) noexcept { return step(h, no_force_); }

  /// Size nq.
  const Eigen::VectorXd& q() const noexcept { return q_; }
  /// Size nv.
  const Eigen::VectorXd& velocity() const noexcept { return v_; }

 private:
  bool stage(std::size_t k, const VectorIn& force) noexcept;

  const Mechanism* mechanism_;
  Workspace workspace_;
  Eigen::VectorXd no_force_, q_, v_;
  Eigen::VectorXd u_stage_, q_stage_, v_stage_;
  std::array<Eigen::VectorXd, 4> u_rate_;
  std::array<Eigen::VectorXd, 4> v_rate_;
};

}  // namespace geodesic::control
