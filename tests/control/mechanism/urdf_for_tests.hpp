// The least reader of URDF that the oracle tests need, so that they stand without config's own.
// It trusts its input.
#pragma once

#include <filesystem>

#include "control/mechanism/tree.hpp"

namespace geodesic::control::testing {

/// @throws std::runtime_error if the file cannot be read. rpy is taken as written.
TreeDescription read_urdf(const std::filesystem::path& file);

}  // namespace geodesic::control::testing
