// How a compact body moves in its parent: angles, the joint's place, vectors between their frames.
// The inner steps of newton_euler.cpp, gravity.cpp and metric.cpp; the plain ones are in
// joint_motion.hpp.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstring>
#include <type_traits>

#include "control/mechanism/compact_dispatch.hpp"
#include "control/mechanism/compact_tree.hpp"
#include "control/mechanism/mechanism.hpp"
#include "control/mechanism/workspace.hpp"

namespace geodesic::control {

inline Triple operator+(const Triple& a, const Triple& b) noexcept {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}

inline Triple operator*(double s, const Triple& a) noexcept {
  return {s * a.x, s * a.y, s * a.z};
}

inline Triple cross(const Triple& a, const Triple& b) noexcept {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// Three numbers in a row.
inline Triple triple_at(const double* numbers) noexcept {
  return {numbers[0], numbers[1], numbers[2]};
}

inline void put(const Triple& from, double* numbers) noexcept {
  numbers[0] = from.x;
  numbers[1] = from.y;
  numbers[2] = from.z;
}

/// Angles of the joints from `i` on, as many as a vector holds. Built up in a register: a vector
/// that is read from where its numbers have just been written one by one has to wait for them.
[[gnu::always_inline]] inline void put_angles(const CompactTree& tree, std::size_t i,
                                              const double* q, double (&x)[2]) noexcept {
  using Vector = double __attribute__((vector_size(16)));
  const int* at = &tree.coordinate[i];
  const Vector position{q[at[0]], q[at[1]]};
  Vector rate;
  Vector angle_0;
  std::memcpy(&rate, &tree.rate[i], sizeof rate);
  std::memcpy(&angle_0, &tree.angle_0[i], sizeof angle_0);
  const Vector angle = rate * position + angle_0;
  std::memcpy(x, &angle, sizeof x);
}

#if defined(__x86_64__)
[[gnu::target("avx2")]] inline void put_angles(const CompactTree& tree, std::size_t i,
                                               const double* q, double (&x)[4]) noexcept {
  using Vector = double __attribute__((vector_size(32)));
  const int* at = &tree.coordinate[i];
  const Vector position{q[at[0]], q[at[1]], q[at[2]], q[at[3]]};
  Vector rate;
  Vector angle_0;
  std::memcpy(&rate, &tree.rate[i], sizeof rate);
  std::memcpy(&angle_0, &tree.angle_0[i], sizeof angle_0);
  const Vector angle = rate * position + angle_0;
  std::memcpy(x, &angle, sizeof x);
}

[[gnu::target(GEODESIC_AVX512)]] inline void put_angles(const CompactTree& tree, std::size_t i,
                                                        const double* q, double (&x)[8]) noexcept {
  using Vector = double __attribute__((vector_size(64)));
  const int* at = &tree.coordinate[i];
  const Vector position{q[at[0]], q[at[1]], q[at[2]], q[at[3]],
                        q[at[4]], q[at[5]], q[at[6]], q[at[7]]};
  Vector rate;
  Vector angle_0;
  std::memcpy(&rate, &tree.rate[i], sizeof rate);
  std::memcpy(&angle_0, &tree.angle_0[i], sizeof angle_0);
  const Vector angle = rate * position + angle_0;
  std::memcpy(x, &angle, sizeof x);
}
#endif

/// Sine and cosine of every joint's angle into the workspace, kLanes at a time. Real-time. What the
/// recursions read next is asked for meanwhile: in a loop that sleeps between cycles it has left
/// the caches, and waiting for one line after the other takes longest of all.
template <std::size_t kLanes>
[[gnu::always_inline]] inline void find_angles(const CompactTree& tree, const double* q,
                                               Workspace& workspace) noexcept {
  for (std::size_t i = 0; i < tree.bodies.size(); ++i) {
    const auto* lines = reinterpret_cast<const char*>(&tree.bodies[i]);
    __builtin_prefetch(lines);
    __builtin_prefetch(lines + 64);
    __builtin_prefetch(&workspace.load[i], 1);
  }
  for (std::size_t i = 0; i < tree.bodies.size(); i += kLanes) {
    double x[kLanes];
    put_angles(tree, i, q, x);
    sine_cosine(x, &workspace.sine[i], &workspace.cosine[i]);
  }
}

struct NoTilt {
  Triple to_parent(const Triple& v) const noexcept { return v; }
  Triple to_body(const Triple& v) const noexcept { return v; }
};

struct QuarterTilt {
  Triple to_parent(const Triple& v) const noexcept { return {v.x, -v.z, v.y}; }
  Triple to_body(const Triple& v) const noexcept { return {v.x, v.z, -v.y}; }
};

struct AnyTilt {
  Triple to_parent(const Triple& v) const noexcept {
    const auto& [s, c] = body.lean;
    const Triple tilted{v.x, c * v.y - s * v.z, s * v.y + c * v.z};
    return body.turned ? Triple{body.turn.cosine * tilted.x - body.turn.sine * tilted.y,
                                body.turn.sine * tilted.x + body.turn.cosine * tilted.y, tilted.z}
                       : tilted;
  }
  Triple to_body(Triple v) const noexcept {
    const auto& [s, c] = body.lean;
    if (body.turned) {
      v = {body.turn.cosine * v.x + body.turn.sine * v.y,
           body.turn.cosine * v.y - body.turn.sine * v.x, v.z};
    }
    return {v.x, c * v.y + s * v.z, c * v.z - s * v.y};
  }
  const CompactBody& body;
};

/// The tilt, then Rz(angle). Real-time, as all here.
template <typename TheTilt>
struct JointRotation {
  /// Components along the parent's axes of a vector given along the body's.
  Triple to_parent(const Triple& v) const noexcept {
    return tilt.to_parent({c * v.x - s * v.y, s * v.x + c * v.y, v.z});
  }
  /// Inverse of to_parent().
  Triple to_body(const Triple& v) const noexcept {
    const Triple u = tilt.to_body(v);
    return {c * u.x + s * u.y, c * u.y - s * u.x, u.z};
  }
  TheTilt tilt;
  double s;
  double c;
};

/// use(rotation) with the rotation of the body's own kind; `s` and `c` are those of its angle.
template <typename Use>
[[gnu::always_inline]] inline void with_rotation(const CompactBody& body, double s, double c,
                                                 const Use& use) noexcept {
  switch (body.tilt) {
    case Tilt::kQuarter:
      return use(JointRotation<QuarterTilt>{{}, s, c});
    case Tilt::kNone:
      return use(JointRotation<NoTilt>{{}, s, c});
    case Tilt::kAny:
      return use(JointRotation<AnyTilt>{{body}, s, c});
  }
}

/// use(rotation, reaches) for the cases of Step, `reaches` a std::bool_constant.
/// @return false for Step::kGeneral, where nothing is called
template <typename Use>
[[gnu::always_inline]] inline bool with_step(const CompactBody& body, double s, double c,
                                             const Use& use) noexcept {
  switch (body.step) {
    case Step::kGeneral:
      return false;
    case Step::kQuarter:
      use(JointRotation<QuarterTilt>{{}, s, c}, std::false_type{});
      return true;
    case Step::kQuarterReaching:
      use(JointRotation<QuarterTilt>{{}, s, c}, std::true_type{});
      return true;
    case Step::kParallelReaching:
      use(JointRotation<NoTilt>{{}, s, c}, std::true_type{});
      return true;
    case Step::kAny:
      use(JointRotation<AnyTilt>{{body}, s, c}, std::false_type{});
      return true;
    case Step::kAnyReaching:
      use(JointRotation<AnyTilt>{{body}, s, c}, std::true_type{});
      return true;
  }
  return false;
}

/// Axes of a body with more than one degree of freedom in its joint's, from the quaternion
/// x y z w at `q`, which is normalised here.
inline Axes axes_at(const double* q) noexcept {
  const double scale = 1.0 / std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  const double x = scale * q[0];
  const double y = scale * q[1];
  const double z = scale * q[2];
  const double w = scale * q[3];
  return {{1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)},
          {2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)},
          {2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)}};
}

