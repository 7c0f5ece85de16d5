// A frame as candump writes it.
#include "drivers/bus/frame_text.hpp"

#include <fmt/format.h>
#include <linux/can.h>

namespace geodesic::drivers {

std::string candump_text(const Frame& frame) {
  std::string text = frame.error      ? fmt::format("{:08X}", frame.id | CAN_ERR_FLAG)
                     : frame.extended ? fmt::format("{:08X}", frame.id)
                                      : fmt::format("{:03X}", frame.id);
  text += frame.fd ? fmt::format("##{:X}", frame.bit_rate_switch ? CANFD_BRS : 0) : "#";
  if (frame.remote) {
    return text + (frame.length > 0 ? fmt::format("R{}", frame.length) : "R");
  }
  for (const std::uint8_t byte : frame.payload()) {
    text += fmt::format("{:02X}", byte);
  }
  return text;
}

}  // namespace geodesic::drivers
