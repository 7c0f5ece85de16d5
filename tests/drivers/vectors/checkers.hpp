// Which function holds a row of golden vectors against a family's codec: one line a family. A new
// family adds its line in checkers.cpp; a family without one fails the test.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tests/drivers/vectors/row.hpp"

namespace geodesic::drivers::test {

struct VectorChecker {
  std::string_view family;
  /// @return what is wrong, each a sentence; empty: the codec agrees both ways.
  /// @throws std::invalid_argument if the row lacks what it must say.
  std::vector<std::string> (*check)(const Row& row);
};

std::span<const VectorChecker> vector_checkers();

/// The checker for a file of that stem: the one whose family's name it contains; null: none.
const VectorChecker* checker_for(std::string_view stem);

}  // namespace geodesic::drivers::test
