// What a service manager (systemd, Type=notify) is told: ready, alive, stopping. Does nothing where
// none is listening. Not for the real-time thread.
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <string_view>

#include "drivers/bus/descriptor.hpp"
#include "drivers/bus/unix_address.hpp"

namespace geodesic::tools {

class ServiceManager {
 public:
  using Clock = std::chrono::steady_clock;

  /// @param notify_socket   $NOTIFY_SOCKET: a path, or "@NAME" for an abstract one; empty: nobody
  /// @param watchdog_usec   $WATCHDOG_USEC: it restarts us if we are silent for so long; empty:
  /// never
  ServiceManager(const std::string& notify_socket, const std::string& watchdog_usec);
  /// As this process' environment says.
  static ServiceManager current();

  void ready(const std::string& status) { tell("READY=1\nSTATUS=" + status); }
  void status(const std::string& status) { tell("STATUS=" + status); }
  void stopping() { tell("STOPPING=1"); }
  /// To be called often while all is well; speaks as often as the watchdog needs.
  void alive(Clock::time_point now);

 private:
  void tell(std::string_view text);

  std::optional<drivers::UnixAddress> address_;
  std::chrono::microseconds interval_{0};  ///< half of what the watchdog allows; 0: there is none
  Clock::time_point last_alive_{};
  drivers::Descriptor socket_;
};

}  // namespace geodesic::tools
