// The two ways to run a plant on buses: in real time, or locked to the commands. Each returns when
// told to stop or when its seconds are over.
#pragma once

#include <atomic>
#include <csignal>

#include "config/robot.hpp"
#include "tools/sim/plant.hpp"
#include "tools/sim/sim_buses.hpp"
#include "tools/sim/simulation.hpp"

namespace geodesic::tools {

struct LoopContext {
  const config::Robot& robot;
  const SimulationSettings& settings;
  Plant& plant;
  SimBuses& buses;
  const std::atomic<bool>& stop;
  const sigset_t& waiting_mask;
  SimulationReport& report;  ///< the loop's own figures go here
};

/// The plant's clock is CLOCK_MONOTONIC.
void run_in_real_time(const LoopContext& context);

/// One control period of physics for each complete set of commands: once every drive that is not
/// silent has been addressed. Replies leave at once and show the state after the step; the commands
/// act in the next. The plant's clock is simulated. A set that stays incomplete for kPatience of
/// real time is answered as it is, and counted.
void run_in_lockstep(const LoopContext& context);
inline constexpr double kPatience = 0.2;  ///< [s]

/// What one frame of a babbling node takes of the bus: classic, eight bytes, 1 Mbit/s.
inline constexpr std::int64_t kFloodFrameNs = 111'000;

}  // namespace geodesic::tools
