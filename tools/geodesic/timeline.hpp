// A cycle on the wire for people: who sends when, with which slack, as table, JSON and picture. The
// model is drivers/cycle_plan.hpp's.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "config/budget.hpp"

namespace geodesic::tools {

/// Of one bus. Times in us since the cycle's first command; slack: up to where a reply would count
/// as lost; headroom: up to the next cycle.
nlohmann::ordered_json timeline_json(const config::Robot& robot, std::size_t bus,
                                     const config::BusLoad& load);

void print_timelines(const config::Robot& robot, const config::BudgetReport& budget);

/// Draws all buses, one below the other. @throws BadInput saying what is missing.
void draw_timelines(const config::Robot& robot, const config::BudgetReport& budget,
                    const std::string& file);

}  // namespace geodesic::tools
