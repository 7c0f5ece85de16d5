// A client of the socket bus: the same Bus as SocketCAN's, where the kernel has no CAN.
#include "drivers/bus/socket_bus.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>

#include "drivers/bus/bit_timing.hpp"
#include "rt/clock.hpp"

namespace geodesic::drivers {
namespace {

constexpr int kMaxReads = 8;
// connect() on a unix socket never waits, but costs a few calls: not every cycle while a hub is
// gone.
constexpr int kSendsBetweenReconnects = 50;
constexpr std::int64_t kTriesApartNs = 50'000'000;
// What has waited for too long is taken back. After that so long nothing is sent; and the next
// cycle's frames are taken back at once, if they too have not left when the one after is due.
constexpr std::int64_t kQuietAfterForgetNs = 200'000'000;

Descriptor connect_to(const UnixAddress& address) noexcept {
  Descriptor socket(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (socket.valid() && ::connect(socket.get(), address.get(), address.size()) != 0) {
    const int error = errno;
    socket.reset();
    errno = error;
  }
  return socket;
}

UnixAddress address_of(const BusOptions& options) {
  const auto address = UnixAddress::path(socket_bus_path(options.interface));
  if (!address) {
    throw BusError(fmt::format("\"{}\": the path of a socket bus has 1 to 107 bytes; choose a "
                               "shorter one, e.g. unix:/tmp/bus0",
                               options.interface),
                   ENAMETOOLONG);
  }
  return *address;
}

}  // namespace

SocketBus::SocketBus(const BusOptions& options)
    : address_(address_of(options)),
      fd_(options.fd),
      traffic_(options, 2 * kMessages * kMaxBatch),
      idle_(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)),
      buffers_(kMessages) {
  socket_ = connect_to(address_);
  if (!socket_.valid() || !idle_.valid()) {
    const int error = errno;
    throw BusError(
        fmt::format("{}: nobody serves the socket bus ({}); start one first: `geodesic sim "
                    "ROBOT.toml --bus {}` or `geodesic bus {}`",
                    options.interface, std::strerror(error), options.interface, options.interface),
        error);
  }
  if (!options.transmit.empty()) {
    std::error_code ignored;
    const auto path =
        std::filesystem::weakly_canonical(socket_bus_path(options.interface), ignored);
    lock_.emplace(std::string(kSocketBusPrefix) + path.string());
  }
  for (std::size_t i = 0; i < kMessages; ++i) {
    vectors_[i] = {.iov_base = buffers_[i].data(), .iov_len = buffers_[i].size()};
    messages_[i].msg_hdr.msg_iov = &vectors_[i];
    messages_[i].msg_hdr.msg_iovlen = 1;
  }
}

bool SocketBus::can_carry(const Frame& frame) const noexcept {
  return (fd_ || !frame.fd || !traffic_.commands()) && is_can_length(frame.length, frame.fd);
}

std::size_t SocketBus::send(std::span<const Frame> frames) noexcept {
  if (frames.empty()) {
    return 0;
  }
  const std::int64_t now = rt::now_ns();
  traffic_.begin_send(now);
  if (traffic_.state().down && !reconnect()) {
    traffic_.handed_over(0, frames.size(), 0, now);
    return 0;
  }
  if (!may_send(now)) {
    traffic_.skipped(frames.size());
    return 0;
  }
  writer_.clear();
  for (const Frame& frame : frames) {
    if (writer_.full()) {
      break;
    }
    if (!can_carry(frame)) {
      traffic_.failed(EINVAL);
      break;
    }
    writer_.add(frame, 0);
  }
  const std::uint16_t flags = traffic_.commands() ? WireMessageHeader::kWantsConfirmation : 0;
  const auto message = writer_.finish(flags, 0);
  std::size_t sent = writer_.frames();
  // The same call as for real CAN: a sealed thread needs only one.
  iovec bytes{.iov_base = const_cast<std::byte*>(message.data()), .iov_len = message.size()};
  mmsghdr out{};
  out.msg_hdr.msg_iov = &bytes;
  out.msg_hdr.msg_iovlen = 1;
  if (sent > 0 && ::sendmmsg(socket_.get(), &out, 1, MSG_DONTWAIT | MSG_NOSIGNAL) < 0) {
    sent = 0;
    if (errno == EAGAIN || errno == ENOBUFS) {
      traffic_.failed(errno);
    } else {
      gone(errno);
    }
  }
  sent_since_ = sent_since_ || sent > 0;
  traffic_.handed_over(sent, frames.size(), traffic_.commands() ? sent : 0, now);
  return sent;
}

// At most one cycle is under way, and not for long.
bool SocketBus::may_send(std::int64_t now_ns) noexcept {
  if (traffic_.in_flight() > 0) {
    if (traffic_.room() >= kMessages * kMaxBatch) {
      read_batch();
    }
    if (traffic_.in_flight() > 0 && traffic_.confirmations_lost()) {
      traffic_.forget_in_flight();
    }
    if (traffic_.in_flight() > 0) {
      ask_to_forget(now_ns);
      return false;
    }
  }
  if (forget_asked_) {  // and it has been done
    forget_asked_ = false;
    proven_ = false;
    sent_since_ = false;
    quiet_until_ns_ = now_ns + kQuietAfterForgetNs;
  }
  proven_ = proven_ || sent_since_;
  return now_ns >= quiet_until_ns_;
}

void SocketBus::ask_to_forget(std::int64_t now_ns) noexcept {
  const std::int64_t patience = proven_ ? traffic_.patience_ns() : 0;
  if (forget_asked_ || now_ns - traffic_.handed_over_ns() <= patience || traffic_.state().down) {
    return;
  }
  writer_.clear();
  const auto message =
      writer_.finish(WireMessageHeader::kWantsConfirmation | WireMessageHeader::kForget, 0);
  iovec bytes{.iov_base = const_cast<std::byte*>(message.data()), .iov_len = message.size()};
  mmsghdr out{};
  out.msg_hdr.msg_iov = &bytes;
  out.msg_hdr.msg_iovlen = 1;
  forget_asked_ = ::sendmmsg(socket_.get(), &out, 1, MSG_DONTWAIT | MSG_NOSIGNAL) == 1;
}

std::size_t SocketBus::receive(std::span<ReceivedFrame> out) noexcept {
  std::size_t n = traffic_.take(out);
  for (int read = 0; n < out.size() && read < kMaxReads; ++read) {
    const std::size_t got = read_batch();
    n += traffic_.take(out.subspan(n));
    if (got < kMessages) {
      break;
    }
  }
  return n;
}

// Reads what has arrived, at most kMessages messages, into the books. Needs room for them there.
std::size_t SocketBus::read_batch() noexcept {
  if (traffic_.state().down) {
    return 0;
  }
  const int result = ::recvmmsg(socket_.get(), messages_.data(), kMessages, MSG_DONTWAIT, nullptr);
  if (result < 0) {
    if (errno != EAGAIN) {
      gone(errno);
    }
    return 0;
  }
  const std::int64_t now = rt::now_ns();
  const auto got = static_cast<std::size_t>(result);
  for (std::size_t i = 0; i < got; ++i) {
    if (messages_[i].msg_len == 0) {  // no message is empty: the hub has closed
      gone(ECONNRESET);
      return i;
    }
    take_in({buffers_[i].data(), messages_[i].msg_len}, now);
  }
  return got;
}

void SocketBus::take_in(std::span<const std::byte> message, std::int64_t now_ns) noexcept {
  WireReader reader(message);
  WireReader::Item item;
  while (reader.next(item)) {
    if (item.confirmation) {
      traffic_.confirmed();
    } else {
      traffic_.arrived(item.frame, std::min(item.stamp_ns, now_ns));
    }
  }
  if (reader.valid()) {
    traffic_.dropped(reader.header().dropped);
  }
}

void SocketBus::gone(int error_number) noexcept {
  traffic_.failed(error_number);
  traffic_.went_down(rt::now_ns());
  traffic_.forget_in_flight();
  forget_asked_ = false;
  if (!tended_.load(std::memory_order_relaxed)) {
    set_aside();
    sends_until_reconnect_ = kSendsBetweenReconnects;
  }
  link_.store(Link::kGone, std::memory_order_release);
}

void SocketBus::set_aside() noexcept {
  ::dup3(idle_.get(), socket_.get(), O_CLOEXEC);  // keeps the number: callers poll it
}

bool SocketBus::connect_again() noexcept {
  const Descriptor fresh = connect_to(address_);
  return fresh.valid() && ::dup3(fresh.get(), socket_.get(), O_CLOEXEC) >= 0;
}

bool SocketBus::reconnect() noexcept {
  if (tended_.load(std::memory_order_relaxed)) {
    if (link_.load(std::memory_order_acquire) != Link::kFresh) {
      return false;
    }
  } else {
    if (--sends_until_reconnect_ > 0) {
      return false;
    }
    sends_until_reconnect_ = kSendsBetweenReconnects;
    if (!connect_again()) {
      traffic_.failed(errno);
      return false;
    }
  }
  link_.store(Link::kUp, std::memory_order_relaxed);
  traffic_.came_up();
  traffic_.new_connection();
  return true;
}

void SocketBus::tend() noexcept {
  tended_.store(true, std::memory_order_relaxed);
  if (link_.load(std::memory_order_acquire) != Link::kGone) {
    return;
  }
  if (!set_aside_) {
    set_aside();
    set_aside_ = true;
    next_try_ns_ = rt::now_ns() + kTriesApartNs;
  } else if (rt::now_ns() >= next_try_ns_) {
    next_try_ns_ = rt::now_ns() + kTriesApartNs;
    if (connect_again()) {
      set_aside_ = false;
      link_.store(Link::kFresh, std::memory_order_release);
    }
  }
}

std::unique_ptr<Bus> open_socket_bus(const BusOptions& options) {
  return std::make_unique<SocketBus>(options);
}

}  // namespace geodesic::drivers
