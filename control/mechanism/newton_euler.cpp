// Implements newton_euler.hpp on compact bodies.
//
// A body's points accelerate by a + U r, with U = hat(alpha) + hat(omega)^2 (Wittenburg 1977). Of a
// body with mass m, first moment h and second moment S the wrench about its origin is then
//   force = m a + U h,    moment = h x a + sum of r x (U r) = h x a + skew part of 2 U S,
// and the same U carries the acceleration on to the children's origins.
#include "control/mechanism/newton_euler.hpp"

#include <cassert>

#include "control/mechanism/compact_dispatch.hpp"
#include "control/mechanism/compact_motion.hpp"

namespace geodesic::control {
namespace {

using Course = Workspace::Course;
using Load = Workspace::Load;

/// U = hat(alpha) + hat(omega)^2, by rows.
struct Spread {
  Spread() noexcept = default;
  explicit Spread(const Course& course) noexcept {
    const Triple& w = course.angular;
    const Triple& a = course.angular_rate;
    const double w_xy = w.x * w.y;
    const double w_xz = w.x * w.z;
    const double w_yz = w.y * w.z;
    const double w_xx = w.x * w.x;
    const double w_yy = w.y * w.y;
    const double w_zz = w.z * w.z;
    x = {-(w_yy + w_zz), w_xy - a.z, w_xz + a.y};
    y = {w_xy + a.z, -(w_xx + w_zz), w_yz - a.x};
    z = {w_xz - a.y, w_yz + a.x, -(w_xx + w_yy)};
  }
  Triple operator*(const Triple& r) const noexcept {
    return {x.x * r.x + x.y * r.y + x.z * r.z, y.x * r.x + y.y * r.y + y.z * r.z,
            z.x * r.x + z.y * r.y + z.z * r.z};
  }
  /// Of r = (r_x, r_y, 0).
  Triple in_plane(double r_x, double r_y) const noexcept {
    return {x.x * r_x + x.y * r_y, y.x * r_x + y.y * r_y, z.x * r_x + z.y * r_y};
  }
  Triple x, y, z;
};

/// Wrench that a light body's inertia needs.
inline Load light_load(const CompactBody& b, const Triple& a, const Spread& u) noexcept {
  return {
      {u.x.x * b.h_x + u.x.y * b.h_y, u.y.x * b.h_x + u.y.y * b.h_y, u.z.x * b.h_x + u.z.y * b.h_y},
      {u.z.x * b.s_xy + u.z.y * b.s_yy + (u.z.z - u.y.y) * b.s_yz - u.y.x * b.s_xz + b.h_y * a.z,
       u.x.y * b.s_yz + (u.x.x - u.z.z) * b.s_xz - u.z.x * b.s_xx - u.z.y * b.s_xy - b.h_x * a.z,
       u.y.x * b.s_xx + (u.y.y - u.x.x) * b.s_xy + u.y.z * b.s_xz - u.x.y * b.s_yy -
           u.x.z * b.s_yz + (b.h_x * a.y - b.h_y * a.x)}};
}

/// Wrench that any body's inertia needs.
inline Load load_of(const CompactBody& b, const Triple& a, const Spread& u) noexcept {
  Load load = light_load(b, a, u);
  if (!b.light) {
    load.force = load.force + b.mass * a + b.h_z * Triple{u.x.z, u.y.z, u.z.z};
    load.moment.x -= u.y.z * b.s_zz + b.h_z * a.y;
    load.moment.y += u.x.z * b.s_zz + b.h_z * a.x;
  }
  return load;
}

/// What a joint that turns freely adds to the motion its parent hands on, all along the body's
/// axes: its origin moves with `linear` in the parent, it turns with `angular` against it.
template <bool kAccelerated>
void add_free_joint(const CompactBody& body, const double* v, const double* a,
                    Course& course) noexcept {
  const int at = body.dof + angular_offset(body);
  const bool free = body.motion == Motion::kFree;
  const Triple angular = triple_at(v + at);
  const Triple carried = course.angular;
  course.angular = carried + angular;
  course.angular_rate = course.angular_rate + cross(carried, angular);
  if (free) {
    course.acceleration =
        course.acceleration + cross(carried + course.angular, triple_at(v + body.dof));
  }
  if constexpr (kAccelerated) {
    course.angular_rate = course.angular_rate + triple_at(a + at);
    if (free) {
      course.acceleration = course.acceleration + triple_at(a + body.dof);
    }
  }
}

/// What a turning joint adds to the motion its parent hands on: its rate and the rate of that.
template <bool kAccelerated>
inline void add_turn(const CompactBody& body, const double* v, const double* a,
                     Course& course) noexcept {
  const double speed = body.ratio * v[body.dof];
  course.angular_rate.x += speed * course.angular.y;
  course.angular_rate.y -= speed * course.angular.x;
  course.angular.z += speed;
  if constexpr (kAccelerated) {
    course.angular_rate.z += body.ratio * a[body.dof];
  }
}

/// What any joint about or along one axis adds: a sliding one the acceleration of the body's origin
/// (Coriolis and its own).
template <bool kAccelerated>
inline void add_joint(const CompactBody& body, const double* v, const double* a,
                      Course& course) noexcept {
  if (body.rotates) {
    add_turn<kAccelerated>(body, v, a, course);
  } else {
    const double speed = body.ratio * v[body.dof];
    course.acceleration.x += 2.0 * speed * course.angular.y;
    course.acceleration.y -= 2.0 * speed * course.angular.x;
    if constexpr (kAccelerated) {
      course.acceleration.z += body.ratio * a[body.dof];
    }
  }
}

/// Acceleration of the body's origin, along its parent's axes.
template <typename Rotation>
inline Triple at_origin(const CompactBody& body, const Rotation& rotation, const double* q,
                        const Triple& acceleration, const Spread& u) noexcept {
  if (body.reach == Reach::kInPlane) {
    return acceleration + u.in_plane(body.x, body.y);
  }
  return body.reach == Reach::kNone ? acceleration
                                    : acceleration + u * joint_translation(body, rotation, q);
}

/// A light body that turns in the world: only its moment about the axis is asked for.
template <bool kAccelerated>
inline void start(const CompactBody& body, double s, double c, const double* v, const double* a,
                  Course& course, Spread& u, Load& load) noexcept {
  const double speed = body.ratio * v[body.dof];
  const double rate = kAccelerated ? body.ratio * a[body.dof] : 0.0;
  course = {{0.0, 0.0, speed},
            {0.0, 0.0, rate},
            {c * body.up.x + s * body.up.y, c * body.up.y - s * body.up.x, body.up.z}};
  const double inwards = -(speed * speed);
  u.x = {inwards, -rate, 0.0};
  u.y = {rate, inwards, 0.0};
  u.z = {};
  load = {};
  load.moment.z = body.h_x * course.acceleration.y - body.h_y * course.acceleration.x;
  if constexpr (kAccelerated) {
    load.moment.z += rate * (body.s_xx + body.s_yy);
  }
}

/// One of the cases of Step.
template <bool kAccelerated, typename Rotation, typename Reaches>
[[gnu::always_inline]] inline void follow(const CompactBody& body, const Rotation& rotation,
                                          Reaches reaches, const double* v, const double* a,
                                          Course& course, Spread& u, Load& load) noexcept {
  Triple origin = course.acceleration;
  if constexpr (reaches()) {
    origin = origin + u.in_plane(body.x, body.y);
  }
  course = {rotation.to_body(course.angular), rotation.to_body(course.angular_rate),
            rotation.to_body(origin)};
  add_turn<kAccelerated>(body, v, a, course);
  u = Spread(course);
  load = light_load(body, course.acceleration, u);
}

/// Outwards: motion, and each body's own wrench. In a chain the motion goes from body to body
/// without a detour through memory.
template <bool kAccelerated>
[[gnu::always_inline]] inline void outwards(const CompactBody* bodies, std::size_t n,
                                            Workspace& workspace, const double* q, const double* v,
                                            const double* a) noexcept {
  const double* sine = workspace.sine.data();
  const double* cosine = workspace.cosine.data();
  Load* load = workspace.load.data();
  Course course;
  Spread u;
  for (std::size_t i = 0; i < n; ++i) {
    const CompactBody& body = bodies[i];
    if (with_step(body, sine[i], cosine[i], [&](const auto& rotation, auto reaches) {
          follow<kAccelerated>(body, rotation, reaches, v, a, course, u, load[i]);
        })) {
      continue;
    }
    if (body.at_base && body.rotates) {
      start<kAccelerated>(body, sine[i], cosine[i], v, a, course, u, load[i]);
    } else {
      if (body.at_base) {
        course = {{}, {}, body.up};
        u = Spread();
      } else if (!body.chained) {
        course = workspace.course[static_cast<std::size_t>(body.parent)];
        u = Spread(course);
      }
      with_rotation(body, sine[i], cosine[i], [&](const auto& rotation) {
        course = {rotation.to_body(course.angular), rotation.to_body(course.angular_rate),
                  rotation.to_body(at_origin(body, rotation, q, course.acceleration, u))};
      });
      if (body.many) {
        const Axes& axes = workspace.axes[i] = axes_at(q + body.coordinate + angular_offset(body));
        course = {from_joint(axes, course.angular), from_joint(axes, course.angular_rate),
                  from_joint(axes, course.acceleration)};
        add_free_joint<kAccelerated>(body, v, a, course);
      } else {
        add_joint<kAccelerated>(body, v, a, course);
      }
      u = Spread(course);
      load[i] = load_of(body, course.acceleration, u);
    }
    if (body.forks) {
      workspace.course[i] = course;
    }
  }
}

/// Inwards: what each joint carries.
[[gnu::always_inline]] inline void inwards(const CompactBody* bodies, std::size_t n,
                                           Workspace& workspace, const double* q,
                                           double* result) noexcept {
  const double* sine = workspace.sine.data();
  const double* cosine = workspace.cosine.data();
  Load* load = workspace.load.data();
  Load carried;
  for (std::size_t i = n; i-- > 0;) {
    const CompactBody& body = bodies[i];
    const Triple force = load[i].force + carried.force;
    const Triple moment = load[i].moment + carried.moment;
    if (with_step(body, sine[i], cosine[i], [&](const auto& rotation, auto reaches) {
          result[body.dof] += body.ratio * moment.z;
          carried = {rotation.to_parent(force), rotation.to_parent(moment)};
          if constexpr (reaches()) {
            add_moment_in_plane(body, carried.force, carried.moment);
          }
        })) {
      continue;
    }
    if (body.many) {
      put(moment, result + body.dof + angular_offset(body));
      if (body.motion == Motion::kFree) {
        put(force, result + body.dof);
      }
    } else {
      result[body.dof] += body.ratio * (body.rotates ? moment.z : force.z);
    }
    carried = {};
    if (body.at_base) {
      continue;
    }
    carried = {force, moment};
    if (body.many) {
      carried = {to_joint(workspace.axes[i], force), to_joint(workspace.axes[i], moment)};
    }
    with_rotation(body, sine[i], cosine[i], [&](const auto& rotation) {
      carried = {rotation.to_parent(carried.force), rotation.to_parent(carried.moment)};
      add_moment_of(body, rotation, q, carried.force, carried.moment);
    });
    if (!body.chained) {
      Load& parent = load[body.parent];
      parent = {parent.force + carried.force, parent.moment + carried.moment};
      carried = {};
    }
  }
}

/// Both, rotors left out.
template <bool kAccelerated>
void newton_euler(const Mechanism& mechanism, Workspace& workspace, const double* q,
                  const double* v, const double* a, Eigen::VectorXd& result) noexcept {
  const CompactTree& tree = mechanism.compact_tree();
  const CompactBody* bodies = tree.bodies.data();
  const std::size_t n = tree.bodies.size();
  result.setZero();
  double* out = result.data();
  run_with(workspace.registers, [&](auto lanes) noexcept {
    find_angles<lanes()>(tree, q, workspace);
    outwards<kAccelerated>(bodies, n, workspace, q, v, a);
    inwards(bodies, n, workspace, q, out);
  });
}

}  // namespace

const Eigen::VectorXd& bias(const Mechanism& mechanism, Workspace& workspace, const VectorIn& q,
                            const VectorIn& v) noexcept {
  assert(q.size() == mechanism.nq() && v.size() == mechanism.dof());
  newton_euler<false>(mechanism, workspace, q.data(), v.data(), nullptr, workspace.bias);
  return workspace.bias;
}

const Eigen::VectorXd& inverse_dynamics(const Mechanism& mechanism, Workspace& workspace,
                                        const VectorIn& q, const VectorIn& v,
                                        const VectorIn& a) noexcept {
  assert(q.size() == mechanism.nq() && v.size() == mechanism.dof() && a.size() == v.size());
  newton_euler<true>(mechanism, workspace, q.data(), v.data(), a.data(),
                     workspace.inverse_dynamics);
  workspace.inverse_dynamics += mechanism.rotor_inertia().cwiseProduct(a);
  return workspace.inverse_dynamics;
}

}  // namespace geodesic::control
