// From a checked robot to what the controller runs on: its options and the model, payload included.
#pragma once

#include <optional>

#include "config/robot.hpp"
#include "control/setup.hpp"

namespace geodesic::config {

/// What the controller computes with: the tree, with `payload` (an index into robot.payloads), and
/// the rotors' inertias. Not real-time. @throws std::invalid_argument as Mechanism does.
control::Mechanism make_mechanism(const Robot& robot, std::optional<std::size_t> payload);

/// The same robot gives the same setup to the bit. Not real-time. @throws as above.
control::Setup make_setup(const Robot& robot);

}  // namespace geodesic::config
