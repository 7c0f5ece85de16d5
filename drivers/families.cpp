// The table of drive families, one line each. What a family is stands in its own folder.
#include "drivers/families.hpp"

#include <algorithm>
#include <array>

#include "drivers/cia402/family.hpp"
#include "drivers/cubemars/family.hpp"
#include "drivers/damiao/family.hpp"
#include "drivers/moteus/family.hpp"
#include "drivers/myactuator/family.hpp"
#include "drivers/odrive/family.hpp"
#include "drivers/robstride/family.hpp"

namespace geodesic::drivers {

std::span<const Family> families() {
  // One line a family.
  // clang-format off
  static const std::array kFamilies = {
      damiao::family(),
      cubemars::family(),
      robstride::family(),
      moteus::family(),
      odrive::family(),
      cia402::family(),
      myactuator::family(),
  };
  // clang-format on
  return kFamilies;
}

const Family* find_family(std::string_view name) {
  const std::span<const Family> all = families();
  const auto found = std::find_if(all.begin(), all.end(),
                                  [name](const Family& family) { return family.name == name; });
  return found == all.end() ? nullptr : &*found;
}

}  // namespace geodesic::drivers
