// Between Frame and the kernel's CAN frame structures. No sockets.
#include "drivers/bus/can_frame.hpp"

#include <linux/can/error.h>

#include <algorithm>
#include <cstring>

namespace geodesic::drivers {

std::size_t encode_can_frame(const Frame& frame, canfd_frame& out) noexcept {
  const std::size_t capacity = frame.fd ? CANFD_MAX_DLEN : CAN_MAX_DLEN;
  out.can_id = frame.id | (frame.extended && !frame.error ? CAN_EFF_FLAG : 0U) |
               (frame.error ? CAN_ERR_FLAG : 0U) |
               (frame.remote && !frame.error && !frame.fd ? CAN_RTR_FLAG : 0U);
  // A length that is not a CAN length is left to the kernel, which refuses it with EINVAL.
  out.len = frame.length;
  out.flags = frame.fd && frame.bit_rate_switch ? CANFD_BRS : 0;
  out.__res0 = 0;
  out.__res1 = 0;
  const std::size_t bytes = frame.remote ? 0 : std::min<std::size_t>(frame.length, capacity);
  std::memcpy(out.data, frame.data.data(), bytes);
  std::memset(out.data + bytes, 0, capacity - bytes);
  return frame.fd ? CANFD_MTU : CAN_MTU;
}

bool decode_can_frame(const canfd_frame& in, std::size_t bytes, Frame& out) noexcept {
  const bool fd = bytes == CANFD_MTU;
  if (!fd && bytes != CAN_MTU) {
    return false;
  }
  out = Frame{};
  out.error = (in.can_id & CAN_ERR_FLAG) != 0;
  out.remote = !out.error && !fd && (in.can_id & CAN_RTR_FLAG) != 0;
  // An error class has 29 bits: as an extended identifier it is never taken for a drive's 11 bits.
  out.extended = out.error || (in.can_id & CAN_EFF_FLAG) != 0;
  out.id = in.can_id & (out.extended ? CAN_EFF_MASK : CAN_SFF_MASK);
  out.fd = fd;
  out.bit_rate_switch = fd && (in.flags & CANFD_BRS) != 0;
  out.length = std::min<std::uint8_t>(in.len, fd ? CANFD_MAX_DLEN : CAN_MAX_DLEN);
  if (!out.remote) {
    std::memcpy(out.data.data(), in.data, out.length);
  }
  return true;
}

}  // namespace geodesic::drivers
