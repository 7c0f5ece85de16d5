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

/// Most independent joints a mechanism may have.
inline constexpr int kMaxMechanismJoints = 32;
/// Most moving joints, mimic joints included.
inline constexpr int kMaxMovingJoints = 64;

enum class Base {
  kFixed,     ///< the root link is the world
  kFloating,  ///< the root link moves freely: q and v begin with its pose and its twist
};

struct MechanismOptions {
  Base base = Base::kFixed;
  /// Inertia of the motors' rotors reflected to the joints, in the order of joint_names()
  /// [kg·m² or kg]; adds to the diagonal of the metric. Empty: none.
  Eigen::VectorXd rotor_inertia;
};

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
  kFree,         ///< six degrees of freedom; body 0 of a floating mechanism only
};

inline constexpr int kWorld = -1;

/// One moving body: a link and all that is fixed to it. Its frame is the joint's frame, turned such
/// that z is the joint axis.
struct Body {
  int parent = kWorld;  ///< index of the body it moves in; less than its own
  Motion motion = Motion::kRotation;
  int dof = 0;             ///< index in v of its (first) degree of freedom
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

/// Conventions. q = [joints], v = dq/dt; with a floating base q = [position in the world (3),
/// quaternion x y z w, joints], v = [linear (3), angular (3), joints], the base's twist in its own
/// axes. Joints depth first, siblings by joint name. SI units.
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
  int nq() const noexcept { return floating() ? dof_ + 1 : dof_; }
  bool floating() const noexcept { return base_ == Base::kFloating; }
  /// Index in v of the first joint: 0, or 6 behind a floating base.
  int first_joint_v() const noexcept { return floating() ? 6 : 0; }
  /// Index in q of the first joint: 0, or 7 behind a floating base.
  int first_joint_q() const noexcept { return floating() ? 7 : 0; }

  /// Independent joints; number i is v[first_joint_v() + i].
  const std::vector<std::string>& joint_names() const noexcept { return joint_names_; }
  const std::vector<JointKind>& joint_kinds() const noexcept { return joint_kinds_; }
  const std::vector<JointLimits>& joint_limits() const noexcept { return joint_limits_; }

  const Eigen::Vector3d& gravity() const noexcept { return gravity_; }
  /// Mass of everything that is not fixed to the world [kg].
  double moving_mass() const noexcept { return moving_mass_; }
  /// Size of v; zero for the floating base.
  const Eigen::VectorXd& rotor_inertia() const noexcept { return rotor_inertia_; }

  /// Parents before children.
  const std::vector<Body>& bodies() const noexcept { return bodies_; }
  /// The same, for the recursions of newton_euler.cpp and gravity.cpp.
  const std::vector<CompactBody>& compact_bodies() const noexcept { return compact_; }
  /// Every link of the description, the root first, depth first.
  const std::vector<LinkFrame>& links() const noexcept { return links_; }
  /// Index in links(), if there is such a link. Not for the real-time loop: compares names.
  std::optional<int> find_link(std::string_view link_name) const noexcept;
  /// Index in joint_names(), if there is such an independent joint. Compares names.
  std::optional<int> find_joint(std::string_view joint_name) const noexcept;

 private:
  void assemble(const TreeDescription& tree);
  void set_rotor_inertia(const Eigen::VectorXd& rotor_inertia);

  std::string name_;
  Base base_;
  int dof_ = 0;
  double moving_mass_ = 0.0;
  Eigen::Vector3d gravity_;
  Eigen::VectorXd rotor_inertia_;
  std::vector<std::string> joint_names_;
  std::vector<JointKind> joint_kinds_;
  std::vector<JointLimits> joint_limits_;
  std::vector<Body> bodies_;
  std::vector<CompactBody> compact_;
  std::vector<LinkFrame> links_;
};

}  // namespace geodesic::control
