// Rigid motions of space: Pose (an element of SE(3)) and Twist (an element of its Lie algebra),
// how a pose carries twists between frames, exp, log and their Jacobians. Wrenches and inertias are
// in spatial.hpp.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "control/geometry/lie_group.hpp"
#include "control/geometry/series.hpp"
#include "control/geometry/so3.hpp"

namespace geodesic::control {

/// a_from_b: x_a = rotation * x_b + translation. Names say both frames: world_from_tool.
struct Pose {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();  ///< [m]
};

/// a_from_c = a_from_b * b_from_c.
inline Pose operator*(const Pose& a_from_b, const Pose& b_from_c) noexcept {
  return {a_from_b.rotation * b_from_c.rotation,
          a_from_b.rotation * b_from_c.translation + a_from_b.translation};
}

inline Pose inverse(const Pose& pose) noexcept {
  return {pose.rotation.transpose(), -(pose.rotation.transpose() * pose.translation)};
}

/// Velocity of a rigid body in the coordinates of a frame: `linear` is the velocity of the point
/// of the body that is at the frame's origin. Where six numbers stand in a vector, the linear ones
/// come first.
struct Twist {
  Eigen::Vector3d linear = Eigen::Vector3d::Zero();   ///< [m/s]
  Eigen::Vector3d angular = Eigen::Vector3d::Zero();  ///< [rad/s]
};

inline Twist operator+(const Twist& a, const Twist& b) noexcept {
  return {a.linear + b.linear, a.angular + b.angular};
}

inline Twist operator*(double s, const Twist& a) noexcept {
  return {s * a.linear, s * a.angular};
}

/// The same motion in the child's coordinates (Pluecker transform of motion vectors; Featherstone
/// 2008, table 2.1).
inline Twist to_child(const Pose& parent_from_child, const Twist& in_parent) noexcept {
  const auto& r = parent_from_child.rotation;
  return {
      r.transpose() * (in_parent.linear + in_parent.angular.cross(parent_from_child.translation)),
      r.transpose() * in_parent.angular};
}

/// The same motion in the parent's coordinates: Ad(parent_from_child) applied. Inverse of
/// to_child(). Real-time.
inline Twist to_parent(const Pose& parent_from_child, const Twist& in_child) noexcept {
  const Eigen::Vector3d angular = parent_from_child.rotation * in_child.angular;
  return {
      parent_from_child.rotation * in_child.linear + parent_from_child.translation.cross(angular),
      angular};
}

/// The Lie bracket [a, b] = a x b: the rate of b, fixed in a frame that moves with a, seen from a
/// frame at rest (Featherstone 2008, equation 2.31).
inline Twist cross(const Twist& a, const Twist& b) noexcept {
  return {a.angular.cross(b.linear) + a.linear.cross(b.angular), a.angular.cross(b.angular)};
}

/// The motion reached by following the constant local twist for one second. Real-time.
/// Source: Murray, Li, Sastry 1994, proposition 2.9.
inline Pose exp(const Twist& twist) noexcept {
  const double angle = twist.angular.norm();
  const Eigen::Vector3d once = twist.angular.cross(twist.linear);
  const Eigen::Vector3d twice = twist.angular.cross(once);
  return {exp(twist.angular),
          twist.linear + versine_second(angle) * once + versine_third(angle) * twice};
}

/// The twist, its angle at most pi, that exp() maps to the pose: the screw that leads there in one
/// second. Real-time. Source: Murray, Li, Sastry 1994, proposition 2.9, inverted.
inline Twist log(const Pose& pose) noexcept {
  const Eigen::Vector3d angular = log(pose.rotation);
  const Eigen::Vector3d once = angular.cross(pose.translation);
  return {pose.translation - 0.5 * once + cotangent_second(angular.norm()) * angular.cross(once),
          angular};
}

using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// Ad: the child's twists in the parent's coordinates, [R, hat(p) R; 0, R]. Real-time.
inline Matrix6d Ad(const Pose& parent_from_child) noexcept {
  const Eigen::Matrix3d& r = parent_from_child.rotation;
  Matrix6d m = Matrix6d::Zero();
  m.topLeftCorner<3, 3>() = r;
  m.topRightCorner<3, 3>() = hat(parent_from_child.translation) * r;
  m.bottomRightCorner<3, 3>() = r;
  return m;
}

/// ad: the bracket cross(twist, .) as a matrix. Real-time.
inline Matrix6d ad(const Twist& twist) noexcept {
  Matrix6d m = Matrix6d::Zero();
  m.topLeftCorner<3, 3>() = hat(twist.angular);
  m.topRightCorner<3, 3>() = hat(twist.linear);
  m.bottomRightCorner<3, 3>() = m.topLeftCorner<3, 3>();
  return m;
}

namespace se3_detail {
/// The corner of the left Jacobian where linear meets angular.
/// Source: Barfoot 2017, equation 7.86b.
inline Eigen::Matrix3d shear(const Twist& twist) noexcept {
  const double angle = twist.angular.norm();
  const Eigen::Matrix3d p = hat(twist.linear);
  const Eigen::Matrix3d w = hat(twist.angular);
  const Eigen::Matrix3d wp = w * p;
  const Eigen::Matrix3d pw = p * w;
  const Eigen::Matrix3d wpw = wp * w;
  return 0.5 * p + versine_third(angle) * (wp + pw + wpw) +
         versine_fourth(angle) * (w * wp + pw * w - 3.0 * wpw) +
         versine_fifth(angle) * (wpw * w + w * wpw);
}
}  // namespace se3_detail

/// J_l: exp(twist + d) = exp(J_l d) exp(twist) to first order; linear rows and columns first.
/// Real-time. Source: Barfoot 2017, equation 7.85b.
inline Matrix6d left_jacobian(const Twist& twist) noexcept {
  Matrix6d m = Matrix6d::Zero();
  m.topLeftCorner<3, 3>() = left_jacobian(twist.angular);
  m.topRightCorner<3, 3>() = se3_detail::shear(twist);
  m.bottomRightCorner<3, 3>() = m.topLeftCorner<3, 3>();
  return m;
}

/// Inverse of J_l, |angular| < 2 pi. Real-time. Source: Barfoot 2017, equation 7.95b.
inline Matrix6d left_jacobian_inverse(const Twist& twist) noexcept {
  const Eigen::Matrix3d back = left_jacobian_inverse(twist.angular);
  Matrix6d m = Matrix6d::Zero();
  m.topLeftCorner<3, 3>() = back;
  m.topRightCorner<3, 3>().noalias() = -back * se3_detail::shear(twist) * back;
  m.bottomRightCorner<3, 3>() = back;
  return m;
}

/// J_r: exp(twist + d) = exp(twist) exp(J_r d) to first order; J_l(-twist). Real-time.
inline Matrix6d right_jacobian(const Twist& twist) noexcept {
  return left_jacobian(-1.0 * twist);
}

/// Inverse of J_r, |angular| < 2 pi: the rate of log(pose) for a body's twist in its own axes.
/// Real-time.
inline Matrix6d right_jacobian_inverse(const Twist& twist) noexcept {
  return left_jacobian_inverse(-1.0 * twist);
}

/// As matrices: 4 x 4, [R p; 0 1]. A tangent is a Twist as six numbers, linear first.
struct SE3 {
  static constexpr int kDimension = 6;
  using Element = Pose;
  using Tangent = Eigen::Matrix<double, 6, 1>;  ///< [m, rad], or the same per second
  using Jacobian = Matrix6d;
  using Algebra = Eigen::Matrix4d;

