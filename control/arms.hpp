// A robot's arms: groups of joints that start and stop together, apart from the other groups. Which
// joints and buses are whose; what follows from a fault is safety/'s.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "control/bit_set.hpp"
#include "control/mechanism/mechanism.hpp"
#include "control/options.hpp"

namespace geodesic::control {

/// The arms as the loop needs them.
struct Arms {
  std::size_t count = 1;
  std::array<BitSet, kMaxArms> joints{};
  std::array<BitSet, kMaxArms> buses{};  ///< those its joints use; one arm alone: every bus
  std::array<std::uint8_t, kMaxJoints> arm_of{};
};

/// Options without arms: one arm of all joints. Not real-time.
Arms arms_of(const ControllerOptions& options);

/// The arm's name, "arm" if the options name none. Not real-time.
std::string arm_name(const ControllerOptions& options, std::size_t arm);

/// What is wrong with the arms, each a sentence; empty: nothing. Every joint must belong to exactly
/// one arm, and joints that carry each other to the same one: what one of them does, the other's
/// torque depends on. Not real-time.
std::vector<std::string> check_arms(const ControllerOptions& options);
std::vector<std::string> check_arms(const ControllerOptions& options, const Mechanism& mechanism);

}  // namespace geodesic::control
