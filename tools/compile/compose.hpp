// From a mechanism to programs: tries where the frames' freedom is best spent and keeps, for each
// function, what takes the fewest operations.
#pragma once

#include <functional>

#include "tools/compile/emit.hpp"

namespace geodesic::tools::compile {

/// Called now and then with what is being tried and how far it has come, 0..1.
using Progress = std::function<void(const std::string& what, double part)>;

/// @param snap  one of kSnaps. The same mechanism gives the same programs.
/// @throws std::invalid_argument if uncompilable().
Emission compose(const control::Mechanism& mechanism, double snap, const Progress& progress = {});

}  // namespace geodesic::tools::compile
