// A run of the simulated arm as JSON, for tests and the demo. Formats; measures nothing.
#pragma once

#include <nlohmann/json.hpp>

#include "config/robot.hpp"
#include "tools/sim/simulation.hpp"

namespace geodesic::tools {

/// SI units; times count from the start of the simulation unless their key says otherwise.
nlohmann::ordered_json to_json(const SimulationReport& report, const config::Robot& robot);

}  // namespace geodesic::tools
