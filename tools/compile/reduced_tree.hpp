// A mechanism in the frames that give the fewest operations: joint axes along z, origins slid along
// them, turning links without mass. What is computed with it is in recursions.hpp.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "control/mechanism/mechanism.hpp"
#include "tools/compile/graph.hpp"

namespace geodesic::tools::compile {

/// Where frames are free: what to spend the freedom of one body on. A search tries them
/// (compose.hpp).
struct Choice {
  /// The origin may slide along the joint's axis; what it takes to zero.
  enum class Slide : std::uint8_t {
    kOwn,     ///< the part of its own translation along the axis
    kChild,   ///< the part of its first child's translation along the axis
    kMoment,  ///< second moment xz
    kOther,   ///< second moment yz
  } slide = Slide::kOwn;
  /// The frame of a body at the end of the tree may turn about the axis; what it takes to zero.
  enum class Turn : std::uint8_t { kNone, kFirstMoment, kSecondMoment } turn = Turn::kFirstMoment;
  bool sums = true;     ///< behind a parallel axis: from the sum of both angles, not one by one
  int moment_form = 0;  ///< bit k: component k of the moment by products and rates (recursions.cpp)
  int tree_form = 0;    ///< of a composite's turn: directly, or by the double angle
  bool operator==(const Choice&) const = default;
};

/// One moving body.
struct ReducedBody {
  int parent = control::kWorld;
  control::Motion motion = control::Motion::kRotation;
  int dof = 0;         ///< (first) index in v
  int coordinate = 0;  ///< (first) index in q
  double rate = 1.0;   ///< of the joint to its degree of freedom
  std::string label;   ///< "3" for the third joint; mimic joints "3b", ...

  // kRotation: parent_from_body = translation * Rz(turn) Rx(tilt) Rz(angle).
  bool turned = false;
  bool parallel = false;  ///< neither turn nor tilt
  double turn_cosine = 1.0;
  double turn_sine = 0.0;
  double tilt_cosine = 1.0;
  double tilt_sine = 0.0;
  JointAngle angle;

  // kTranslation: no rotation, translation + (rate * q + slide) * axis.
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();
  double slide = 0.0;

  Eigen::Vector3d translation = Eigen::Vector3d::Zero();

  double mass = 0.0;
  Eigen::Vector3d first_moment = Eigen::Vector3d::Zero();
  Eigen::Matrix3d second_moment = Eigen::Matrix3d::Zero();
  Choice choice;
};

struct ReducedTree {
  std::vector<ReducedBody> bodies;  ///< parents before children
  std::vector<std::string> joint_names;
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();
  Eigen::VectorXd rotor_inertia;
  int nq = 0;
  int nv = 0;
  bool floating = false;
};

/// How near a rotation must be to a multiple of 90 degrees, or a length to zero [m], to be taken
/// for it. The largest first: what does not agree afterwards is tried again with the next.
inline constexpr double kSnaps[] = {1e-10, 1e-14, 0.0};

/// Why there is no compiled form of this mechanism; empty: there is one.
std::string uncompilable(const control::Mechanism& mechanism);

/// @param choices  one for each body, or none
/// Mass on a joint's axis is handed to the parent (Khalil, Kleinfinger 1987; Gautier 1991), the
/// second moments of a sliding body too.
ReducedTree reduce(const control::Mechanism& mechanism, const std::vector<Choice>& choices,
                   double snap);

}  // namespace geodesic::tools::compile
