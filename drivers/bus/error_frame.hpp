// What an error frame of the kernel says of the CAN controller. No sockets.
#pragma once

#include "control/joint.hpp"
#include "drivers/bus/frame.hpp"

namespace geodesic::drivers {

/// Brings bus_off and error_passive of `state` up to date. Real-time.
/// @param frame  with error set; id is the class and data the details of linux/can/error.h.
/// @return true if the controller was restarted: what it held has been thrown away.
bool apply_error_frame(const Frame& frame, control::BusState& state) noexcept;

}  // namespace geodesic::drivers
