// Rigid-body dynamics beside other libraries: the same robots and states, results compared before
// anything is timed, rounds interleaved in one process.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "tests/bench/peers/peer.hpp"

namespace geodesic::bench {

struct DynamicsOptions {
  std::vector<std::string> robots;    ///< URDF files
  std::vector<std::string> floating;  ///< URDF files whose root link floats
  /// Folder of models compiled ahead, <name of the URDF>.so each; empty: none.
  std::string compiled;
  std::string peers;  ///< folder of the peers' shared objects
  int rounds = 60;
  double slice_us = 300.0;  ///< one contender's turn in a round
  int cold_rounds = 40;     ///< calls with swept caches; 0: none
};

/// Nanoseconds a call over all rounds.
struct Timing {
  bool cold = false;  ///< caches swept before each call, so one call a round
  std::string function;
  std::string who;
  double min = 0.0;
  double median = 0.0;
  double p90 = 0.0;
};

struct RobotTimings {
  std::string robot;
  int dof = 0;
  std::vector<std::string> absent;  ///< who cannot have this robot, and why
  /// Who, and the worst difference from ours relative to the largest entry.
  std::map<std::string, double> differences;
  std::vector<Timing> timings;
};

/// @throws std::runtime_error where a library cannot be loaded or disagrees with us by
///   more than Peer::agreement: a wrong call must not win.
std::vector<RobotTimings> measure_dynamics(const DynamicsOptions& options);

/// Calls one function of one contender so many times and does nothing else: for an instruction
/// counter around the process. @throws std::runtime_error for a name that is not there.
void call_only(const DynamicsOptions& options, const std::string& who, const std::string& function,
               long calls);

/// This project, through the same door.
const Peer& our_peer();

}  // namespace geodesic::bench
