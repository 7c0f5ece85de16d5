// Opens, sends, reads; nothing is kept from one batch to the next.
#include "tests/bench/bare_bus.hpp"

#include <linux/can/raw.h>
#include <net/if.h>
#include <sys/un.h>

#include <algorithm>
#include <cerrno>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace geodesic::bench {
namespace {

using drivers::WireFrameHeader;
using drivers::WireMessageHeader;

void open_can(BareBus& bus, const std::string& name, const BareBusOptions& options) {
  sockaddr_can address{};
  address.can_family = AF_CAN;
  address.can_ifindex = static_cast<int>(::if_nametoindex(name.c_str()));
  if (address.can_ifindex == 0) {
    fail(
        "%s: no such interface; `ip link add dev %s type vcan && ip link set %s mtu 72 up` makes "
        "a virtual one",
        name.c_str(), name.c_str(), name.c_str());
  }
  bus.socket = ::socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC, CAN_RAW);
  std::vector<can_filter> filters;
  for (const std::uint32_t id : options.let_in) {
    const std::uint32_t wanted = options.extended ? id | CAN_EFF_FLAG : id;
    filters.push_back({.can_id = wanted, .can_mask = CAN_EFF_FLAG | CAN_EFF_MASK});
  }
  const int yes = 1;
  const auto filter_bytes = static_cast<socklen_t>(filters.size() * sizeof(can_filter));
  if (bus.socket < 0 ||
      (options.fd &&
       ::setsockopt(bus.socket, SOL_CAN_RAW, CAN_RAW_FD_FRAMES, &yes, sizeof yes) != 0) ||
      ::setsockopt(bus.socket, SOL_CAN_RAW, CAN_RAW_FILTER, filters.data(), filter_bytes) != 0 ||
      ::bind(bus.socket, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    fail("%s: cannot open a CAN socket: %s; is the kernel's CAN there (`modprobe can_raw`)?",
         name.c_str(), std::strerror(errno));
  }
}

void open_socket_bus(BareBus& bus, const std::string& name) {
  const std::string path = name.substr(std::strlen("unix:"));
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.empty() || path.size() >= sizeof address.sun_path) {
    fail("%s: the path of a socket bus has 1 to 107 bytes", name.c_str());
  }
  std::copy(path.begin(), path.end(), address.sun_path);
  bus.socket = ::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
  if (bus.socket < 0 ||
      ::connect(bus.socket, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    fail("%s: nobody serves this socket bus (%s); start one first: `geodesic bus %s`", name.c_str(),
         std::strerror(errno), name.c_str());
  }
}

/// Takes one message of the socket bus apart, behind in[n). @return the new n.
std::size_t unpack(BareBus& bus, const std::byte* at, std::size_t bytes, std::size_t n) noexcept {
  const std::byte* const end = at + bytes;
  at += sizeof(WireMessageHeader);
  WireFrameHeader item;
  while (at + sizeof item <= end && n < bus.in.size()) {
    std::memcpy(&item, at, sizeof item);
    at += sizeof item;
    if (item.length > sizeof bus.in[n].data || at + item.length > end) {
      break;
    }
    bus.in[n].can_id = item.id;
    bus.in[n].len = item.length;
    std::memcpy(bus.in[n].data, at, item.length);
    at += item.length;
    ++n;
  }
  return n;
}

}  // namespace

void fail(const char* format, ...) {
  std::va_list arguments;
  va_start(arguments, format);
  std::fputs("bare_exchange: ", stderr);
  std::vfprintf(stderr, format, arguments);
  std::fputc('\n', stderr);
  va_end(arguments);
  std::exit(1);
}

std::unique_ptr<BareBus> open_bare_bus(const std::string& name, const BareBusOptions& options) {
  auto opened = std::make_unique<BareBus>();
  BareBus& bus = *opened;
  bus.on_can = !name.starts_with("unix:");
  if (bus.on_can) {
    open_can(bus, name, options);
  } else {
    open_socket_bus(bus, name);
  }
  const std::size_t mtu = options.fd ? CANFD_MTU : CAN_MTU;
  for (std::size_t i = 0; i < kMaxFrames; ++i) {
    bus.out_vector[i] = {.iov_base = &bus.out[i], .iov_len = mtu};
    bus.out_message[i].msg_hdr.msg_iov = &bus.out_vector[i];
    bus.out_message[i].msg_hdr.msg_iovlen = 1;
    bus.in_vector[i] = {.iov_base = &bus.in[i], .iov_len = sizeof(canfd_frame)};
    if (!bus.on_can && i < kMessages) {
      bus.in_vector[i] = {.iov_base = bus.in_bytes[i].data(), .iov_len = bus.in_bytes[i].size()};
    }
    bus.in_message[i].msg_hdr.msg_iov = &bus.in_vector[i];
    bus.in_message[i].msg_hdr.msg_iovlen = 1;
  }
  return opened;
}

bool send_batch(BareBus& bus, std::size_t first, std::size_t n) noexcept {
  if (bus.on_can) {
    return ::sendmmsg(bus.socket, &bus.out_message[first], static_cast<unsigned>(n),
                      MSG_DONTWAIT) == static_cast<int>(n);
  }
  WireMessageHeader header;
  header.frames = static_cast<std::uint16_t>(n);
  std::byte* at = bus.out_bytes.data();
  std::memcpy(at, &header, sizeof header);
  at += sizeof header;
  for (const canfd_frame* frame = &bus.out[first]; frame != &bus.out[first] + n; ++frame) {
    const bool extended = (frame->can_id & CAN_EFF_FLAG) != 0;
    WireFrameHeader item;
    item.id = frame->can_id & CAN_EFF_MASK;
    item.length = frame->len;
    item.flags = static_cast<std::uint8_t>(
        (extended ? WireFrameHeader::kExtended : 0) |
        (frame->flags != 0 ? WireFrameHeader::kFd | WireFrameHeader::kBitRateSwitch : 0));
    std::memcpy(at, &item, sizeof item);
    std::memcpy(at + sizeof item, frame->data, frame->len);
    at += sizeof item + frame->len;
  }
  const auto bytes = static_cast<std::size_t>(at - bus.out_bytes.data());
  return ::send(bus.socket, bus.out_bytes.data(), bytes, MSG_DONTWAIT | MSG_NOSIGNAL) > 0;
}

std::size_t read_batch(BareBus& bus) noexcept {
  const unsigned room = bus.on_can ? kMaxFrames : kMessages;
  const int got = ::recvmmsg(bus.socket, bus.in_message.data(), room, MSG_DONTWAIT, nullptr);
  if (got < 0) {
    if (errno != EAGAIN && errno != EINTR) {
      fail("the bus went down: %s", std::strerror(errno));
    }
    return 0;
  }
  const auto messages = static_cast<std::size_t>(got);
  if (bus.on_can) {
    for (std::size_t i = 0; i < messages; ++i) {
      bus.in[i].can_id &= CAN_EFF_MASK;
    }
    return messages;
  }
  std::size_t n = 0;
  for (std::size_t i = 0; i < messages; ++i) {
    const std::size_t bytes = bus.in_message[i].msg_len;
    if (bytes < sizeof(WireMessageHeader)) {
      fail("the socket bus has closed");
    }
    n = unpack(bus, bus.in_bytes[i].data(), bytes, n);
  }
  return n;
}

}  // namespace geodesic::bench
