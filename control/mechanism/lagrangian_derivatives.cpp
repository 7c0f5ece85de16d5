// Implements lagrangian_derivatives.hpp.
#include "control/mechanism/lagrangian_derivatives.hpp"

#include <Eigen/Geometry>
#include <cassert>

#include "control/mechanism/joint_motion.hpp"

namespace geodesic::control {
namespace {

/// Adds the components of `wrench` along the joint's degrees of freedom.
inline void add_components(const Body& body, const Wrench& wrench, Eigen::VectorXd& sum) noexcept {
  for (int k = 0; k < freedoms(body.motion); ++k) {
    sum[body.dof + k] += along_axis(body, wrench, k);
  }
}

inline Wrench minus(const Wrench& a) noexcept {
  return {-a.force, -a.moment};
}

}  // namespace

LagrangianDerivatives::LagrangianDerivatives(const Mechanism& mechanism)
    : mechanism_(&mechanism),
      weightless_(mechanism.gravity().isZero(0.0)),
      body_(mechanism.bodies().size()),
      momentum_(Eigen::VectorXd::Zero(mechanism.dof())),
      force_(Eigen::VectorXd::Zero(mechanism.dof())) {}

void LagrangianDerivatives::update(const VectorIn& q, const VectorIn& v) noexcept {
  assert(q.size() == mechanism_->nq() && v.size() == mechanism_->dof());
  const auto& bodies = mechanism_->bodies();
  // Outwards: twists, and which way is up.
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const Body& body = bodies[i];
    BodyState& state = body_[i];
    state.parent_from_body = parent_from_body(body, q);
    const bool on_world = body.parent == kWorld;
    const BodyState& parent = body_[on_world ? i : static_cast<std::size_t>(body.parent)];
    state.handed_on = on_world ? Twist{} : to_child(state.parent_from_body, parent.velocity);
    state.velocity = state.handed_on + joint_twist(body, v);
    state.momentum = body.inertia * state.velocity;
    if (!weightless_) {
      state.up.noalias() = state.parent_from_body.rotation.transpose() *
                           (on_world ? Eigen::Vector3d(-mechanism_->gravity()) : parent.up);
      state.weight = {body.inertia.mass * state.up, body.inertia.first_moment.cross(state.up)};
    }
  }
  // Inwards: momentum and weight of all that each joint carries.
  momentum_ = mechanism_->rotor_inertia().cwiseProduct(v);
  force_.setZero();
  for (std::size_t i = bodies.size(); i-- > 0;) {
    const Body& body = bodies[i];
    const BodyState& state = body_[i];
    add_components(body, state.momentum, momentum_);
    if (body.parent != kWorld) {
      add_components(body, minus(cross(state.handed_on, state.momentum)), force_);
      BodyState& parent = body_[static_cast<std::size_t>(body.parent)];
      parent.momentum += to_parent(state.parent_from_body, state.momentum);
      if (!weightless_) parent.weight += to_parent(state.parent_from_body, state.weight);
    }
    if (!weightless_) add_components(body, minus(state.weight), force_);
  }
}

}  // namespace geodesic::control
