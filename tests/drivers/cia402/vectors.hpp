// Holds rows of golden vectors against the CANopen codec, both ways.
#pragma once

#include <string>
#include <vector>

#include "tests/drivers/vectors/row.hpp"

namespace geodesic::drivers::test {

/// Contract as VectorChecker::check.
std::vector<std::string> check_cia402_row(const Row& row);

}  // namespace geodesic::drivers::test
