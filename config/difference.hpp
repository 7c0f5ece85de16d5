// What differs between two robots, option by option and link by link: the text of every reload and
// of `geodesic tune`. Says of each whether a running daemon may take it; decides nothing else.
#pragma once

#include <string>
#include <vector>

#include "config/robot.hpp"

namespace geodesic::config {

struct Change {
  std::string path;  ///< "joint.elbow.damping", "urdf.link.forearm.mass"
  std::string from;  ///< as people read it; "-": was not there
  std::string to;    ///< "-": is not there any more
  std::string unit;
  Live live{};
  Place place;  ///< in the newer of the two; line 0: unknown
};

/// "joint.elbow.damping: 0.1 -> 0.2 N·m·s/rad".
std::string to_string(const Change& change);

/// Everything in which `to` differs from `from`, in the order of the reference, then the URDF's.
/// Nothing is compared with a tolerance. Not real-time.
std::vector<Change> difference(const Robot& from, const Robot& to);

}  // namespace geodesic::config
