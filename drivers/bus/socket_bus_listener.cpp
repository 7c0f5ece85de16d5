// The file through which the socket bus is reached: made, guarded against a second hub, removed.
#include "drivers/bus/socket_bus_listener.hpp"

#include <fmt/format.h>
#include <sys/file.h>
#include <sys/socket.h>
#include <sys/stat.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "drivers/bus/bus.hpp"
#include "drivers/bus/socket_bus_hub.hpp"
#include "drivers/bus/unix_address.hpp"

namespace geodesic::drivers {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void refuse(const std::string& path, const std::string& found, int error,
                         const std::string& fix) {
  const std::string reason = error != 0 ? fmt::format(" ({})", std::strerror(error)) : "";
  throw BusError(
      fmt::format("cannot serve a socket bus at {}: {}{}; fix: {}", path, found, reason, fix),
      error);
}

// Two hubs that start at once look at the same stale file; the folder's lock makes one wait.
Descriptor lock_folder(const fs::path& folder) {
  Descriptor descriptor(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (descriptor.valid()) {
    ::flock(descriptor.get(), LOCK_EX);
  }
  return descriptor;
}

void make_way(const std::string& path) {
  struct stat status {};
  if (::lstat(path.c_str(), &status) != 0) {
    return;
  }
  if (!S_ISSOCK(status.st_mode)) {
    refuse(path, "the path exists and is not a socket", 0, "choose another path");
  }
  if (socket_bus_served(path)) {
    refuse(path, "another hub serves it already", EADDRINUSE,
           "use that one, stop it, or choose another path");
  }
  ::unlink(path.c_str());
}

}  // namespace

SocketBusListener::SocketBusListener(const std::string& path)
    : path_(path), socket_(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_NONBLOCK | SOCK_CLOEXEC, 0)) {
  const auto address = UnixAddress::path(path);
  if (!address) {
    refuse(path, "the path of a socket has 1 to 107 bytes", ENAMETOOLONG, "choose a shorter one");
  }
  const fs::path parent = fs::path(path).parent_path();
  const fs::path folder = parent.empty() ? fs::path(".") : parent;
  std::error_code ignored;
  if (!fs::is_directory(folder, ignored)) {
    refuse(path, fmt::format("the folder {} does not exist", folder.string()), ENOENT,
           fmt::format("mkdir -p {}", folder.string()));
  }
  const Descriptor lock = lock_folder(folder);
  make_way(path);
  if (::bind(socket_.get(), address->get(), address->size()) != 0 ||
      ::listen(socket_.get(), SOMAXCONN) != 0) {
    refuse(path, "bind failed", errno, "choose a folder this user may write to");
  }
  struct stat status {};
  if (::stat(path.c_str(), &status) == 0) {
    inode_ = status.st_ino;
  }
}

SocketBusListener::~SocketBusListener() {
  struct stat status {};
  // Somebody may have put another file in its place meanwhile: that one is not ours to remove.
  if (::stat(path_.c_str(), &status) == 0 && status.st_ino == inode_) {
    ::unlink(path_.c_str());
  }
}

Descriptor SocketBusListener::accept() {
  return Descriptor(::accept4(socket_.get(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
}

bool socket_bus_served(const std::string& interface) {
  const auto address = UnixAddress::path(socket_bus_path(interface));
  if (!address) {
    return false;
  }
  const Descriptor probe(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  return probe.valid() && ::connect(probe.get(), address->get(), address->size()) == 0;
}

}  // namespace geodesic::drivers
