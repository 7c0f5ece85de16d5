// Messages of the kernel's netlink as bytes, and the socket that carries them.
#include "drivers/bus/netlink.hpp"

#include <sys/socket.h>
#include <sys/time.h>

#include <algorithm>
#include <array>
#include <cerrno>

namespace geodesic::drivers {
namespace {

constexpr std::size_t kAlign = 4;
// The kernel answers at once; this only keeps a broken one from holding a thread for ever.
constexpr timeval kPatience{.tv_sec = 2, .tv_usec = 0};

constexpr std::size_t aligned(std::size_t bytes) {
  return (bytes + kAlign - 1) / kAlign * kAlign;
}

void set_length(std::vector<std::byte>& bytes, std::size_t at, std::uint16_t length) {
  std::memcpy(bytes.data() + at, &length, sizeof length);
}

}  // namespace

NetlinkWriter::NetlinkWriter(std::uint16_t type, std::uint16_t flags, std::uint32_t sequence) {
  nlmsghdr header{};
  header.nlmsg_type = type;
  header.nlmsg_flags = flags;
  header.nlmsg_seq = sequence;
  append(&header, sizeof header);
}

void NetlinkWriter::append(const void* data, std::size_t bytes) {
  const std::size_t at = bytes_.size();
  bytes_.resize(at + aligned(bytes));
  std::memcpy(bytes_.data() + at, data, bytes);
}

void NetlinkWriter::attribute_bytes(std::uint16_t type, const void* data, std::size_t bytes) {
  nlattr header{};
  header.nla_len = static_cast<std::uint16_t>(sizeof header + bytes);
  header.nla_type = type;
  append(&header, sizeof header);
  append(data, bytes);
}

void NetlinkWriter::text(std::uint16_t type, std::string_view value) {
  const std::string ended(value);
  attribute_bytes(type, ended.c_str(), ended.size() + 1);
}

std::size_t NetlinkWriter::begin_nest(std::uint16_t type) {
  const std::size_t begin = bytes_.size();
  const nlattr header{.nla_len = 0, .nla_type = type};
  append(&header, sizeof header);
  return begin;
}

void NetlinkWriter::end_nest(std::size_t begin) {
  set_length(bytes_, begin, static_cast<std::uint16_t>(bytes_.size() - begin));
}

std::span<const std::byte> NetlinkWriter::finish() {
  const auto length = static_cast<std::uint32_t>(bytes_.size());
  std::memcpy(bytes_.data() + offsetof(nlmsghdr, nlmsg_len), &length, sizeof length);
  return bytes_;
}

std::string NetlinkAttribute::text() const {
  const auto* const begin = reinterpret_cast<const char*>(data.data());
  return {begin, std::find(begin, begin + data.size(), '\0')};
}

std::vector<NetlinkAttribute> netlink_attributes(std::span<const std::byte> bytes) {
  std::vector<NetlinkAttribute> found;
  nlattr header{};
  while (bytes.size() >= sizeof header) {
    std::memcpy(&header, bytes.data(), sizeof header);
    if (header.nla_len < sizeof header || header.nla_len > bytes.size()) {
      break;
    }
    found.push_back({.type = static_cast<std::uint16_t>(header.nla_type & NLA_TYPE_MASK),
                     .data = bytes.subspan(sizeof header, header.nla_len - sizeof header)});
    bytes = bytes.subspan(std::min(aligned(header.nla_len), bytes.size()));
  }
  return found;
}

std::vector<NetlinkMessage> netlink_messages(std::span<const std::byte> datagram) {
  std::vector<NetlinkMessage> found;
  NetlinkMessage message;
  while (datagram.size() >= sizeof message.header) {
    std::memcpy(&message.header, datagram.data(), sizeof message.header);
    const std::size_t length = message.header.nlmsg_len;
    if (length < sizeof message.header || length > datagram.size()) {
      break;
    }
    message.body = datagram.subspan(sizeof message.header, length - sizeof message.header);
    found.push_back(message);
    datagram = datagram.subspan(std::min(aligned(length), datagram.size()));
  }
  return found;
}

NetlinkVerdict netlink_verdict(const NetlinkMessage& message) {
  NetlinkVerdict verdict;
  nlmsgerr error{};
  if (message.body.size() < sizeof error) {
    return {EBADMSG, {}};
  }
  std::memcpy(&error, message.body.data(), sizeof error);
  verdict.error = -error.error;
  if ((message.header.nlmsg_flags & NLM_F_ACK_TLVS) == 0) {
    return verdict;
  }
  // The request comes back before the kernel's words, whole unless it says that it is capped.
  const bool capped = (message.header.nlmsg_flags & NLM_F_CAPPED) != 0;
  const std::size_t request = capped ? sizeof(nlmsghdr) : error.msg.nlmsg_len;
  const std::size_t skip = sizeof error.error + aligned(request);
  if (skip <= message.body.size()) {
    for (const NetlinkAttribute& attribute : netlink_attributes(message.body.subspan(skip))) {
      if (attribute.type == NLMSGERR_ATTR_MSG) {
        verdict.reason = attribute.text();
      }
    }
  }
  return verdict;
}

RouteSocket::RouteSocket() : socket_(::socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC, NETLINK_ROUTE)) {
  if (!socket_.valid()) {
    open_error_ = errno;
    return;
  }
  const int on = 1;
  // Words of the kernel's are a help, no need: older kernels have none.
  ::setsockopt(socket_.get(), SOL_NETLINK, NETLINK_EXT_ACK, &on, sizeof on);
  ::setsockopt(socket_.get(), SOL_SOCKET, SO_RCVTIMEO, &kPatience, sizeof kPatience);
}

NetlinkVerdict RouteSocket::ask(std::span<const std::byte> message,
                                const std::function<void(const NetlinkMessage&)>& each) {
  if (!socket_.valid()) {
    return {open_error_, {}};
  }
  nlmsghdr asked{};
  std::memcpy(&asked, message.data(), sizeof asked);
  if (::send(socket_.get(), message.data(), message.size(), 0) < 0) {
    return {errno, {}};
  }
  std::vector<std::byte> buffer(std::size_t{1} << 16);
  for (;;) {
    const ssize_t size = ::recv(socket_.get(), buffer.data(), buffer.size(), 0);
    if (size < 0 && errno == EINTR) {
      continue;
    }
    if (size <= 0) {
      return {size < 0 ? errno : EIO, {}};
    }
    for (const NetlinkMessage& answer :
         netlink_messages({buffer.data(), static_cast<std::size_t>(size)})) {
      if (answer.header.nlmsg_seq != asked.nlmsg_seq) {
        continue;  // to a question that nobody waited for
      }
      if (answer.header.nlmsg_type == NLMSG_ERROR) {
        return netlink_verdict(answer);
      }
      if (answer.header.nlmsg_type == NLMSG_DONE) {
        return {};
      }
      if (each) {
        each(answer);
      }
      const bool more = (answer.header.nlmsg_flags & NLM_F_MULTI) != 0;
      if (!more && (asked.nlmsg_flags & NLM_F_ACK) == 0) {
        return {};
      }
    }
  }
}

}  // namespace geodesic::drivers
