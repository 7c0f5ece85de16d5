// The table of checkers; see checkers.hpp.
#include "tests/drivers/vectors/checkers.hpp"

#include <array>

#include "tests/drivers/damiao/vectors.hpp"

namespace geodesic::drivers::test {

std::span<const VectorChecker> vector_checkers() {
  static constexpr std::array kCheckers = {
      VectorChecker{"damiao", check_damiao_row},
  };
  return kCheckers;
}

const VectorChecker* checker_for(std::string_view stem) {
  for (const VectorChecker& checker : vector_checkers()) {
    if (stem.find(checker.family) != std::string_view::npos) {
      return &checker;
    }
  }
  return nullptr;
}

}  // namespace geodesic::drivers::test
