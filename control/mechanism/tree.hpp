// Description of a tree of rigid bodies, as a URDF gives it: names, frames, inertias, limits. Plain
// data without algorithms; Mechanism is built from it.
#pragma once

#include <Eigen/Geometry>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace geodesic::control {

/// Inertia of a link, in the link's own frame.
struct LinkInertia {
  double mass_kg = 0.0;
  Eigen::Vector3d com_m = Eigen::Vector3d::Zero();          ///< centre of mass
  Eigen::Matrix3d inertia_kg_m2 = Eigen::Matrix3d::Zero();  ///< about the centre of mass, link axes
};

struct LinkDescription {
  std::string name;
  LinkInertia inertia;
};

/// How the child moves in the joint's frame, and the Lie group of its positions.
enum class JointKind {
  kFixed,
  kRevolute,    ///< S1, about the axis, within limits
  kContinuous,  ///< S1, about the axis
  kPrismatic,   ///< R, along the axis
  kPlanar,      ///< R2 x SO(2): in the plane that the axis is normal to, and about the axis
  kSpherical,   ///< SO(3): about every axis through the joint's origin
  kFloating,    ///< SE(3): freely
};

/// Degrees of freedom of one joint.
constexpr int freedoms(JointKind kind) noexcept {
  switch (kind) {
    case JointKind::kFixed:
      return 0;
    case JointKind::kPlanar:
    case JointKind::kSpherical:
      return 3;
    case JointKind::kFloating:
      return 6;
    default:
      return 1;
  }
}

/// Numbers of q one joint takes: a rotation of space is written as a quaternion.
constexpr int coordinates(JointKind kind) noexcept {
  const bool turns_freely = kind == JointKind::kSpherical || kind == JointKind::kFloating;
  return freedoms(kind) + (turns_freely ? 1 : 0);
}

/// As a URDF spells it; "spherical" is not among a URDF's types.
constexpr const char* kind_name(JointKind kind) noexcept {
  switch (kind) {
    case JointKind::kRevolute:
      return "revolute";
    case JointKind::kContinuous:
      return "continuous";
    case JointKind::kPrismatic:
      return "prismatic";
    case JointKind::kPlanar:
      return "planar";
    case JointKind::kSpherical:
      return "spherical";
    case JointKind::kFloating:
      return "floating";
    case JointKind::kFixed:
      break;
  }
  return "fixed";
}

/// This joint's position is multiplier * (position of `joint`) + offset. Both have one degree of
/// freedom.
struct MimicDescription {
  std::string joint;
  double multiplier = 1.0;
  double offset = 0.0;  ///< [rad or m]
};

struct JointDescription {
  std::string name;
  JointKind kind = JointKind::kFixed;
  std::string parent_link;
  std::string child_link;
  Eigen::Isometry3d parent_from_joint = Eigen::Isometry3d::Identity();  ///< at position 0
  /// Unit, joint frame; the normal of a planar joint's plane; without meaning where a joint turns
  /// freely.
  Eigen::Vector3d axis = Eigen::Vector3d::UnitX();
  double lower = -std::numeric_limits<double>::infinity();    ///< [rad or m]
  double upper = std::numeric_limits<double>::infinity();     ///< [rad or m]
  double effort = std::numeric_limits<double>::infinity();    ///< [N·m or N]
  double velocity = std::numeric_limits<double>::infinity();  ///< [rad/s or m/s]
  std::optional<MimicDescription> mimic;
};

/// A tree: one root link, every other link the child of exactly one joint. The order of `joints` is
/// free; Mechanism orders them depth first, siblings by joint name.
struct TreeDescription {
  std::string name;
  std::string root_link;
  std::vector<LinkDescription> links;
  std::vector<JointDescription> joints;
};

}  // namespace geodesic::control