  static Twist twist(const Tangent& x) noexcept { return {x.head<3>(), x.tail<3>()}; }
  static Tangent numbers(const Twist& twist) noexcept {
    Tangent x;
    x << twist.linear, twist.angular;
    return x;
  }

  static Element identity() noexcept { return {}; }
  static Element compose(const Element& a, const Element& b) noexcept { return a * b; }
  static Element inverse(const Element& g) noexcept { return control::inverse(g); }
  static Element exp(const Tangent& x) noexcept { return control::exp(twist(x)); }
  static Tangent log(const Element& g) noexcept { return numbers(control::log(g)); }
  static Algebra hat(const Tangent& x) noexcept {
    Algebra m = Algebra::Zero();
    m.topLeftCorner<3, 3>() = control::hat(Eigen::Vector3d(x.tail<3>()));
    m.topRightCorner<3, 1>() = x.head<3>();
    return m;
  }
  static Tangent vee(const Algebra& m) noexcept {
    return numbers({m.topRightCorner<3, 1>(), control::vee(m.topLeftCorner<3, 3>())});
  }
  static Algebra matrix(const Element& g) noexcept {
    Algebra m = Algebra::Identity();
    m.topLeftCorner<3, 3>() = g.rotation;
    m.topRightCorner<3, 1>() = g.translation;
    return m;
  }
  static Jacobian Ad(const Element& g) noexcept { return control::Ad(g); }
  static Jacobian ad(const Tangent& x) noexcept { return control::ad(twist(x)); }
  static Jacobian left_jacobian(const Tangent& x) noexcept {
    return control::left_jacobian(twist(x));
  }
  static Jacobian left_jacobian_inverse(const Tangent& x) noexcept {
    return control::left_jacobian_inverse(twist(x));
  }
  /// Of the left-invariant product metric, whose geodesics are straight lines and constant
  /// rotations (Park 1995, "Distance metrics on the rigid-body motions"); SE(3) has no metric that
  /// is invariant on both sides.
  static double distance(const Element& a, const Element& b, double metres_per_radian) noexcept {
    const Eigen::Matrix3d turn = a.rotation.transpose() * b.rotation;
    return std::hypot((b.translation - a.translation).norm(),
                      metres_per_radian * control::log(turn).norm());
  }
  template <std::uniform_random_bit_generator Engine>
  static Element random(Engine& engine) {
    const Eigen::Matrix3d rotation = random_rotation(engine).toRotationMatrix();
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    Element g{rotation, {}};
    for (int i = 0; i < 3; ++i) {
      g.translation[i] = uniform(engine);
    }
    return g;
  }
};

static_assert(LieGroup<SE3>);

}  // namespace geodesic::control
