// A tree of rigid bodies ready for computation: checked, ordered, fixed links merged, all constants
// precomputed. Immutable; what changes in a cycle lives in Workspace, what is computed in the
// headers that dynamics.hpp lists.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "control/geometry/spatial.hpp"
#include "control/mechanism/compact_tree.hpp"
#include "control/mechanism/tree.hpp"

namespace geodesic::control {

/// Most independent joints a mechanism may have, each of any kind. (The controller's own limit, for
/// joints with drives, is kMaxJoints.)
inline constexpr int kMaxMechanismJoints = 64;
/// Most moving joints, mimic joints included.
inline constexpr int kMaxMovingJoints = 128;

enum class Base {
  kFixed,     ///< the root link is the world
  kFloating,  ///< the root link moves freely: q and v begin with its pose and its twist
};

struct MechanismOptions {
  Base base = Base::kFixed;
  /// Inertia of the motors' rotors reflected to the joints, in the order of joint_names()
  /// [kg·m² or kg]; adds to the diagonal of the metric. Empty: none. Only a joint with one degree
  /// of freedom can have a rotor.
  Eigen::VectorXd rotor_inertia;
};

/// One factor of the configuration space Q, a product of Lie groups: the position of one joint (or
/// of a floating base), and where its numbers stand in q and v.
///
///   kind                   group         q                                v
///   revolute, continuous   S1            angle                            dq/dt
///   prismatic              R             distance                         dq/dt
///   planar                 R2 x SO(2)    x, y, angle                      dq/dt
///   spherical              SO(3)         quaternion x y z w               angular, child's axes
///   floating               SE(3)         position (3), quaternion (4)     twist, child's own axes
///
/// A planar joint's x and y are along the first two columns of in_plane(axis), fixed in the parent.
struct Factor {
  std::string name;  ///< of the joint; kBaseName for a floating base
  JointKind kind = JointKind::kRevolute;
  int q = 0;   ///< index in q of its first number
  int nq = 1;  ///< how many there are
  int v = 0;   ///< index in v of its first number
  int nv = 1;  ///< how many there are
};

/// The name of a floating base among the factors.
inline constexpr const char* kBaseName = "root_joint";

/// Axes (columns) of a plane with the given unit normal: the third is the normal; a permutation
/// with signs where the normal is a coordinate axis, so that zeros stay zeros; the identity where
/// it is z.
Eigen::Matrix3d in_plane(const Eigen::Vector3d& normal) noexcept;

/// Limits of one independent joint as the description gives them. [rad, N·m] or [m, N].
struct JointLimits {
  double lower = -std::numeric_limits<double>::infinity();
  double upper = std::numeric_limits<double>::infinity();
  double effort = std::numeric_limits<double>::infinity();
  double velocity = std::numeric_limits<double>::infinity();
};

/// How a body moves in its parent.
enum class Motion : unsigned char {
  kRotation,     ///< about the z axis of its own frame
  kTranslation,  ///< along the z axis of its own frame
  kSpherical,    ///< about the origin of its own frame: three degrees of freedom
  kFree,         ///< six degrees of freedom
};

/// Degrees of freedom of one body.
constexpr int freedoms(Motion motion) noexcept {
  return motion == Motion::kFree ? 6 : motion == Motion::kSpherical ? 3 : 1;
}

inline constexpr int kWorld = -1;

/// One moving body: a link and all that is fixed to it. Its frame is the joint's frame, turned such
/// that z is the joint axis where there is one axis. A planar joint is three bodies, the first two
/// without mass: along x, along y, about the normal.
struct Body {
  int parent = kWorld;  ///< index of the body it moves in; less than its own
  Motion motion = Motion::kRotation;
  int dof = 0;             ///< index in v of its (first) degree of freedom
  int coordinate = 0;      ///< index in q of its (first) number
  double ratio = 1.0;      ///< joint position = ratio * q + offset; 1 unless mimic
  double offset = 0.0;     ///< [rad or m]
  Pose parent_from_joint;  ///< at joint position 0
  RigidInertia inertia;    ///< in the body's own frame
};

/// A link as a frame to ask about: rigid in `body` (or in the world).
struct LinkFrame {
  std::string name;
  int body = kWorld;
  Pose body_from_link;
};

/// Conventions. q and v are the numbers of one factor after the other (see Factor): a floating
/// base's first, then the joints', depth first, siblings by joint name. SI units.
class Mechanism {
 public:
  /// @param gravity  [m/s²], world frame, e.g. (0, 0, -9.81)
  /// @throws std::invalid_argument naming the link or joint, if the description is no tree of rigid
  ///   bodies or exceeds the capacities above. Not real-time.
  Mechanism(const TreeDescription& tree, const Eigen::Vector3d& gravity,
            const MechanismOptions& options = {});

