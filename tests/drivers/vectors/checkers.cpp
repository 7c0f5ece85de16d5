// The table of checkers; see checkers.hpp.
#include "tests/drivers/vectors/checkers.hpp"

#include <array>

#include "tests/drivers/cia402/vectors.hpp"
#include "tests/drivers/cubemars/vectors.hpp"
#include "tests/drivers/damiao/vectors.hpp"
#include "tests/drivers/moteus/vectors.hpp"
#include "tests/drivers/myactuator/vectors.hpp"
#include "tests/drivers/odrive/vectors.hpp"
#include "tests/drivers/robstride/vectors.hpp"

namespace geodesic::drivers::test {

std::span<const VectorChecker> vector_checkers() {
  static constexpr std::array kCheckers = {
      VectorChecker{"damiao", check_damiao_row},
      VectorChecker{"cubemars", check_cubemars_row},
      VectorChecker{"robstride", check_robstride_row},
      VectorChecker{"moteus", check_moteus_row},
      VectorChecker{"odrive", check_odrive_row},
      VectorChecker{"cia402", check_cia402_row},
      VectorChecker{"myactuator", check_myactuator_row},
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
