// Addresses of unix sockets. No sockets.
#include "drivers/bus/unix_address.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace geodesic::drivers {
namespace {

constexpr std::size_t kCapacity = sizeof(sockaddr_un::sun_path);

// FNV-1a, 64 bits: tells long names apart; no secret depends on it.
std::uint64_t hash(std::string_view text) {
  std::uint64_t value = 0xcbf29ce484222325U;
  for (const char c : text) {
    value = (value ^ static_cast<unsigned char>(c)) * 0x100000001b3U;
  }
  return value;
}

socklen_t address_size(std::size_t name_bytes) {
  return static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + name_bytes);
}

}  // namespace

UnixAddress UnixAddress::abstract(const std::string& name) {
  std::string fitting = name;
  if (name.size() > kCapacity - 1) {
    fitting = fmt::format("{}#{:016x}", name.substr(0, kCapacity - 20), hash(name));
  }
  UnixAddress result;
  result.address_.sun_family = AF_UNIX;
  // sun_path[0] stays zero: that is what makes the name abstract.
  std::copy(fitting.begin(), fitting.end(), result.address_.sun_path + 1);
  result.size_ = address_size(fitting.size() + 1);
  return result;
}

std::optional<UnixAddress> UnixAddress::path(const std::string& path) {
  if (path.empty() || path.size() > kCapacity - 1) {
    return std::nullopt;
  }
  UnixAddress result;
  result.address_.sun_family = AF_UNIX;
  std::copy(path.begin(), path.end(), result.address_.sun_path);
  result.size_ = address_size(path.size() + 1);
  return result;
}

bool is_socket_bus(std::string_view interface) {
  return interface.starts_with(kSocketBusPrefix);
}

std::string socket_bus_path(std::string_view interface) {
  if (is_socket_bus(interface)) {
    interface.remove_prefix(kSocketBusPrefix.size());
  }
  return std::string(interface);
}

}  // namespace geodesic::drivers