  const std::string& name() const noexcept { return name_; }
  /// Size of v.
  int dof() const noexcept { return dof_; }
  /// Size of q.
  int nq() const noexcept { return nq_; }
  bool floating() const noexcept { return base_ == Base::kFloating; }
  /// Index in v of the first joint: 0, or 6 behind a floating base.
  int first_joint_v() const noexcept { return floating() ? 6 : 0; }
  /// Index in q of the first joint: 0, or 7 behind a floating base.
  int first_joint_q() const noexcept { return floating() ? 7 : 0; }

  /// What Q is made of, in the order of q and v: the base if it floats, then every independent
  /// joint.
  const std::vector<Factor>& factors() const noexcept { return factors_; }
  /// Whether every joint has one degree of freedom and the base is fixed, so that Q has one chart,
  /// v = dq/dt, and joint i is q[i] and v[i].
  bool one_chart() const noexcept {
    return nq_ == dof_ && factors_.size() == joint_names_.size() &&
           static_cast<std::size_t>(dof_) == joint_names_.size();
  }

  /// Independent joints. Where each has one degree of freedom, number i is v[first_joint_v() + i];
  /// else see factors().
  const std::vector<std::string>& joint_names() const noexcept { return joint_names_; }
  const std::vector<JointKind>& joint_kinds() const noexcept { return joint_kinds_; }
  const std::vector<JointLimits>& joint_limits() const noexcept { return joint_limits_; }

  const Eigen::Vector3d& gravity() const noexcept { return gravity_; }
  /// Mass of everything that is not fixed to the world [kg].
  double moving_mass() const noexcept { return moving_mass_; }
  /// Size of v; zero for the floating base and where a joint has more than one degree of freedom.
  const Eigen::VectorXd& rotor_inertia() const noexcept { return rotor_inertia_; }

  /// Parents before children.
  const std::vector<Body>& bodies() const noexcept { return bodies_; }
  /// The same, for the recursions of newton_euler.cpp, gravity.cpp and metric.cpp.
  const CompactTree& compact_tree() const noexcept { return compact_; }
  /// Every link of the description, the root first, depth first.
  const std::vector<LinkFrame>& links() const noexcept { return links_; }
  /// Index in links(), if there is such a link. Not for the real-time loop: compares names.
  std::optional<int> find_link(std::string_view link_name) const noexcept;
  /// Index in joint_names(), if there is such an independent joint. Compares names.
  std::optional<int> find_joint(std::string_view joint_name) const noexcept;

 private:
  void list_factors(const std::vector<const JointDescription*>& order);
  void assemble(const TreeDescription& tree);
  void set_rotor_inertia(const Eigen::VectorXd& rotor_inertia);

  std::string name_;
  Base base_;
  int dof_ = 0;
  int nq_ = 0;
  double moving_mass_ = 0.0;
  Eigen::Vector3d gravity_;
  Eigen::VectorXd rotor_inertia_;
  std::vector<Factor> factors_;
  std::vector<std::string> joint_names_;
  std::vector<JointKind> joint_kinds_;
  std::vector<JointLimits> joint_limits_;
  std::vector<Body> bodies_;
  CompactTree compact_;
  std::vector<LinkFrame> links_;
};

}  // namespace geodesic::control