inline Triple to_joint(const Axes& axes, const Triple& v) noexcept {
  const auto dot = [&v](const Triple& row) { return row.x * v.x + row.y * v.y + row.z * v.z; };
  return {dot(axes.x), dot(axes.y), dot(axes.z)};
}

inline Triple from_joint(const Axes& axes, const Triple& v) noexcept {
  return v.x * axes.x + v.y * axes.y + v.z * axes.z;
}

/// Index in q of the quaternion, and in v of the angular velocity, of a body with more than one
/// degree of freedom, counted from its first.
inline int angular_offset(const CompactBody& body) noexcept {
  return body.motion == Motion::kFree ? 3 : 0;
}

/// Where the body's origin is in its parent [m].
/// @param rotation  of the body's joint; of a free body, of the joint it is free against
template <typename Rotation>
inline Triple joint_translation(const CompactBody& body, const Rotation& rotation,
                                const double* q) noexcept {
  const Triple fixed{body.x, body.y, body.z};
  if (body.motion == Motion::kTranslation) {
    return fixed + (body.slide + body.ratio * q[body.coordinate]) * body.slides_along;
  }
  return body.motion == Motion::kFree ? fixed + rotation.to_parent(triple_at(q + body.coordinate))
                                      : fixed;
}

/// Adds p x force, p being where the body's origin is in its parent, at z = 0.
inline void add_moment_in_plane(const CompactBody& body, const Triple& force,
                                Triple& moment) noexcept {
  moment.x += body.y * force.z;
  moment.y -= body.x * force.z;
  moment.z += body.x * force.y - body.y * force.x;
}

/// The same wherever it is.
template <typename Rotation>
inline void add_moment_of(const CompactBody& body, const Rotation& rotation, const double* q,
                          const Triple& force, Triple& moment) noexcept {
  if (body.reach == Reach::kInPlane) {
    add_moment_in_plane(body, force, moment);
  } else if (body.reach == Reach::kAny) {
    moment = moment + cross(joint_translation(body, rotation, q), force);
  }
}

}  // namespace geodesic::control
