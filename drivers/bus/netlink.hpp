// Messages of the kernel's netlink as bytes: written, read, and carried over a socket. Knows
// nothing of CAN (can_link.hpp does). Not real-time.
#pragma once

#include <linux/netlink.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/bus/descriptor.hpp"

namespace geodesic::drivers {

/// Builds one message: header, fixed part, attributes, nests of attributes. Integers are in the
/// host's order, parts begin at multiples of four bytes, a length does not count what pads its end.
/// Source: linux/netlink.h, RFC 3549 section 2.3.
class NetlinkWriter {
 public:
  NetlinkWriter(std::uint16_t type, std::uint16_t flags, std::uint32_t sequence);

  template <typename T>
  void fixed(const T& part) {
    append(&part, sizeof part);
  }
  template <typename T>
  void attribute(std::uint16_t type, const T& value) {
    attribute_bytes(type, &value, sizeof value);
  }
  void text(std::uint16_t type, std::string_view value);  ///< with the NUL that ends it
  /// @return to be handed to end_nest() after the attributes within.
  std::size_t begin_nest(std::uint16_t type);
  void end_nest(std::size_t begin);

  /// The finished message; lives until the next call that writes.
  std::span<const std::byte> finish();

 private:
  void append(const void* data, std::size_t bytes);
  void attribute_bytes(std::uint16_t type, const void* data, std::size_t bytes);

  std::vector<std::byte> bytes_;
};

/// One attribute as found.
struct NetlinkAttribute {
  std::uint16_t type = 0;  ///< without the flags in its two top bits
  std::span<const std::byte> data;

  /// The value, or nothing where fewer bytes are there. More are ignored: newer kernels append.
  template <typename T>
  std::optional<T> value() const {
    if (data.size() < sizeof(T)) {
      return std::nullopt;
    }
    T result;
    std::memcpy(&result, data.data(), sizeof result);
    return result;
  }
  std::string text() const;  ///< up to the first NUL
};

/// All attributes in `bytes`, as far as their lengths make sense; survives any bytes.
std::vector<NetlinkAttribute> netlink_attributes(std::span<const std::byte> bytes);

/// One message as found; `body` is what follows the header.
struct NetlinkMessage {
  nlmsghdr header{};
  std::span<const std::byte> body;
};

/// All messages of one datagram, as far as their lengths make sense; survives any bytes.
std::vector<NetlinkMessage> netlink_messages(std::span<const std::byte> datagram);

/// What an NLMSG_ERROR message says; error 0 is an acknowledgement.
struct NetlinkVerdict {
  int error = 0;       ///< errno
  std::string reason;  ///< the kernel's own words, where it has some
};
NetlinkVerdict netlink_verdict(const NetlinkMessage& message);

/// A conversation with the kernel about its interfaces (NETLINK_ROUTE).
class RouteSocket {
 public:
  RouteSocket();

  std::uint32_t next_sequence() noexcept { return ++sequence_; }

  /// Sends a message (its header must carry next_sequence()) and reads until its end or verdict.
  /// @param each  called with every message that answers it
  /// @return error != 0: what went wrong, or the kernel's refusal.
  NetlinkVerdict ask(std::span<const std::byte> message,
                     const std::function<void(const NetlinkMessage&)>& each = {});

 private:
  Descriptor socket_;
  int open_error_ = 0;
  std::uint32_t sequence_ = 0;
};

}  // namespace geodesic::drivers
