// The simulated arm on its buses: opens them, answers as the drives would, in real time or locked
// to the commands, until told to stop.
#pragma once

#include <atomic>
#include <csignal>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "config/robot.hpp"
#include "drivers/bus/bus.hpp"
#include "tools/sim/plant.hpp"

namespace geodesic::tools {

struct SimulationSettings {
  PlantOptions plant;
  bool lockstep = false;        ///< one period of physics for each complete set of commands
  bool wire = true;             ///< replies come when a real wire would carry them; real time only
  int priority = 10;            ///< SCHED_FIFO, where it is allowed; real time only
  double seconds = 0.0;         ///< simulated seconds after which it ends by itself; 0: never
  std::filesystem::path trace;  ///< empty: none
  double trace_hz = 100.0;
  /// Called once it answers: one line that says where, and what the model had to change. May be
  /// empty.
  std::function<void(const std::string& line, const std::vector<std::string>& warnings)> ready;
};

/// What went over one bus.
struct SimulatedBusReport {
  std::string interface;
  bool hosts_hub = false;
  drivers::BusCounters counters;
  std::uint64_t dropped = 0;  ///< replies given up since the bus did not take them
};

struct SimulationReport {
  PlantReport plant;
  std::vector<bool> enabled;     ///< at the end, each joint's drive
  std::vector<double> position;  ///< at the end
  PhysicsEnergy energy;          ///< at the end
  std::vector<SimulatedBusReport> buses;
  std::vector<std::string> warnings;
  double simulated_s = 0.0;
  std::int64_t start_ns = 0;          ///< of its clock: CLOCK_MONOTONIC, in lockstep one period
  std::uint64_t sets = 0;             ///< lockstep: complete sets of commands
  std::uint64_t incomplete_sets = 0;  ///< lockstep: sets given up waiting for
  bool realtime = false;              ///< real time: the kernel granted SCHED_FIFO
  double late_max_s = 0.0;            ///< real time: the latest a reply was sent after it was due
  double slipped_s = 0.0;             ///< real time: time this host was too busy to simulate
};

/// Runs until `stop` is set, the seconds are over, or something is wrong. Not real-time.
/// `waiting_mask`: signals blocked while it waits, and only then let through (see StopSignals).
/// @throws drivers::BusError, std::invalid_argument, std::runtime_error before anything answers;
///         Diverged later.
SimulationReport run_simulation(const config::Robot& robot, const SimulationSettings& settings,
                                const std::atomic<bool>& stop, const sigset_t& waiting_mask);

}  // namespace geodesic::tools
