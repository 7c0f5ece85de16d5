// What a recorded frame means to a robot: whose it is, and its figures in words. Asks the drive
// families; prints nothing.
#pragma once

#include <string>
#include <vector>

#include "config/robot.hpp"
#include "drivers/families.hpp"
#include "tools/geodesic/candump.hpp"

namespace geodesic::tools {

struct FrameMeaning {
  std::string joint;  ///< empty: nobody's; several, "a, b", if it says the same to each of them
  std::string kind;   ///< "unknown" where no drive knows it
  std::vector<drivers::DecodedField> fields;
};

FrameMeaning meaning_of(const CandumpLine& line, const config::Robot& robot);

}  // namespace geodesic::tools
