// Opening a raw CAN socket on an interface that is up, and saying in plain words why it cannot be.
#include "drivers/bus/socketcan_open.hpp"

#include <fmt/format.h>
#include <linux/can.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>

#include "drivers/bus/link_plan.hpp"
#include "drivers/bus/link_setup.hpp"

namespace geodesic::drivers {
namespace {

// The kernel refuses more (CAN_RAW_FILTER_MAX); longer lists are filtered by Traffic alone.
constexpr std::size_t kMaxKernelFilters = 512;
// Room for what arrives while a monitor is not scheduled: about 0.3 s of a full bus.
constexpr int kReceiveBytes = 1 << 20;

Descriptor make_socket(const BusOptions& options) {
  Descriptor descriptor(::socket(PF_CAN, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, CAN_RAW));
  if (!descriptor.valid()) {
    const int error = errno;
    const bool missing = error == EAFNOSUPPORT || error == EPROTONOSUPPORT;
    refuse_bus(options, fmt::format("cannot open a raw CAN socket for {}", options.interface),
               error,
               missing ? "modprobe can_raw   # or, on a kernel without CAN, a socket bus: unix:PATH"
                       : "see errno(3)");
  }
  return descriptor;
}

void set_option(const BusOptions& options, int fd, int level, int option, const char* option_name,
                const void* value, std::size_t size) {
  if (::setsockopt(fd, level, option, value, static_cast<socklen_t>(size)) != 0) {
    refuse_bus(options, fmt::format("{}: cannot set {}", options.interface, option_name), errno,
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
      filters.push_back(
          {.can_id = id.id | (id.extended ? CAN_EFF_FLAG : 0U),
           // Remote frames too: our own are confirmed like all others.
           .can_mask = CAN_EFF_FLAG | (id.mask & (id.extended ? CAN_EFF_MASK : CAN_SFF_MASK))});
    }
  }
  set_option(options, fd, SOL_CAN_RAW, CAN_RAW_FILTER, "CAN_RAW_FILTER", filters.data(),
             filters.size() * sizeof(can_filter));
}

}  // namespace

CanSocket open_can_socket(const BusOptions& options, const CanLink& link) {
  CanSocket result;
  result.descriptor = make_socket(options);
  result.echoes = link.echoes;
  const int fd = result.descriptor.get();
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
  address.can_ifindex = link.index;
  if (::bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    refuse_bus(options, fmt::format("cannot bind a CAN socket to {}", link.name), errno,
               link_command(link.name, options, &link));
  }
  return result;
}

}  // namespace geodesic::drivers
