// The simulated arm's mechanics: MuJoCo behind joint torques, external pushes and time. Knows no
// drive, no bus and no clock; the controller's own equations are nowhere in it.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "config/robot.hpp"

namespace geodesic::tools {

struct PhysicsEnergy {
  double kinetic_j = 0.0;
  double potential_j = 0.0;  ///< 0 where every centre of mass is in the plane of the world's origin
};

class Physics {
 public:
  static constexpr double kDefaultTimestep = 250e-6;

  /// Builds the model of `robot`; at its start pose, at rest. Not real-time.
  /// @throws std::invalid_argument for a tree that is none, or a pose that does not fit;
  ///         std::runtime_error with MuJoCo's words if it refuses the model.
  explicit Physics(const config::Robot& robot, double timestep_s = kDefaultTimestep);
  ~Physics();
  Physics(const Physics&) = delete;
  Physics& operator=(const Physics&) = delete;

  std::size_t joints() const noexcept;
  double timestep_s() const noexcept;
  const std::vector<std::string>& warnings() const noexcept;

  /// Puts the arm there; joints that mimic follow. Sizes: joints(), in order of v [rad, rad/s].
  void set_state(std::span<const double> position, std::span<const double> velocity);
  double position(std::size_t joint) const noexcept;
  double velocity(std::size_t joint) const noexcept;

  /// Torque on a joint from now on [N·m or N].
  void set_torque(std::size_t joint, double torque) noexcept;
  /// Forgets all external forces on links.
  void clear_forces() noexcept;
  /// Adds a force [N, world axes] at the origin of a link, at its present place, until cleared.
  void add_force(int link, const Eigen::Vector3d& force) noexcept;
  /// Handle of a link by name; -1 if there is none.
  int find_link(const std::string& name) const noexcept;

  /// One timestep.
  void step() noexcept;

  /// Accelerations [rad/s² or m/s²] at the present state under the present torques.
  std::vector<double> accelerations();
  /// The same without stops, friction and mimic gears' give: the joints' own equations of motion,
  /// mass matrix and bias by MuJoCo, with joints that mimic folded in exactly.
  std::vector<double> free_accelerations();
  /// What is left of torques, gravity, Coriolis and viscous forces, per joint [N·m or N]: zero
  /// where the torques just hold the motion's acceleration at zero.
  std::vector<double> unbalanced_torques();
  PhysicsEnergy energy();
  /// Sum of the normal forces of all contacts with the floor in the last step [N].
  double floor_force() const;
  /// What those contacts, friction included, did to each joint in the last step [N·m or N].
  std::vector<double> contact_torques() const;
  bool finite() const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace geodesic::tools
