// The file through which the socket bus is reached: made, guarded against a second hub, removed. It
// reads and writes no frames.
#pragma once

#include <sys/types.h>

#include <optional>
#include <string>

#include "drivers/bus/bus_lock.hpp"
#include "drivers/bus/descriptor.hpp"

namespace geodesic::drivers {

/// Not real-time.
class SocketBusListener {
 public:
  /// @throws BusError.
  explicit SocketBusListener(const std::string& path);
  ~SocketBusListener();
  SocketBusListener(const SocketBusListener&) = delete;
  SocketBusListener& operator=(const SocketBusListener&) = delete;

  int descriptor() const noexcept { return socket_.get(); }
  /// The next client that waits; an invalid descriptor if there is none.
  Descriptor accept();

 private:
  std::string path_;
  Descriptor socket_;
  ino_t inode_ = 0;
};

}  // namespace geodesic::drivers
