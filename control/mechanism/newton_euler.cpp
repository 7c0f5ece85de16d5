// Implements newton_euler.hpp on compact bodies.
//
// A body's points accelerate by a + U r, with U = hat(alpha) + hat(omega)^2 (Wittenburg 1977). Of a
// body with mass m, first moment h and second moment S the wrench about its origin is then
//   force = m a + U h,    moment = h x a + sum of r x (U r) = h x a + skew part of 2 U S,
// and the same U carries the acceleration on to the children's origins.
#include "control/mechanism/newton_euler.hpp"

#include <Eigen/Geometry>
#include <cassert>

#include "control/mechanism/compact_motion.hpp"

namespace geodesic::control {
namespace {

using State = Workspace::CompactState;

/// How a body moves: what its children need of it, and its own wrench.
struct Course {
  Triple angular;
  Triple angular_rate;
  Triple acceleration;
};

/// U = hat(alpha) + hat(omega)^2, by rows.
struct Spread {
  explicit Spread(const Course& course) noexcept {
    const Triple& w = course.angular;
    const Triple& a = course.angular_rate;
    const double w_xy = w.x * w.y;
    const double w_xz = w.x * w.z;
    const double w_yz = w.y * w.z;
    x = {-(w.y * w.y + w.z * w.z), w_xy - a.z, w_xz + a.y};
    y = {w_xy + a.z, -(w.x * w.x + w.z * w.z), w_yz - a.x};
    z = {w_xz - a.y, w_yz + a.x, -(w.x * w.x + w.y * w.y)};
  }
  Triple operator*(const Triple& r) const noexcept {
    return {x.x * r.x + x.y * r.y + x.z * r.z, y.x * r.x + y.y * r.y + y.z * r.z,
            z.x * r.x + z.y * r.y + z.z * r.z};
  }
  Triple x, y, z;
};

/// Wrench that the body's own inertia needs. The terms of a light body's zeros are left out.
inline void set_wrench(const CompactBody& body, const Course& course, const Spread& u,
                       State& state) noexcept {
  const auto& s = body.second_moment;
  const double s_xx = s(0, 0);
  const double s_xy = s(0, 1);
  const double s_xz = s(0, 2);
  const double s_yy = s(1, 1);
  const double s_yz = s(1, 2);
  const double h_x = body.first_moment.x();
  const double h_y = body.first_moment.y();
  const Triple& a = course.acceleration;
  Triple force{u.x.x * h_x + u.x.y * h_y, u.y.x * h_x + u.y.y * h_y, u.z.x * h_x + u.z.y * h_y};
  Triple moment{u.z.x * s_xy + u.z.y * s_yy + (u.z.z - u.y.y) * s_yz - u.y.x * s_xz + h_y * a.z,
                u.x.y * s_yz + (u.x.x - u.z.z) * s_xz - u.z.x * s_xx - u.z.y * s_xy - h_x * a.z,
                u.y.x * s_xx + (u.y.y - u.x.x) * s_xy + u.y.z * s_xz - u.x.y * s_yy - u.x.z * s_yz +
                    (h_x * a.y - h_y * a.x)};
  if (!body.light) {
    const double h_z = body.first_moment.z();
    const double s_zz = s(2, 2);
    force = force + body.mass * a + Triple{u.x.z * h_z, u.y.z * h_z, u.z.z * h_z};
    moment.x -= u.y.z * s_zz + h_z * a.y;
    moment.y += u.x.z * s_zz + h_z * a.x;
  }
  state.force = force;
  state.moment = moment;
}

/// The root of a floating mechanism: its twist and that twist's rate are the first six numbers.
Course base_course(const Mechanism& mechanism, const VectorIn& q, const VectorIn& v,
                   const double* a) noexcept {
  const Eigen::Quaterniond orientation(q[6], q[3], q[4], q[5]);
  const Eigen::Vector3d down = orientation.normalized().conjugate() * mechanism.gravity();
  Course course;
  course.angular = {v[3], v[4], v[5]};
  course.acceleration = -1.0 * triple(down) + cross(course.angular, {v[0], v[1], v[2]});
  if (a != nullptr) {
    course.acceleration = course.acceleration + Triple{a[0], a[1], a[2]};
    course.angular_rate = {a[3], a[4], a[5]};
  }
  return course;
}

/// What the joint adds to the motion its parent hands on: a turning one its rate and the rate of
/// that, a sliding one the acceleration of the body's origin (Coriolis and its own).
inline void add_joint(const CompactBody& body, double rate, double rate_rate,
                      Course& course) noexcept {
  const double speed = body.ratio * rate;
  if (body.rotates) {
    course.angular_rate.x += speed * course.angular.y;
    course.angular_rate.y -= speed * course.angular.x;
    course.angular_rate.z += body.ratio * rate_rate;
    course.angular.z += speed;
  } else {
    course.acceleration.x += 2.0 * speed * course.angular.y;
    course.acceleration.y -= 2.0 * speed * course.angular.x;
    course.acceleration.z += body.ratio * rate_rate;
  }
}

/// Outwards: motion, and each body's own wrench. The world accelerates upwards, which stands for
/// gravity. In a chain the motion goes from body to body without a detour through memory.
void outwards(const Mechanism& mechanism, Workspace& workspace, const VectorIn& q,
              const VectorIn& v, const double* a) noexcept {
  const auto& bodies = mechanism.compact_bodies();
  const Triple upwards = -1.0 * triple(mechanism.gravity());
  Course course;
  for (int i = 0; i < static_cast<int>(bodies.size()); ++i) {
    const auto at = static_cast<std::size_t>(i);
    const CompactBody& body = bodies[at];
    State& state = workspace.compact[at];
    if (body.free) {
      course = base_course(mechanism, q, v, a);
    } else {
      const JointRotation rotation(body, workspace.sine[at], workspace.cosine[at]);
      const Triple translation = joint_translation(body, q);
      state.translation = translation;
      if (body.parent == kWorld) {
        course = {{}, {}, rotation.to_body(upwards)};
      } else {
        if (body.parent != i - 1) {
          const State& parent = workspace.compact[static_cast<std::size_t>(body.parent)];
          course = {parent.angular, parent.angular_rate, parent.acceleration};
        }
        const Triple origin = course.acceleration + Spread(course) * translation;
        course = {rotation.to_body(course.angular), rotation.to_body(course.angular_rate),
                  rotation.to_body(origin)};
      }
      add_joint(body, v[body.dof], a != nullptr ? a[body.dof] : 0.0, course);
    }
    state.angular = course.angular;
    state.angular_rate = course.angular_rate;
    state.acceleration = course.acceleration;
    set_wrench(body, course, Spread(course), state);
  }
}

/// Inwards: what each joint carries.
void inwards(const Mechanism& mechanism, Workspace& workspace, Eigen::VectorXd& result) noexcept {
  const auto& bodies = mechanism.compact_bodies();
  result.setZero();
  Triple carried_force;
  Triple carried_moment;
  for (int i = static_cast<int>(bodies.size()) - 1; i >= 0; --i) {
    const auto at = static_cast<std::size_t>(i);
    const CompactBody& body = bodies[at];
    const State& state = workspace.compact[at];
    const Triple force = state.force + carried_force;
    const Triple moment = state.moment + carried_moment;
    carried_force = {};
    carried_moment = {};
    if (body.free) {
      result.head<6>() << force.x, force.y, force.z, moment.x, moment.y, moment.z;
      continue;
    }
    result[body.dof] += body.ratio * (body.rotates ? moment.z : force.z);
    if (body.parent == kWorld) {
      continue;
    }
    const JointRotation rotation(body, workspace.sine[at], workspace.cosine[at]);
    const Triple on_parent = rotation.to_parent(force);
    const Triple about_parent = rotation.to_parent(moment) + cross(state.translation, on_parent);
    if (body.parent == i - 1) {
      carried_force = on_parent;
      carried_moment = about_parent;
    } else {
      State& parent = workspace.compact[static_cast<std::size_t>(body.parent)];
      parent.force = parent.force + on_parent;
      parent.moment = parent.moment + about_parent;
    }
  }
}

/// Both; `a` null stands for no acceleration.
void newton_euler(const Mechanism& mechanism, Workspace& workspace, const VectorIn& q,
                  const VectorIn& v, const double* a, Eigen::VectorXd& result) noexcept {
  assert(q.size() == mechanism.nq() && v.size() == mechanism.dof());
  find_angles(mechanism, workspace, q);
  outwards(mechanism, workspace, q, v, a);
  inwards(mechanism, workspace, result);
}

}  // namespace

const Eigen::VectorXd& bias(const Mechanism& mechanism, Workspace& workspace, const VectorIn& q,
                            const VectorIn& v) noexcept {
  newton_euler(mechanism, workspace, q, v, nullptr, workspace.bias);
  return workspace.bias;
}

const Eigen::VectorXd& inverse_dynamics(const Mechanism& mechanism, Workspace& workspace,
                                        const VectorIn& q, const VectorIn& v,
                                        const VectorIn& a) noexcept {
  assert(a.size() == mechanism.dof());
  newton_euler(mechanism, workspace, q, v, a.data(), workspace.inverse_dynamics);
  workspace.inverse_dynamics += mechanism.rotor_inertia().cwiseProduct(a);
  return workspace.inverse_dynamics;
}

}  // namespace geodesic::control
