// A drive family that does not exist, whole in this folder: for the proof that no other file has to
// know of a new one.
#pragma once

#include "drivers/families.hpp"

namespace geodesic::drivers::dummy {

/// This family's line.
Family family();

}  // namespace geodesic::drivers::dummy
