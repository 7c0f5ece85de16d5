// The mechanism's bodies once more, in the coordinates and with the inertias that make Newton-Euler
// cheapest. Same motion, same torques; only newton_euler.cpp and gravity.cpp look at it.
//
// Two freedoms are spent, both at load time:
//  - A body's frame may be turned about its own joint axis. Any rotation is Rz(a) Rx(b) Rz(c); c is
//    added to the joint's angle, and the parent's frame is turned by a, so that of the rotation to
//    a first child only the tilt Rx(b) is left: 4 multiplications a vector in place of 9.
//  - Mass on a joint's axis does not move in the parent when the joint turns. A turning body's
//    mass, the axial part of its first moment and that of its second moment are handed to its
//    parent; what is left of it is light (Khalil, Kleinfinger 1987, base parameters; Gautier 1991).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "control/geometry/sine_cosine.hpp"

namespace geodesic::control {

struct Body;

/// Three components that stay in registers: where a recursion waits for each result, a detour of
/// Eigen's types through memory costs as much as the arithmetic.
struct Triple {
  double x = 0.0;
  double y = 0.0;
  double z = 0.0;
};

struct CompactBody {
  int parent = -1;
  int dof = 0;          ///< index in v
  int coordinate = 0;   ///< index in q
  bool rotates = true;  ///< else it slides along z; body 0 of a floating mechanism is neither
  bool free = false;    ///< has six degrees of freedom
  bool turned = false;  ///< Rz(turn) comes before the tilt
  bool light = false;   ///< mass, first_moment.z and second_zz are zero
  bool pushes = true;   ///< it, or a body it carries, is not light: at rest it weighs on its parent
  double ratio = 1.0;   ///< of the joint to its degree of freedom
  double slide = 0.0;   ///< [m] at q = 0, where it slides
  double rate = 1.0;    ///< angle = rate * q + angle_0 [rad]; rate 0 where it does not turn
  double angle_0 = 0.0;  ///< [rad]
  SineCosine turn;
  SineCosine tilt;
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();   ///< of the joint in its parent [m]
  Eigen::Vector3d slides_along = Eigen::Vector3d::Zero();  ///< z axis in its parent

  double mass = 0.0;                                       ///< [kg]
  Eigen::Vector3d first_moment = Eigen::Vector3d::Zero();  ///< [kg·m]
  /// Sum of mass * position * position' [kg·m²]: half the trace of the rotational inertia, minus
  /// it.
  Eigen::Matrix3d second_moment = Eigen::Matrix3d::Zero();
};

/// One for each body, in their order. Not real-time.
std::vector<CompactBody> compact(const std::vector<Body>& bodies);

}  // namespace geodesic::control
