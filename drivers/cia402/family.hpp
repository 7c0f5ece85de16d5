// The CiA 402 family's line in the table of families, and its frames in words for people.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "drivers/families.hpp"

namespace geodesic::drivers::cia402 {

/// Contracts as the members of drivers::Family. Not real-time.
std::optional<DecodedFrame> decode(const Frame& frame, const DriveOptions& options);
std::vector<std::string> check(const DriveOptions& options);
std::vector<CyclicFrame> cyclic_frames(const DriveOptions& options, double rate_hz);

/// This family's line.
Family family();

}  // namespace geodesic::drivers::cia402
