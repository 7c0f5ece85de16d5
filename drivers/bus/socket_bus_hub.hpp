// The wire of the socket bus: takes frames from its clients and gives each to all others, in the
// order arbitration would, optionally at the speed of a real bus. Not real-time; knows no drives.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>

#include "drivers/bus/descriptor.hpp"

namespace geodesic::drivers {

struct SocketBusHubOptions {
  std::string path;                        ///< "unix:PATH" or PATH
  bool paced = false;                      ///< frames take the time bit timing gives them
  std::int64_t bit_rate = 1'000'000;       ///< [bit/s], counts where paced
  std::int64_t data_bit_rate = 5'000'000;  ///< [bit/s], counts where paced
};

/// Since the hub began.
struct SocketBusHubCounters {
  std::uint64_t carried = 0;  ///< frames that went over the wire
  std::uint64_t dropped = 0;  ///< copies that a client did not take in time
  std::size_t clients = 0;    ///< connected now
};

/// Serves PATH in a thread of its own from construction to destruction.
class SocketBusHub {
 public:
  /// Replaces the socket file of a hub that died. @throws BusError if PATH is served already, is
  /// something else than a socket, or cannot be made.
  explicit SocketBusHub(const SocketBusHubOptions& options);
  /// Clients see the bus go down; the socket file is removed.
  ~SocketBusHub();
  SocketBusHub(const SocketBusHub&) = delete;
  SocketBusHub& operator=(const SocketBusHub&) = delete;

  /// Any thread.
  SocketBusHubCounters counters() const noexcept;

  /// Holds the wire still, as a jammed bus would be: nothing leaves until it is released. For tests
  /// and fault injection. Any thread.
  void hold(bool held) noexcept;

 private:
  class Wire;
  std::unique_ptr<Wire> wire_;
  Descriptor wake_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

/// Somebody serves the socket bus "unix:PATH" (or PATH). Not real-time.
bool socket_bus_served(const std::string& interface);

}  // namespace geodesic::drivers
