// Builds the controller's setup; see setup.hpp.
#include "config/setup.hpp"

#include "config/payloads.hpp"

namespace geodesic::config {

control::Mechanism make_mechanism(const Robot& robot, std::optional<std::size_t> payload) {
  control::MechanismOptions options;
  options.rotor_inertia.resize(static_cast<Eigen::Index>(robot.controller.joints.size()));
  for (Eigen::Index i = 0; i < options.rotor_inertia.size(); ++i) {
    options.rotor_inertia[i] = robot.controller.joints[static_cast<std::size_t>(i)].rotor_inertia;
  }
  if (!payload) return {robot.tree, robot.gravity, options};
  return {with_payload(robot.tree, robot.payloads.at(*payload)), robot.gravity, options};
}

control::Setup make_setup(const Robot& robot) {
  return {robot.controller, make_mechanism(robot, robot.payload)};
}

}  // namespace geodesic::config
