// What an error frame of the kernel says of the CAN controller. No sockets.
#include "drivers/bus/error_frame.hpp"

#include <linux/can/error.h>

namespace geodesic::drivers {

bool apply_error_frame(const Frame& frame, control::BusState& state) noexcept {
  if ((frame.id & CAN_ERR_CRTL) != 0) {
    const std::uint8_t status = frame.data[1];
    constexpr int kPassive = CAN_ERR_CRTL_RX_PASSIVE | CAN_ERR_CRTL_TX_PASSIVE;
    constexpr int kBetter = CAN_ERR_CRTL_RX_WARNING | CAN_ERR_CRTL_TX_WARNING | CAN_ERR_CRTL_ACTIVE;
    if ((status & kPassive) != 0) {
      state.error_passive = true;
    } else if ((status & kBetter) != 0) {
      state.error_passive = false;
    }
  }
  if ((frame.id & CAN_ERR_BUSOFF) != 0) {
    state.bus_off = true;
  }
  const bool restarted = (frame.id & CAN_ERR_RESTARTED) != 0;
  if (restarted) {
    state.bus_off = false;
    state.error_passive = false;
  }
  return restarted;
}

}  // namespace geodesic::drivers
