// The Lagrangian's two derivatives, along the velocity and along the configuration, in one pass
// over the tree: all that an integrator on the manifold asks of a mechanism. The steps themselves
// are in variational.hpp and munthe_kaas.hpp.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "control/mechanism/mechanism.hpp"
#include "control/mechanism/workspace.hpp"

namespace geodesic::control {

/// The derivatives of L(q, v) = v' M(q) v / 2 - U(q), with the tangent bundle trivialised from the
/// left: q moves to q exp(eta) while the numbers of v stay.
class LagrangianDerivatives {
 public:
  /// Not real-time: allocates.
  explicit LagrangianDerivatives(const Mechanism& mechanism);

  /// @param q  size nq    @param v  size nv    Real-time, O(n).
  ///
  /// With V the twist of a body, S v its joint's share of it, h the momentum of all that the joint
  /// carries, everything in the body's own axes:
  ///   dL/dv     = S' h,
  ///   dL/dq eta = h . [V - S v, S eta] - weight . S eta.
  /// The bracket is what a displacement of the joint does to the twist handed on by the parent
  /// (Featherstone 2008, equation 2.45, for joints of one degree of freedom); of a joint on the
  /// world nothing remains of it, which is how its symmetry shows.
  void update(const VectorIn& q, const VectorIn& v) noexcept;

  /// dL/dv = M(q) v, size nv [kg·m/s, kg·m²/s].
  const Eigen::VectorXd& momentum() const noexcept { return momentum_; }
  /// dL/dq, size nv [N, N·m].
  const Eigen::VectorXd& force() const noexcept { return force_; }

 private:
  struct BodyState {
    Pose parent_from_body;
    Twist velocity;
    Twist handed_on;  ///< the parent's twist in this body's coordinates
    Wrench momentum;  ///< of this body and all it carries
    Eigen::Vector3d up = Eigen::Vector3d::Zero();
    Wrench weight;  ///< of this body and all it carries, as the force that holds it
  };

  const Mechanism* mechanism_;
  bool weightless_;
  std::vector<BodyState> body_;
  Eigen::VectorXd momentum_;
  Eigen::VectorXd force_;
};

}  // namespace geodesic::control
