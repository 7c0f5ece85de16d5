// Opening a raw CAN socket and saying in plain words why it cannot be.
#include "drivers/bus/socketcan_open.hpp"

#include <fmt/format.h>
#include <ifaddrs.h>
#include <linux/can.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <net/if_arp.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace geodesic::drivers {
namespace {

constexpr unsigned kEchoFlag =
    0x40000;  // IFF_ECHO of linux/if.h, which cannot be had beside net/if.h
// The kernel refuses more (CAN_RAW_FILTER_MAX); longer lists are filtered by Traffic alone.
constexpr std::size_t kMaxKernelFilters = 512;
// Room for what arrives while a monitor is not scheduled: about 0.3 s of a full bus.
constexpr int kReceiveBytes = 1 << 20;

bool is_virtual(const std::string& interface) {
  return interface.starts_with("vcan") || interface.starts_with("vxcan");
}

std::string bring_up_command(const BusOptions& options) {
  const std::string& name = options.interface;
  if (is_virtual(name)) {
    return fmt::format("ip link set {}{} up", name, options.fd ? " mtu 72" : "");
  }
  std::string command =
      fmt::format("ip link set {} up type can bitrate {}", name, options.bit_rate);
  if (options.fd) {
    command += fmt::format(" dbitrate {} fd on", options.data_bit_rate);
  }
  return command;
}

std::string create_command(const BusOptions& options) {
  const std::string& name = options.interface;
  if (!is_virtual(name)) {
    return "ip -brief link show type can   # lists the CAN interfaces there are; is the adapter "
           "plugged in?";
  }
  return fmt::format("ip link add dev {} type vcan && {}", name, bring_up_command(options));
}

[[noreturn]] void refuse(const BusOptions& options, const std::string& found, int error,
                         const std::string& fix) {
  const std::string reason = error != 0 ? fmt::format(" ({})", std::strerror(error)) : "";
  const std::string label =
      options.name.empty() || options.name == options.interface ? "" : options.name + ": ";
  throw BusError(fmt::format("{}{}{}; fix: {}", label, found, reason, fix), error);
}

Descriptor make_socket(const BusOptions& options) {
  Descriptor descriptor(::socket(PF_CAN, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, CAN_RAW));
  if (!descriptor.valid()) {
    const int error = errno;
    const bool missing = error == EAFNOSUPPORT || error == EPROTONOSUPPORT;
    refuse(options, fmt::format("cannot open a raw CAN socket for {}", options.interface), error,
           missing ? "modprobe can_raw   # or, on a kernel without CAN, a socket bus: unix:PATH"
                   : "see errno(3)");
  }
  return descriptor;
}

void require_can_interface(const BusOptions& options, int fd, ifreq& request) {
  const std::string& name = options.interface;
  if (name.empty() || name.size() >= IFNAMSIZ) {
    refuse(options, fmt::format("\"{}\" is no interface name (1 to 15 characters)", name), 0,
           "name a CAN interface (can0, vcan0) or a socket bus (unix:PATH)");
  }
  std::copy(name.begin(), name.end(), request.ifr_name);
  if (::ioctl(fd, SIOCGIFHWADDR, &request) != 0) {
    refuse(options, fmt::format("interface {} does not exist", name), errno,
           create_command(options));
  }
  if (request.ifr_hwaddr.sa_family != ARPHRD_CAN) {
    refuse(options, fmt::format("interface {} is not a CAN interface", name), 0,
           "ip -brief link show type can   # lists those there are");
  }
  if (::ioctl(fd, SIOCGIFMTU, &request) == 0 && options.fd &&
      request.ifr_mtu < static_cast<int>(CANFD_MTU)) {
    const std::string set =
        is_virtual(name) ? fmt::format("ip link set {} mtu 72", name) : bring_up_command(options);
    refuse(options,
           fmt::format("interface {} carries classic CAN only (mtu {}), but CAN FD (mtu 72) is "
                       "configured",
                       name, request.ifr_mtu),
           0,
           fmt::format("ip link set {} down && {}{}", name, set,
                       is_virtual(name) ? fmt::format(" && ip link set {} up", name) : ""));
  }
  if (::ioctl(fd, SIOCGIFFLAGS, &request) == 0 && (request.ifr_flags & IFF_UP) == 0) {
    refuse(options, fmt::format("interface {} is down", name), 0, bring_up_command(options));
  }
}

bool interface_echoes(const std::string& interface) {
  ifaddrs* list = nullptr;
  if (::getifaddrs(&list) != 0) {
    return false;
  }
  bool echoes = false;
  for (const ifaddrs* entry = list; entry != nullptr; entry = entry->ifa_next) {
    if (interface == entry->ifa_name && (entry->ifa_flags & kEchoFlag) != 0) {
      echoes = true;
    }
  }
  ::freeifaddrs(list);
  return echoes;
}

void set_option(const BusOptions& options, int fd, int level, int option, const char* option_name,
                const void* value, std::size_t size) {
  if (::setsockopt(fd, level, option, value, static_cast<socklen_t>(size)) != 0) {
    refuse(options, fmt::format("{}: cannot set {}", options.interface, option_name), errno,
           "a kernel of 4.x or newer with CAN_RAW");
  }
}

void set_filters(const BusOptions& options, int fd) {
  const std::size_t count = options.receive.size() + options.transmit.size();
  if (options.receive.empty() || count > kMaxKernelFilters) {
    return;
  }
  std::vector<can_filter> filters;
  filters.reserve(count);
  for (const auto* list : {&options.receive, &options.transmit}) {
    for (const IdFilter& id : *list) {
      filters.push_back({.can_id = id.id | (id.extended ? CAN_EFF_FLAG : 0U),
                         .can_mask = CAN_EFF_FLAG | CAN_RTR_FLAG |
                                     (id.mask & (id.extended ? CAN_EFF_MASK : CAN_SFF_MASK))});
    }
  }
  set_option(options, fd, SOL_CAN_RAW, CAN_RAW_FILTER, "CAN_RAW_FILTER", filters.data(),
             filters.size() * sizeof(can_filter));
}

}  // namespace

