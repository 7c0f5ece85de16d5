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

enum class JointKind { kFixed, kRevolute, kContinuous, kPrismatic };

/// This joint's position is multiplier * (position of `joint`) + offset.
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
  Eigen::Vector3d axis = Eigen::Vector3d::UnitX();                      ///< unit, joint frame
  double lower = -std::numeric_limits<double>::infinity();              ///< [rad or m]
  double upper = std::numeric_limits<double>::infinity();               ///< [rad or m]
  double effort = std::numeric_limits<double>::infinity();              ///< [N·m or N]
  double velocity = std::numeric_limits<double>::infinity();            ///< [rad/s or m/s]
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
