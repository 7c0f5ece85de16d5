// Holds rows of golden vectors against the MyActuator codec and simulated drive.
#pragma once

#include <string>
#include <vector>

#include "tests/drivers/vectors/row.hpp"

namespace geodesic::drivers::test {

/// As VectorChecker::check.
std::vector<std::string> check_myactuator_row(const Row& row);

}  // namespace geodesic::drivers::test
