// Implements curvature.hpp.
//
// With N = II(Y, Z), which is normal, <N, II(X, E_l)> = <N, D_X E_l>. Of a column s of joint l in
// the coordinates of its body, and a body b that it moves,
//   D_X E_l at r = s x (X r) + [X_l, s] r        (D_X (G s^) with Ad(l to b) s fixed in l),
// X r and [X_l, s] r the velocities of twists at r, so that summed over everything that l carries
//   <N, D_X E_l> = s.angular . sum m (X r) x N(r)  +  dot(wrench of N, [X_l, s]):
// a couple (three numbers) and a wrench (six) travel inwards.
#include "control/mechanism/curvature.hpp"

#include <cassert>
#include <limits>

#include "control/mechanism/kinematics.hpp"
#include "control/mechanism/metric.hpp"
#include "control/mechanism/particle_field.hpp"

namespace geodesic::control {
namespace {

/// N = II(X, Y) into workspace.field[].linear and turning; the metric at the point is factored.
void second_fundamental_form(const Mechanism& mechanism, Workspace& workspace, const VectorIn& x,
                             const VectorIn& y) noexcept {
  second_derivatives(mechanism, workspace, x, y);
  Eigen::VectorXd& tangent = workspace.connection;
  tangential_part(mechanism, workspace, tangent);
  workspace.cholesky.solve(tangent);
  const Twist at_rest;
  for (std::size_t i = 0; i < mechanism.bodies().size(); ++i) {
    const Body& body = mechanism.bodies()[i];
    auto& state = workspace.field[i];
    const Twist& parent = body.parent == kWorld
                              ? at_rest
                              : workspace.field[static_cast<std::size_t>(body.parent)].rate;
    state.rate = body_velocity(body, workspace.body[i].parent_from_body, parent, tangent);
    state.linear -= state.rate.linear;
    state.turning -= hat(state.rate.angular);
  }
}

/// Twists of the field X.
void set_x(const Mechanism& mechanism, Workspace& workspace, const VectorIn& x) noexcept {
  const Twist at_rest;
  for (std::size_t i = 0; i < mechanism.bodies().size(); ++i) {
    const Body& body = mechanism.bodies()[i];
    const Twist& parent =
        body.parent == kWorld ? at_rest : workspace.field[static_cast<std::size_t>(body.parent)].x;
    workspace.field[i].x = body_velocity(body, workspace.body[i].parent_from_body, parent, x);
  }
}

/// Calls add(l, <N, II(X, E_l)>) for the N and the X in the workspace; several times for an l that
/// moves several joints.
template <class Add>
void against_normal(const Mechanism& mechanism, Workspace& workspace, Add add) noexcept {
  const auto& bodies = mechanism.bodies();
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    auto& state = workspace.field[i];
    state.wrench = weigh(bodies[i].inertia, state.linear, state.turning);
    state.couple = couple(bodies[i].inertia, state.x, state.linear, state.turning);
  }
  for (std::size_t i = bodies.size(); i-- > 0;) {
    const Body& body = bodies[i];
    const auto& state = workspace.field[i];
    for (int k = 0; k < freedoms(body.motion); ++k) {
      add(body.dof + k,
          state.couple.dot(axis(body, k).angular) + dot(state.wrench, axis_rate(body, state.x, k)));
    }
    if (body.parent != kWorld) {
      const Pose& pose = workspace.body[i].parent_from_body;
      auto& parent = workspace.field[static_cast<std::size_t>(body.parent)];
      parent.wrench += to_parent(pose, state.wrench);
      parent.couple += pose.rotation * state.couple;
    }
  }
}

bool prepare(const Mechanism& mechanism, Workspace& workspace, const VectorIn& q) noexcept {
  if (!workspace.cholesky.factor(metric(mechanism, workspace, q))) {
    return false;
  }
  update_poses(mechanism, workspace, q);
  return true;
}

void add_curvature(const Mechanism& mechanism, Workspace& workspace, const VectorIn& x,
                   const VectorIn& y, const VectorIn& z, double sign) noexcept {
  second_fundamental_form(mechanism, workspace, y, z);
  set_x(mechanism, workspace, x);
  against_normal(mechanism, workspace,
                 [&](int l, double value) { workspace.curvature[l] += sign * value; });
}

}  // namespace

const Eigen::VectorXd* curvature_covector(const Mechanism& mechanism, Workspace& workspace,
                                          const VectorIn& q, const VectorIn& x, const VectorIn& y,
                                          const VectorIn& z) noexcept {
  assert(x.size() == mechanism.dof() && y.size() == x.size() && z.size() == x.size());
  if (!prepare(mechanism, workspace, q)) {
    return nullptr;
  }
  workspace.curvature.setZero();
  add_curvature(mechanism, workspace, x, y, z, 1.0);
  add_curvature(mechanism, workspace, y, x, z, -1.0);
  return &workspace.curvature;
}

double sectional_curvature(const Mechanism& mechanism, Workspace& workspace, const VectorIn& q,
                           const VectorIn& x, const VectorIn& y) noexcept {
  const Eigen::VectorXd* r = curvature_covector(mechanism, workspace, q, x, y, y);
  if (r == nullptr) {
    return std::numeric_limits<double>::quiet_NaN();
  }
  const double bend = r->dot(x);
  const auto product = [&](const VectorIn& a, const VectorIn& b) {
    double sum = 0.0;
    for (Eigen::Index j = 0; j < b.size(); ++j) {
      sum += b[j] * workspace.metric.col(j).dot(a);
    }
    return sum;
  };
  const double xx = product(x, x);
  const double yy = product(y, y);
  const double xy = product(x, y);
  const double area = xx * yy - xy * xy;
  // Below this, rounding has made the plane.
  constexpr double kParallel = 1e-14;
  return area > kParallel * xx * yy ? bend / area : std::numeric_limits<double>::quiet_NaN();
}

RiemannTensor::RiemannTensor(const Mechanism& mechanism)
    : size_(mechanism.dof()), entry_(Eigen::VectorXd::Zero(size_ * size_ * size_ * size_)) {}

bool riemann_tensor(const Mechanism& mechanism, Workspace& workspace, const VectorIn& q,
                    RiemannTensor& result) noexcept {
  const int n = mechanism.dof();
  assert(result.size_ == n);
  if (!prepare(mechanism, workspace, q)) {
    return false;
  }
  result.entry_.setZero();
  Eigen::VectorXd& a = workspace.generator;
  Eigen::VectorXd& b = workspace.unit_velocity;
  a.setZero();
  b.setZero();
  for (int j = 0; j < n; ++j) {
    for (int k = 0; k <= j; ++k) {
      a[j] = 1.0;
      b[k] = 1.0;
      second_fundamental_form(mechanism, workspace, a, b);
      a[j] = 0.0;
      b[k] = 0.0;
      for (int i = 0; i < n; ++i) {
        a[i] = 1.0;
        set_x(mechanism, workspace, a);
        a[i] = 0.0;
        // The product <II_jk, II_il> enters <R(E_i, E_j) E_k, E_l> with plus and
        // <R(E_j, E_i) E_k, E_l> with minus, and, as II is symmetric, the same with j and k
        // changed.
        against_normal(mechanism, workspace, [&](int l, double value) {
          result.entry_[result.index(l, k, i, j)] += value;
          result.entry_[result.index(l, k, j, i)] -= value;
          if (j != k) {
            result.entry_[result.index(l, j, i, k)] += value;
            result.entry_[result.index(l, j, k, i)] -= value;
          }
        });
      }
    }
  }
  return true;
}

}  // namespace geodesic::control
