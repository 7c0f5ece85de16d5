// The robots that are measured: read from URDFs, or chains of any length made up here.
#pragma once

#include <string>
#include <vector>

#include "control/mechanism/mechanism.hpp"
#include "tests/bench/peers/peer.hpp"

namespace geodesic::bench {

/// A robot as PeerRobot with what its pointer points at.
struct FlatRobot {
  std::vector<PeerBody> body;
  PeerRobot robot() const;
  int nq = 0;
  int dof = 0;
  std::string compiled;  ///< see PeerRobot
  double gravity[3] = {0.0, 0.0, -9.81};
};

/// Every joint of the file, fixed ones too, in the order of the mechanism's degrees of freedom.
FlatRobot as_written(const control::TreeDescription& tree, const control::Mechanism& mechanism);
/// Moving bodies only, with all that is fixed to them.
FlatRobot merged(const control::Mechanism& mechanism);

/// @throws std::runtime_error with the reader's messages. @param file  a URDF
control::TreeDescription read_tree(const std::string& file);

/// A chain of n joints that turn about z, y, z, ..., links of 0.2 m that weigh 5 kg at the base and
/// 0.2 kg at the tip.
control::TreeDescription chain(int joints);

}  // namespace geodesic::bench
