// Opening a raw CAN socket on an interface that is up, and saying in plain words why it cannot be.
// Not real-time; the interface is link_setup's business, sending and receiving are socketcan_bus's.
#pragma once

#include "drivers/bus/bus.hpp"
#include "drivers/bus/can_link.hpp"
#include "drivers/bus/descriptor.hpp"

namespace geodesic::drivers {

struct CanSocket {
  Descriptor descriptor;  ///< non-blocking, bound, filtered, stamped
  /// The interface gives our own frames back once they have left (every real controller; vcan only
  /// if loaded with echo=1). Without it the kernel's copy comes at once and confirms nothing.
  bool echoes = false;
};

/// @throws BusError with the command that helps.
CanSocket open_can_socket(const BusOptions& options, const CanLink& link);

}  // namespace geodesic::drivers
