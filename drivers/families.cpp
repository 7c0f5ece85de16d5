// The table of drive families, one line each. What a family is stands in its own folder.
#include "drivers/families.hpp"

#include <algorithm>
#include <array>

#include "drivers/damiao/family.hpp"

namespace geodesic::drivers {

std::span<const Family> families() {
  static const std::array kFamilies = {
      damiao::family(),
  };
  return kFamilies;
}

const Family* find_family(std::string_view name) {
  const std::span<const Family> all = families();
  const auto found = std::find_if(all.begin(), all.end(),
                                  [name](const Family& family) { return family.name == name; });
  return found == all.end() ? nullptr : &*found;
}

}  // namespace geodesic::drivers