CanSocket open_can_socket(const BusOptions& options) {
  CanSocket result;
  result.descriptor = make_socket(options);
  const int fd = result.descriptor.get();
  ifreq request{};
  require_can_interface(options, fd, request);
  result.echoes = interface_echoes(options.interface);

  const int on = 1;
  set_filters(options, fd);
  const can_err_mask_t errors = CAN_ERR_MASK;
  set_option(options, fd, SOL_CAN_RAW, CAN_RAW_ERR_FILTER, "CAN_RAW_ERR_FILTER", &errors,
             sizeof errors);
  // Always: a monitor sees FD frames whatever it was told, and Traffic leaves them out for others.
  set_option(options, fd, SOL_CAN_RAW, CAN_RAW_FD_FRAMES, "CAN_RAW_FD_FRAMES", &on, sizeof on);
  if (!options.transmit.empty() && result.echoes) {
    set_option(options, fd, SOL_CAN_RAW, CAN_RAW_RECV_OWN_MSGS, "CAN_RAW_RECV_OWN_MSGS", &on,
               sizeof on);
  }
  set_option(options, fd, SOL_SOCKET, SO_TIMESTAMPNS, "SO_TIMESTAMPNS", &on, sizeof on);
  set_option(options, fd, SOL_SOCKET, SO_RXQ_OVFL, "SO_RXQ_OVFL", &on, sizeof on);
  set_option(options, fd, SOL_SOCKET, SO_RCVBUF, "SO_RCVBUF", &kReceiveBytes, sizeof kReceiveBytes);

  sockaddr_can address{};
  address.can_family = AF_CAN;
  address.can_ifindex = static_cast<int>(::if_nametoindex(options.interface.c_str()));
  if (::bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    refuse(options, fmt::format("cannot bind a CAN socket to {}", options.interface), errno,
           bring_up_command(options));
  }
  return result;
}

}  // namespace geodesic::drivers
