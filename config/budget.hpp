// Bus time of a robot: what every bus has to carry in a cycle, with the arithmetic in words. How
// long a frame is comes from drivers/bus/bit_timing.hpp.
#pragma once

#include <string>
#include <vector>

#include "config/robot.hpp"
#include "drivers/bus/bit_timing.hpp"

namespace geodesic::config {

/// One bus and what a cycle asks of it.
struct BusLoad {
  std::string name;
  std::string interface;
  std::size_t drives = 0;
  drivers::BusBudget budget;
  /// "8 drives on can0: 8 commands * 56.4 us + 8 replies * 56.4 us = 902.4 us at worst ...".
  std::string arithmetic;
};

struct BudgetReport {
  std::vector<BusLoad> buses;  ///< in the configuration's order
  bool carried = true;         ///< every bus can
};

/// Worst case by length of frame, the drives' families and the bit rates. Not real-time.
BudgetReport bus_budget(const Robot& robot);

}  // namespace geodesic::config
