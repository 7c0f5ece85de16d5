// The ODrive family's line in the table of families, and the checks of its options.
#pragma once

#include <string>
#include <vector>

#include "drivers/families.hpp"

namespace geodesic::drivers::odrive {

/// Contracts as the members of drivers::Family. Not real-time.
std::vector<std::string> check(const DriveOptions& options);
std::vector<CyclicFrame> cyclic_frames(const DriveOptions& options, double rate_hz);

/// This family's line.
Family family();

}  // namespace geodesic::drivers::odrive
