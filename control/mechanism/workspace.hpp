// Every buffer the mechanism's algorithms need, allocated once. One Workspace serves one thread;
// its members belong to the algorithms, callers keep what those return.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "control/geometry/spatial.hpp"
#include "control/mechanism/mechanism.hpp"

namespace geodesic::control {

/// A vector argument: a VectorXd, a contiguous segment, or a Map over plain memory. An expression
/// (such as 2 * v) would be evaluated into a temporary on the heap: real-time callers pass storage.
using VectorIn = Eigen::Ref<const Eigen::VectorXd>;

/// Columns belong to degrees of freedom, rows to linear (3) then angular (3) velocity.
using Jacobian = Eigen::Matrix<double, 6, Eigen::Dynamic>;

struct Workspace {
  /// @throws std::bad_alloc. Not real-time; everything that takes a Workspace afterwards is.
  explicit Workspace(const Mechanism& mechanism);

  /// One body in its own coordinates.
  struct BodyState {
    Pose parent_from_body;
    Twist velocity;
    Twist acceleration;
    Wrench force;
  };

  /// A body and all that hangs on it, in the coordinates of that body's frame.
  struct Composite {
    RigidInertia inertia;
    Eigen::Vector3d momentum;  ///< linear [kg·m/s]
    Eigen::Matrix3d flow;      ///< sum of mass * velocity * position' [kg·m²/s]
  };

  /// One compact body (compact_tree.hpp) in its own coordinates.
  struct CompactState {
    Triple angular;       ///< velocity [rad/s]
    Triple angular_rate;  ///< acceleration [rad/s²]
    Triple acceleration;  ///< of the origin, gravity included [m/s²]
    Triple translation;   ///< of the origin in the parent [m]
    Triple force;         ///< [N]
    Triple moment;        ///< about the origin [N·m]
  };

  std::vector<CompactState> compact;
  std::vector<double> angle;  ///< [rad] of each compact body, padded to an even number
  std::vector<double> sine;
  std::vector<double> cosine;

  std::vector<BodyState> body;
  std::vector<Composite> composite;
  std::vector<Pose> world_from_body;
  std::vector<Wrench> body_momentum;  ///< of a body and all that hangs on it

  Eigen::VectorXd gravity;
  Eigen::VectorXd bias;
  Eigen::VectorXd inverse_dynamics;
  Eigen::VectorXd forward_dynamics;
  Eigen::VectorXd unit_velocity;
  Eigen::VectorXd joint_momentum;
  Eigen::VectorXd momentum_drift;
  Eigen::MatrixXd metric;
  Eigen::MatrixXd metric_factor;
  Eigen::MatrixXd metric_inverse;
  Eigen::MatrixXd metric_rate;
  Eigen::MatrixXd coriolis;
  Jacobian jacobian;
};

}  // namespace geodesic::control
