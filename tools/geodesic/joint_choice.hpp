// Which joint of a robot a command for people at the bench is about.
#pragma once

#include <cstddef>
#include <string>

#include "config/robot.hpp"

namespace geodesic::tools {

/// By its name. @throws BadInput with the names there are.
std::size_t choose_joint(const config::Robot& robot, const std::string& name);

/// "rad" or "m": the joint's unit.
const char* unit_of(const config::Robot& robot, std::size_t joint);

}  // namespace geodesic::tools
