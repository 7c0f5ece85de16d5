// From a bus's name to the class that carries it. No sockets.
#include "drivers/bus/bus.hpp"
#include "drivers/bus/socket_bus.hpp"
#include "drivers/bus/socketcan_bus.hpp"
#include "drivers/bus/unix_address.hpp"

namespace geodesic::drivers {

std::unique_ptr<Bus> open_bus(const BusOptions& options) {
  if (is_socket_bus(options.interface)) {
    return open_socket_bus(options);
  }
  return open_socketcan_bus(options);
}

}  // namespace geodesic::drivers
