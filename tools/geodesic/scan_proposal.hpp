// From the drives that answered to files that load: a robot.toml with a joint for each, and a
// stand-in URDF. Text only; sends and prints nothing.
#pragma once

#include <string>
#include <vector>

#include "drivers/bench_dialogue.hpp"
#include "drivers/families.hpp"

namespace geodesic::tools {

/// A drive that answered, and where.
struct Sighting {
  std::string interface;
  std::string family;
  bool fd = false;  ///< it answered CAN FD frames
  drivers::FoundDrive drive;
};

struct Proposal {
  std::string toml;
  std::string urdf;
  std::vector<std::string> gaps;  ///< what has to be filled in by a person before it may move
};

/// Adds to each sighting what only shows beside the others: two families that claim one
/// identifier, drives of one family that speak CAN FD and that do not.
void compare(std::vector<Sighting>& sightings);

/// Every drive as a joint: joint1, joint2, ... in the order of the sightings.
Proposal propose(const std::vector<Sighting>& sightings);

/// The options that a sighting amounts to, as far as they are known.
drivers::DriveOptions options_of(const Sighting& sighting);

}  // namespace geodesic::tools
