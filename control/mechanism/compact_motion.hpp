// How a compact body moves in its parent: angles, the joint's place, vectors between their frames.
// The inner steps of newton_euler.cpp and gravity.cpp; the plain ones are in joint_motion.hpp.
#pragma once

#include <Eigen/Core>

#include "control/mechanism/compact_tree.hpp"
#include "control/mechanism/mechanism.hpp"
#include "control/mechanism/workspace.hpp"

namespace geodesic::control {

/// Sine and cosine of every joint's angle into the workspace. Real-time.
inline void find_angles(const Mechanism& mechanism, Workspace& workspace,
                        const VectorIn& q) noexcept {
  const auto& bodies = mechanism.compact_bodies();
  const std::size_t n = bodies.size();
  for (std::size_t i = 0; i < n; ++i) {
    workspace.angle[i] = bodies[i].rate * q[bodies[i].coordinate] + bodies[i].angle_0;
  }
  sine_cosine(workspace.angle.data(), n, workspace.sine.data(), workspace.cosine.data());
}

inline Triple triple(const Eigen::Vector3d& v) noexcept {
  return {v.x(), v.y(), v.z()};
}

inline Triple operator+(const Triple& a, const Triple& b) noexcept {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}

inline Triple operator*(double s, const Triple& a) noexcept {
  return {s * a.x, s * a.y, s * a.z};
}

inline Triple cross(const Triple& a, const Triple& b) noexcept {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// Where the body's origin is in its parent [m]. Real-time.
inline Triple joint_translation(const CompactBody& body, const VectorIn& q) noexcept {
  const Triple fixed = triple(body.translation);
  if (body.rotates) {
    return fixed;
  }
  return fixed + (body.slide + body.ratio * q[body.coordinate]) * triple(body.slides_along);
}

/// Rx(tilt) Rz(angle), and Rz(turn) before it where there is one. The products are made before the
/// vectors are known, so that a vector waits for one multiplication and two additions only.
class JointRotation {
 public:
  JointRotation(const CompactBody& body, double sine, double cosine) noexcept
      : body_(body),
        s_(sine),
        c_(cosine),
        tilt_c_s_(body.tilt.cosine * sine),
        tilt_c_c_(body.tilt.cosine * cosine),
        tilt_s_s_(body.tilt.sine * sine),
        tilt_s_c_(body.tilt.sine * cosine) {}

  /// Components along the parent's axes of a vector given along the body's. Real-time.
  Triple to_parent(const Triple& v) const noexcept {
    const Triple tilted{c_ * v.x - s_ * v.y,
                        tilt_c_s_ * v.x + tilt_c_c_ * v.y - body_.tilt.sine * v.z,
                        tilt_s_s_ * v.x + tilt_s_c_ * v.y + body_.tilt.cosine * v.z};
    if (!body_.turned) {
      return tilted;
    }
    return {body_.turn.cosine * tilted.x - body_.turn.sine * tilted.y,
            body_.turn.sine * tilted.x + body_.turn.cosine * tilted.y, tilted.z};
  }

  /// Inverse of to_parent(). Real-time.
  Triple to_body(Triple v) const noexcept {
    if (body_.turned) {
      v = {body_.turn.cosine * v.x + body_.turn.sine * v.y,
           body_.turn.cosine * v.y - body_.turn.sine * v.x, v.z};
    }
    return {c_ * v.x + tilt_c_s_ * v.y + tilt_s_s_ * v.z,
            tilt_c_c_ * v.y - s_ * v.x + tilt_s_c_ * v.z,
            body_.tilt.cosine * v.z - body_.tilt.sine * v.y};
  }

 private:
  const CompactBody& body_;
  double s_;
  double c_;
  double tilt_c_s_;
  double tilt_c_c_;
  double tilt_s_s_;
  double tilt_s_c_;
};

}  // namespace geodesic::control
