// The right to command a bus: an abstract unix socket named after it, which the kernel gives to one
// and takes back when that one ends.
#include "drivers/bus/bus_lock.hpp"

#include <fmt/format.h>
#include <sys/socket.h>

#include <cerrno>
#include <cstring>
#include <fstream>

#include "drivers/bus/bus.hpp"
#include "drivers/bus/unix_address.hpp"

namespace geodesic::drivers {
namespace {

// "process 4711 (geodesicd)", from the credentials of whoever listens on `address`.
std::string holder(const UnixAddress& address) {
  const Descriptor probe(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  ucred credentials{};
  socklen_t size = sizeof credentials;
  if (!probe.valid() || ::connect(probe.get(), address.get(), address.size()) != 0 ||
      ::getsockopt(probe.get(), SOL_SOCKET, SO_PEERCRED, &credentials, &size) != 0 ||
      credentials.pid <= 0) {
    return "another process";
  }
  std::string command;
  std::getline(std::ifstream(fmt::format("/proc/{}/comm", credentials.pid)), command);
  return fmt::format("process {} ({})", credentials.pid, command.empty() ? "?" : command);
}

}  // namespace

BusLock::BusLock(const std::string& interface)
    : socket_(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
  const UnixAddress address = UnixAddress::abstract("geodesic-bus-" + interface);
  if (!socket_.valid() || ::bind(socket_.get(), address.get(), address.size()) != 0 ||
      ::listen(socket_.get(), 1) != 0) {
    const int error = errno;
    if (error == EADDRINUSE) {
      throw BusError(fmt::format("bus {} is commanded already by {}; a bus has one commander: stop "
                                 "that one first",
                                 interface, holder(address)),
                     error);
    }
    throw BusError(fmt::format("cannot lock bus {} against a second commander: {}", interface,
                               std::strerror(error)),
                   error);
  }
}

}  // namespace geodesic::drivers
