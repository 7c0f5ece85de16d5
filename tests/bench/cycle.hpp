// The daemon's cycle without a kernel bus and without waiting: arm, drives' codecs, controller and
// telemetry against simulated drives in memory, for robots of any number of joints.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace geodesic::bench {

struct CycleOptions {
  std::vector<int> joints{2, 7, 16, 32};
  long cycles = 20'000;  ///< measured, after the arm has become active
};

/// One part of the cycle [ns].
struct Phase {
  std::string name;
  double min = 0.0;
  double median = 0.0;
  double p99 = 0.0;
};

struct CycleFigures {
  int joints = 0;
  int buses = 0;
  long cycles = 0;
  std::string state;              ///< of the supervisor at the end: "active", or figures mislead
  std::int64_t object_bytes = 0;  ///< heap that arm, controller and telemetry took
  std::int64_t heap_bytes_grown = 0;  ///< by cycling
  std::vector<Phase> phases;          ///< transmit, receive, update, publish, and their sum
};

/// Not real-time itself. @throws std::runtime_error if an arm does not become active.
std::vector<CycleFigures> measure_cycle(const CycleOptions& options);

}  // namespace geodesic::bench
