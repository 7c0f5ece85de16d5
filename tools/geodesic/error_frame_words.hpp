// A CAN controller's error frames in words. Knows nothing of drives.
#pragma once

#include <vector>

#include "drivers/bus/frame.hpp"
#include "drivers/families.hpp"

namespace geodesic::tools {

/// What the kernel says happened on the wire, a field each: {"controller", "error-passive", ""}.
std::vector<drivers::DecodedField> error_frame_words(const drivers::Frame& frame);

}  // namespace geodesic::tools
