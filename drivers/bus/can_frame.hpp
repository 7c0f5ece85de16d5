// Between Frame and the kernel's CAN frame structures. No sockets.
#pragma once

#include <linux/can.h>

#include <cstddef>

#include "drivers/bus/frame.hpp"

namespace geodesic::drivers {

/// Real-time. @return bytes of `out` to hand to the kernel (CAN_MTU or CANFD_MTU).
std::size_t encode_can_frame(const Frame& frame, canfd_frame& out) noexcept;

/// Real-time. @param bytes as read. @return false for sizes that are neither CAN_MTU nor
/// CANFD_MTU.
bool decode_can_frame(const canfd_frame& in, std::size_t bytes, Frame& out) noexcept;

}  // namespace geodesic::drivers
