// The right to command a bus, held by one process of a host (network namespace) at a time. It goes
// with the process, however that ends. It cannot see other hosts on the wire: those are noticed as
// foreign commanders.
#pragma once

#include <string>

#include "drivers/bus/descriptor.hpp"

namespace geodesic::drivers {

class BusLock {
 public:
  /// Not real-time.
  /// @param interface  as in BusOptions: "can0" or "unix:PATH"
  /// @throws BusError naming the process that holds it.
  explicit BusLock(const std::string& interface);

 private:
  Descriptor socket_;
};

}  // namespace geodesic::drivers
