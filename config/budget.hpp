// Bus time of a robot: what every bus has to carry in a cycle, with the arithmetic in words. When
// which frame is on the wire comes from drivers/cycle_plan.hpp.
#pragma once

#include <string>
#include <vector>

#include "config/robot.hpp"
#include "drivers/cycle_plan.hpp"

namespace geodesic::config {

/// One bus and what a cycle asks of it.
struct BusLoad {
  std::string name;
  std::string interface;
  std::size_t drives = 0;
  drivers::CyclePlan plan;
  std::int64_t deadline_ns = 0;  ///< after the tick: replies that come later are lost
  /// "8 drives on can0: 8 commands * 56.4 us + 8 replies * 56.4 us = 902.4 us at worst ...".
  std::string arithmetic;

  const drivers::BusBudget& budget() const noexcept { return plan.budget; }
};

struct BudgetReport {
  std::vector<BusLoad> buses;  ///< in the configuration's order
  bool carried = true;         ///< every bus can
};

/// By length and order of the frames, the drives' families, the bit rates, and
/// [simulation] reply_latency_us where a family does not say how fast its drives answer. Not
/// real-time.
BudgetReport bus_budget(const Robot& robot);

}  // namespace geodesic::config
