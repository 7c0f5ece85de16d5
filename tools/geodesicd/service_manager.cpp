// The sd_notify protocol: datagrams of VARIABLE=VALUE lines, see sd_notify(3).
#include "tools/geodesicd/service_manager.hpp"

#include <sys/socket.h>

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <cstdlib>

namespace geodesic::tools {
namespace {

std::string environment(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? std::string() : std::string(value);
}

}  // namespace

ServiceManager::ServiceManager(const std::string& notify_socket, const std::string& watchdog_usec) {
  address_ = notify_socket.starts_with('@')
                 ? drivers::UnixAddress::abstract(notify_socket.substr(1))
                 : drivers::UnixAddress::path(notify_socket);
  if (!address_) {
    return;
  }
  socket_ = drivers::Descriptor(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  std::int64_t allowed_us = 0;
  std::from_chars(watchdog_usec.data(), watchdog_usec.data() + watchdog_usec.size(), allowed_us);
  interval_ = std::chrono::microseconds(std::max<std::int64_t>(0, allowed_us / 2));
}

ServiceManager ServiceManager::current() {
  return {environment("NOTIFY_SOCKET"), environment("WATCHDOG_USEC")};
}

void ServiceManager::alive(Clock::time_point now) {
  if (interval_.count() > 0 && now - last_alive_ >= interval_) {
    last_alive_ = now;
    tell("WATCHDOG=1");
  }
}

void ServiceManager::tell(std::string_view text) {
  if (!socket_.valid()) {
    return;
  }
  // Nobody listening is nobody's fault.
  (void)::sendto(socket_.get(), text.data(), text.size(), MSG_NOSIGNAL, address_->get(),
                 address_->size());
}

}  // namespace geodesic::tools
