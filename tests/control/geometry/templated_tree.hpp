// A tree of rigid bodies as a Lagrangian of one's own: T and V of every link, summed plainly in any
// scalar. It shares nothing with Mechanism but the description.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <map>
#include <string>

#include "control/geometry/jet_vector.hpp"
#include "control/mechanism/mechanism.hpp"

namespace geodesic::control::testing {

/// Joints are fixed, revolute, continuous or prismatic; q in the order of the mechanism made of the
/// same description.
class TemplatedTree {
 public:
  TemplatedTree(const TreeDescription& tree, const Eigen::Vector3d& gravity) : gravity_(gravity) {
    // Only for the order of its joints.
    const Mechanism order(tree, gravity);
    std::map<std::string, int> made{{tree.root_link, -1}};
    while (made.size() <= tree.joints.size()) {
      for (const auto& joint : tree.joints) {
        const auto parent = made.find(joint.parent_link);
        if (parent == made.end() || made.count(joint.child_link) != 0) continue;
        Link link;
        link.parent = parent->second;
        link.parent_from_joint = joint.parent_from_joint;
        link.axis = joint.axis;
        link.kind = joint.kind;
        if (joint.kind != JointKind::kFixed) link.coordinate = *order.find_joint(joint.name);
        link.moves = link.coordinate >= 0 || (link.parent >= 0 && at(link.parent).moves);
        for (const auto& described : tree.links) {
          if (described.name == joint.child_link) link.inertia = described.inertia;
        }
        made[joint.child_link] = count_;
        links_.at(static_cast<std::size_t>(count_++)) = link;
      }
    }
  }

  template <class S, int N>
  S operator()(const Eigen::Matrix<S, N, 1>& q, const Eigen::Matrix<S, N, 1>& v) const {
    using Vector = Eigen::Matrix<S, 3, 1>;
    using Matrix = Eigen::Matrix<S, 3, 3>;
    struct State {  // in world axes
      Matrix turn = Matrix::Identity();
      Vector origin = Vector::Zero(), velocity = Vector::Zero(), angular = Vector::Zero();
    };
    std::array<State, kLinks> states;
    S result = 0.0;
    for (int i = 0; i < count_; ++i) {
      const Link& link = at(i);
      const State parent =
          link.parent < 0 ? State{} : states[static_cast<std::size_t>(link.parent)];
      State& state = states[static_cast<std::size_t>(i)];
      const Matrix joint_turn = parent.turn * link.parent_from_joint.linear();
      Vector arm = parent.turn * link.parent_from_joint.translation();
      state.turn = joint_turn;
      state.angular = parent.angular;
      state.velocity = parent.velocity;
      if (link.coordinate >= 0) {
        const S& angle = q[link.coordinate];
        const Vector axis = joint_turn * link.axis;
        if (link.kind == JointKind::kPrismatic) {
          arm += axis * angle;
          state.velocity += axis * v[link.coordinate];
        } else {
          state.turn = joint_turn * rotation(link.axis, angle);
          state.angular += axis * v[link.coordinate];
        }
      }
      state.origin = parent.origin + arm;
      state.velocity += parent.angular.cross(arm);
      if (!link.moves) continue;
      const Vector com = state.turn * link.inertia.com_m;
      const Vector com_velocity = state.velocity + state.angular.cross(com);
      const Vector body_angular = state.turn.transpose() * state.angular;
      const Vector momentum = link.inertia.inertia_kg_m2 * body_angular;
      const Vector place = state.origin + com;
      const double m = link.inertia.mass_kg;
      result += 0.5 * m * com_velocity.dot(com_velocity) + 0.5 * body_angular.dot(momentum);
      for (int k = 0; k < 3; ++k) result += m * gravity_[k] * place[k];
    }
    return result;
  }

 private:
  static constexpr std::size_t kLinks = 24;

  struct Link {
    int parent = -1;
    int coordinate = -1;
    bool moves = false;
    JointKind kind = JointKind::kFixed;
    Eigen::Isometry3d parent_from_joint = Eigen::Isometry3d::Identity();
    Eigen::Vector3d axis = Eigen::Vector3d::UnitX();
    LinkInertia inertia;
  };

  const Link& at(int i) const { return links_[static_cast<std::size_t>(i)]; }

  /// Rodrigues' formula.
  template <class S>
  static Eigen::Matrix<S, 3, 3> rotation(const Eigen::Vector3d& axis, const S& angle) {
    using std::cos;
    using std::sin;
    const S c = cos(angle), s = sin(angle);
    Eigen::Matrix3d hat;
    hat << 0.0, -axis.z(), axis.y(), axis.z(), 0.0, -axis.x(), -axis.y(), axis.x(), 0.0;
    const Eigen::Matrix3d square = axis * axis.transpose();
    Eigen::Matrix<S, 3, 3> result;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        result(i, j) = (i == j ? c : S(0.0)) + s * hat(i, j) + (1.0 - c) * square(i, j);
      }
    }
    return result;
  }

  Eigen::Vector3d gravity_;
  int count_ = 0;
  std::array<Link, kLinks> links_;
};

}  // namespace geodesic::control::testing
