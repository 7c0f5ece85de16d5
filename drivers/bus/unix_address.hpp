// Addresses of unix sockets: a path, or an abstract name of any length. No sockets.
#pragma once

#include <sys/socket.h>
#include <sys/un.h>

#include <optional>
#include <string>
#include <string_view>

namespace geodesic::drivers {

/// Not real-time.
class UnixAddress {
 public:
  /// A name in the abstract name space of the network namespace; a long one is hashed to fit.
  static UnixAddress abstract(const std::string& name);
  /// A file. @return nothing if the path is empty or too long for a socket (107 bytes).
  static std::optional<UnixAddress> path(const std::string& path);

  const sockaddr* get() const noexcept { return reinterpret_cast<const sockaddr*>(&address_); }
  socklen_t size() const noexcept { return size_; }

 private:
  UnixAddress() = default;
  sockaddr_un address_{};
  socklen_t size_ = 0;
};

/// "unix:PATH" names a socket bus; anything else a CAN interface.
inline constexpr std::string_view kSocketBusPrefix = "unix:";
bool is_socket_bus(std::string_view interface);
/// PATH of "unix:PATH"; a bare path as it is.
std::string socket_bus_path(std::string_view interface);

}  // namespace geodesic::drivers
