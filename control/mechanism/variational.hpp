// Motion by a variational integrator on the configuration manifold: discrete Lagrange-d'Alembert
// with the midpoint's Lagrangian. Symplectic, reversible, of order two; it keeps the momentum of
// every symmetry to rounding. Runge-Kutta-Munthe-Kaas is in munthe_kaas.hpp.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "control/mechanism/cholesky.hpp"
#include "control/mechanism/lagrangian_derivatives.hpp"
#include "control/mechanism/mechanism.hpp"
#include "control/mechanism/workspace.hpp"

namespace geodesic::control {

/// One motion of one mechanism, step by step.
///
/// A step of length h and mean velocity xi leads from q0 = c tau(-x) over its centre c to
/// q1 = c tau(x), x = h xi / 2, where tau is a sum on S1 and R, Cayley's map on SO(3), and on SE(3)
/// Cayley's map beside a translation along the centre's axes. The discrete Lagrangian h L(c, xi) is
/// invariant under every left translation that leaves L invariant, so Noether's theorem holds step
/// by step (Marsden, West 2001, section 1.3.3), not to the order of h.
///
/// The state is q and, joint by joint, the momentum in the joint's resting axes: spatial momentum.
/// In these variables the step is (E and O: even and odd part of tau's right-trivialised
/// derivative, f: force at the centre, Ad*: carried to the resting axes)
///   Ad* (E^-T dL/dv - h/2 (1 + (O E^-1)^T) f) = momentum0        solved for xi,
///   momentum1 = momentum0 + h Ad* f.
/// A free floating base has f = 0: its six numbers of momentum are not even rounded. Sums over
/// steps are compensated (Kahan 1965), so that a million steps leave no trace on the energy.
///
/// Sources: Marsden, West 2001, "Discrete mechanics and variational integrators", section 1.5 and
/// 3.2; Bou-Rabee, Marsden 2009, "Hamilton-Pontryagin integrators on Lie groups", section 4;
/// Kobilarov, Marsden 2011, "Discrete geometric optimal control on Lie groups", section 5 (Cayley).
class VariationalIntegrator {
 public:
  /// Keeps a reference: the mechanism must outlive it. Not real-time: allocates all there is.
  explicit VariationalIntegrator(const Mechanism& mechanism);

  /// Starts at q [nq] with velocity v [nv]. Real-time, O(n).
  void start(const VectorIn& q, const VectorIn& v) noexcept;

  /// One step of `h` seconds; negative: back in time.
  /// @param force  covector that acts all along the step, size nv [N·m, N]
  /// @return  false, the state left as it was, if Newton's iteration found no root (the step turns
  ///   joints too far) or M is singular. Real-time: at most kMostIterations rounds.
  bool step(double h, const VectorIn& force) noexcept;
  bool step(double h) noexcept { return step(h, no_force_); }

  /// Size nq.
  const Eigen::VectorXd& q() const noexcept { return q_; }
  /// Size nv: joint by joint the momentum in the joint's resting axes, about its resting origin; of
  /// a floating base the momentum of the whole mechanism about the world's origin.
  const Eigen::VectorXd& spatial_momentum() const noexcept { return momentum_; }
  /// v with M(q) v = momentum, size nv, valid until the next call; null if M is singular.
  /// Real-time, O(n^3): call it where it is looked at, not at every step.
  const Eigen::VectorXd* velocity() noexcept;
  /// Mean velocity of the last step [nv].
  const Eigen::VectorXd& mean_velocity() const noexcept { return xi_; }
  /// Evaluations of the Lagrangian in the last step.
  int evaluations() const noexcept { return evaluations_; }

  static constexpr int kMostIterations = 60;

 private:
  enum class Group : unsigned char { kLine, kSo3, kSe3 };
  struct Factor {
    Group group;
    int q;
    int v;
  };

  void centre() noexcept;
  void carry_to_centre() noexcept;
  void evaluate(double h, const VectorIn& force) noexcept;
  bool refresh_metric() noexcept;
  bool refresh_jacobian(double h, const VectorIn& force) noexcept;
  void predict() noexcept;
  bool solve(double h, const VectorIn& force) noexcept;
  void advance(double h) noexcept;
  void remember() noexcept;

  const Mechanism* mechanism_;
  Workspace workspace_;
  LagrangianDerivatives lagrangian_;
  std::vector<Factor> factors_;
  Eigen::VectorXd no_force_;
  Eigen::VectorXd q_, q_lost_;                // state, and what its sums lost to rounding
  Eigen::VectorXd momentum_, momentum_lost_;  // likewise
  Eigen::VectorXd xi_, x_, centre_, target_, force_, residual_, correction_, last_xi_, trial_;
  Eigen::MatrixXd past_;        // mean velocities of the last steps, newest first
  TreeCholesky metric_factor_;  // of a recent centre: nearly the derivative of the equations
  Eigen::MatrixXd jacobian_;    // the derivative itself, by differences, factored; rarely needed
  std::vector<Eigen::Index> pivots_;
  double past_h_ = 0.0;
  int past_count_ = 0;
  int metric_age_ = 0;  // steps; 0: none
  int evaluations_ = 0;
};

}  // namespace geodesic::control
