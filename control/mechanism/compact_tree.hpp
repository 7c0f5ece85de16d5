// The mechanism's bodies once more, in the coordinates and with the inertias that make the
// recursions cheapest. Same motion, same torques; only newton_euler.cpp, gravity.cpp and metric.cpp
// look at it.
//
// Four freedoms are spent, all at load time:
//  - A body's frame may be turned about its own joint axis. Any rotation is Rz(a) Rx(b) Rz(c); c is
//    added to the joint's angle, and the parent's frame is turned by a, so that of the rotation to
//    a first child only the tilt Rx(b) is left; a right angle, as most arms have, costs nothing.
//  - Its origin may slide along its own joint axis, to where a first child's joint comes to lie in
//    the plane z = 0; where axes meet, the origins coincide (Denavit, Hartenberg 1955).
//  - Mass on a joint's axis does not move in the parent when the joint turns. A turning body's
//    mass, the axial part of its first moment and that of its second moment are handed to its
//    parent; what is left of it is light (Khalil, Kleinfinger 1987, base parameters; Gautier 1991).
//  - What hangs on the world starts at rest in a frame that may be turned at will: gravity is given
//    in the joint's own axes.
// Only what is zero to kNegligible is taken for zero: 1.57079632679 is no right angle.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "control/geometry/sine_cosine.hpp"

namespace geodesic::control {

struct Body;
enum class Motion : unsigned char;

/// Sines, cosines and lengths [m] below it are rounding errors of zero.
inline constexpr double kNegligible = 1e-14;

/// Three components that stay in registers: where a recursion waits for each result, a detour of
/// Eigen's types through memory costs as much as the arithmetic.
struct Triple {
  double x = 0.0;
  double y = 0.0;
  double z = 0.0;
};

/// Axes of one frame in another: rows of the rotation matrix.
struct Axes {
  Triple x;
  Triple y;
  Triple z;
};

/// What comes before Rz(angle) in the rotation from the parent's axes to the body's.
enum class Tilt : unsigned char {
  kNone,
  kQuarter,  ///< Rx(90 degrees)
  kAny,      ///< Rz(turn) Rx(tilt)
};

/// Where the joint lies in its parent.
enum class Reach : unsigned char {
  kNone,     ///< at the origin
  kInPlane,  ///< at z = 0
  kAny,      ///< anywhere, or it moves
};

/// The cases for which the recursions are spelt out, without a branch inside: a light body that
/// turns about one axis and hangs on the body just before it, with or without a reach in the plane.
enum class Step : unsigned char {
  kGeneral,  ///< none of these
  kQuarter,
  kQuarterReaching,
  kParallelReaching,  ///< Tilt::kNone
  kAny,
  kAnyReaching,
};

/// The first two cache lines serve a light turning body whose parent came just before it.
struct alignas(64) CompactBody {
  double ratio = 1.0;  ///< of the joint to its degree of freedom
  double h_x = 0.0;    ///< first moment [kg·m]
  double h_y = 0.0;
  double x = 0.0;  ///< of the joint in its parent [m]
  double y = 0.0;
  SineCosine lean;  ///< of Tilt::kAny
  short parent = -1;
  short dof = 0;         ///< index in v, of the first
  short coordinate = 0;  ///< index in q, of the first
  Step step = Step::kGeneral;
  Tilt tilt = Tilt::kNone;

  /// Sum of mass * position * position' [kg·m²]: half the trace of the rotational inertia, minus
  /// it.
  double s_xx = 0.0;
  double s_xy = 0.0;
  double s_xz = 0.0;
  double s_yy = 0.0;
  double s_yz = 0.0;
  Reach reach = Reach::kNone;
  Motion motion{};
  bool light = false;    ///< mass, h_z and s_zz are zero
  bool rotates = true;   ///< about z
  bool many = false;     ///< has three degrees of freedom, or six
  bool at_base = false;  ///< hangs on the world
  bool chained = false;  ///< its parent is the body before it
  bool forks = false;    ///< it has a child that is not chained

  bool pushes = true;   ///< it, or a body it carries, is not light
  bool turned = false;  ///< `turn` is not zero
  double z = 0.0;       ///< of the joint in its parent [m]
  double mass = 0.0;    ///< [kg]
  double h_z = 0.0;
  double s_zz = 0.0;
  SineCosine turn;     ///< of Tilt::kAny
  double slide = 0.0;  ///< [m] at q = 0, where it slides

  Triple slides_along;  ///< z axis in its parent
  Triple up;            ///< minus gravity at angle 0, where it hangs on the world [m/s²]
};

struct CompactTree {
  std::vector<CompactBody> bodies;  ///< one for each body, in their order
  /// Of each: angle = rate * q[coordinate] + angle_0 [rad]; rate 0 where it does not turn. Zeros
  /// behind, for a vector's length.
  std::vector<int> coordinate;
  std::vector<double> rate;
  std::vector<double> angle_0;
};

/// Not real-time.
/// @param gravity  [m/s²], world frame
CompactTree compact(const std::vector<Body>& bodies, const Eigen::Vector3d& gravity);

}  // namespace geodesic::control
