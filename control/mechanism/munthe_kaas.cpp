// Implements munthe_kaas.hpp.
#include "control/mechanism/munthe_kaas.hpp"

#include <cassert>

#include "control/geometry/se3.hpp"
#include "control/geometry/so3.hpp"
#include "control/mechanism/configuration.hpp"
#include "control/mechanism/forward_dynamics.hpp"
#include "control/mechanism/kinematics.hpp"

namespace geodesic::control {

MuntheKaasIntegrator::MuntheKaasIntegrator(const Mechanism& mechanism)
    : mechanism_(&mechanism), workspace_(mechanism) {
  for (Eigen::VectorXd* vector : {&q_, &q_stage_}) {
    vector->setZero(mechanism.nq());
  }
  for (Eigen::VectorXd* vector : {&no_force_, &v_, &u_stage_, &v_stage_}) {
    vector->setZero(mechanism.dof());
  }
  for (std::size_t k = 0; k < u_rate_.size(); ++k) {
    u_rate_[k].setZero(mechanism.dof());
    v_rate_[k].setZero(mechanism.dof());
  }
}

void MuntheKaasIntegrator::start(const VectorIn& q, const VectorIn& v) noexcept {
  assert(q.size() == mechanism_->nq() && v.size() == mechanism_->dof());
  q_ = q;
  v_ = v;
}

/// Rates at (u_stage_, v_stage_).
bool MuntheKaasIntegrator::stage(std::size_t k, const VectorIn& force) noexcept {
  integrate(*mechanism_, q_, u_stage_, 1.0, q_stage_);
  const Eigen::VectorXd* rate =
      forward_dynamics(*mechanism_, workspace_, q_stage_, v_stage_, force);
  if (rate == nullptr) return false;
  v_rate_[k] = *rate;
  u_rate_[k] = v_stage_;
  // dexp^-1_{-u} is the inverse of exp's right Jacobian; where the group commutes, 1.
  for (const Factor& factor : mechanism_->factors()) {
    if (factor.nq == factor.nv) continue;
    const Eigen::Vector3d u = u_stage_.segment<3>(factor.v + factor.nv - 3);
    if (factor.kind == JointKind::kFloating) {
      u_rate_[k].segment<6>(factor.v) =
          right_jacobian_inverse(Twist{u_stage_.segment<3>(factor.v), u}) *
          v_stage_.segment<6>(factor.v);
    } else if (factor.kind == JointKind::kSpherical) {
      u_rate_[k].segment<3>(factor.v) = right_jacobian_inverse(u) * v_stage_.segment<3>(factor.v);
    }
  }
  return true;
}

bool MuntheKaasIntegrator::step(double h, const VectorIn& force) noexcept {
  assert(force.size() == mechanism_->dof());
  u_stage_.setZero();
  v_stage_ = v_;
  if (!stage(0, force)) return false;
  for (std::size_t k = 1; k < 4; ++k) {
    const double share = k == 3 ? h : 0.5 * h;
    u_stage_ = share * u_rate_[k - 1];
    v_stage_ = v_ + share * v_rate_[k - 1];
    if (!stage(k, force)) return false;
  }
  u_stage_ = (h / 6.0) * (u_rate_[0] + 2.0 * (u_rate_[1] + u_rate_[2]) + u_rate_[3]);
  v_ += (h / 6.0) * (v_rate_[0] + 2.0 * (v_rate_[1] + v_rate_[2]) + v_rate_[3]);
  integrate(*mechanism_, q_, u_stage_, 1.0, q_);
  return true;
}

}  // namespace geodesic::control
