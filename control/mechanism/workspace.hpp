// Every buffer the mechanism's algorithms need, allocated once. One Workspace serves one thread;
// its members belong to the algorithms, callers keep what those return.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "control/geometry/spatial.hpp"
#include "control/mechanism/cholesky.hpp"
#include "control/mechanism/compact_dispatch.hpp"
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

  /// How a compact body (compact_tree.hpp) moves, in its own coordinates.
  struct Course {
    Triple angular;       ///< velocity [rad/s]
    Triple angular_rate;  ///< acceleration [rad/s²]
    Triple acceleration;  ///< of the origin, gravity included [m/s²]
  };

  /// What it asks for, or the momentum of it and all it carries. About its origin.
  struct Load {
    Triple force;   ///< [N] or [kg·m/s]
    Triple moment;  ///< [N·m] or [kg·m²/s]
  };

  /// Sum of mass * position * position' [kg·m²].
  struct Second {
    double xx = 0.0;
    double xy = 0.0;
    double xz = 0.0;
    double yy = 0.0;
    double yz = 0.0;
    double zz = 0.0;
  };

  /// It and all it carries, about its origin.
  struct Carried {
    double mass = 0.0;  ///< [kg]
    Triple first;       ///< moment [kg·m]
    Second second;
  };

  /// What the recursions on compact bodies are built for; any that the machine has may be set.
  Registers registers = widest_registers();
  std::vector<Load> load;
  std::vector<Course> course;    ///< of bodies with several children
  std::vector<Carried> carried;  ///< by bodies with several children
  std::vector<Axes> axes;        ///< of bodies with several degrees of freedom, in their joints'
  std::vector<double> sine;      ///< of each compact body's angle, padded to a vector's length
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
  Eigen::MatrixXd metric_inverse;
  Eigen::MatrixXd metric_rate;
  Eigen::MatrixXd coriolis;
  Jacobian jacobian;

  /// One body under two vector fields X and Y of constant components (connection.cpp), its points r
  /// under a field n(r) = linear + turning r (curvature.cpp); its own coordinates.
  struct FieldState {
    Twist x;
    Twist y;
    Twist rate;  ///< of Y's twist along X, then of whatever tangent field is subtracted
    Eigen::Vector3d linear;
    Eigen::Matrix3d turning;
    Wrench wrench;           ///< of n on the body and all that hangs on it
    Eigen::Vector3d couple;  ///< of n against the velocity field of X
  };

  /// One articulated body (articulated_body.cpp) in its own coordinates.
  struct ArticulatedState {
    Eigen::Matrix3d linear;                      ///< force per linear acceleration [kg]
    Eigen::Matrix3d coupling;                    ///< force per angular acceleration [kg·m]
    Eigen::Matrix3d angular;                     ///< moment per angular acceleration [kg·m²]
    Wrench rest;                                 ///< at zero acceleration
    Twist drift;                                 ///< acceleration that velocities cause
    std::array<Wrench, 6> column;                ///< inertia times a column of the joint
    std::array<std::array<double, 6>, 6> pivot;  ///< inertia that the joint meets, factored
    std::array<double, 6> torque;                ///< what is left of it for acceleration
  };

  TreeCholesky cholesky;  ///< of the metric last factored
  std::vector<FieldState> field;
  std::vector<ArticulatedState> articulated;
  Eigen::VectorXd flat;
  Eigen::VectorXd sharp;
  Eigen::VectorXd connection;
  Eigen::VectorXd covariant_derivative;
  Eigen::VectorXd curvature;
  Eigen::VectorXd generator;
  Eigen::VectorXd external_torque;
  Eigen::MatrixXd lie_derivative;
  Eigen::MatrixXd field_bracket;
  Eigen::VectorXd configuration;  ///< size nq
  Jacobian jacobian_rate;
  Jacobian momentum_matrix;
};

}  // namespace geodesic::control
