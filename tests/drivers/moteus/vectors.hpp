// Holds rows of golden vectors against the moteus codec and the simulated drive.
#pragma once

#include <string>
#include <vector>

#include "tests/drivers/vectors/row.hpp"

namespace geodesic::drivers::test {

/// As VectorChecker::check.
std::vector<std::string> check_moteus_row(const Row& row);

}  // namespace geodesic::drivers::test
