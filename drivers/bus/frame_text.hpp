// A frame as candump writes it: for logs and for people. Reading such text is tools/' business.
#pragma once

#include <string>

#include "drivers/bus/frame.hpp"

namespace geodesic::drivers {

/// "123#0011", "12345678#R8" (remote, length 8), "123##1AABB" (CAN FD, flags). Not real-time.
/// Format: can-utils, candump(1) and lib.c.
std::string candump_text(const Frame& frame);

}  // namespace geodesic::drivers
