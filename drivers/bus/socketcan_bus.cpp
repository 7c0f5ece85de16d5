// A bus of the kernel's CAN stack (SocketCAN): batches in, batches out, one cycle under way at
// most.
#include "drivers/bus/socketcan_bus.hpp"

#include <linux/sock_diag.h>
#include <sys/eventfd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <ctime>

#include "drivers/bus/can_frame.hpp"
#include "rt/clock.hpp"

namespace geodesic::drivers {
namespace {

constexpr std::size_t kHeldFrames = 4 * Bus::kMaxBatch;
// receive() ends after so many batches even if every frame is filtered out, so a flooded bus cannot
// hold the cycle.
constexpr int kMaxReads = 8;
// A frame that has left the queue of a healthy controller is on the wire within a few frame times.
// After this long without a confirmation it is most likely the confirmation that is lost.
constexpr std::int64_t kConfirmationLostNs = 20'000'000;

std::int64_t realtime_ns() noexcept {
  timespec time{};
  ::clock_gettime(CLOCK_REALTIME, &time);
  return time.tv_sec * std::int64_t{1'000'000'000} + time.tv_nsec;
}

// CLOCK_MONOTONIC last: whoever is interrupted between the two dates the batch too young, by no
// more than the interruption. Too old would make a reply look like one to an earlier command.
void read_clocks(StampClock& clock) noexcept {
  const std::int64_t wall_ns = realtime_ns();
  clock.read(rt::now_ns(), wall_ns);
}

// After a purge, so long nothing is sent: a bus that stays as it is does not get frame after frame
// that has to be thrown away again.
constexpr std::int64_t kQuietAfterPurgeNs = 200'000'000;

// The socket is bound to an interface that is no more: it will not work again.
bool interface_is_gone(int error_number) noexcept {
  return error_number == ENODEV || error_number == ENXIO;
}

}  // namespace

SocketCanBus::SocketCanBus(const BusOptions& options)
    : options_(options),
      socket_(open()),
      idle_(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)),
      traffic_(options, kHeldFrames) {
  for (std::size_t i = 0; i < kMaxBatch; ++i) {
    out_vectors_[i].iov_base = &out_frames_[i];
    out_messages_[i].msg_hdr.msg_iov = &out_vectors_[i];
    out_messages_[i].msg_hdr.msg_iovlen = 1;
    in_vectors_[i] = {.iov_base = &in_frames_[i], .iov_len = sizeof(canfd_frame)};
    in_messages_[i].msg_hdr.msg_iov = &in_vectors_[i];
    in_messages_[i].msg_hdr.msg_iovlen = 1;
    in_messages_[i].msg_hdr.msg_control = in_control_[i].bytes.data();
  }
  read_clocks(clock_);
  clock_.emptied();
}

std::size_t SocketCanBus::send(std::span<const Frame> frames) noexcept {
  if (frames.empty()) {
    return 0;
  }
  const std::int64_t now = rt::now_ns();
  traffic_.begin_send(now);
  if (!usable()) {
    traffic_.handed_over(0, frames.size(), 0, now);
    return 0;
  }
  if (traffic_.commands() && !may_send(now)) {
    traffic_.skipped(frames.size());
    return 0;
  }
  const std::size_t batch = std::min(frames.size(), kMaxBatch);
  for (std::size_t i = 0; i < batch; ++i) {
    out_vectors_[i].iov_len = encode_can_frame(frames[i], out_frames_[i]);
  }
  const int result = ::sendmmsg(socket_.descriptor.get(), out_messages_.data(),
                                static_cast<unsigned>(batch), MSG_DONTWAIT);
  const std::size_t sent = result > 0 ? static_cast<std::size_t>(result) : 0;
  if (result < 0) {
    note_error(errno);
  } else if (sent < batch) {
    traffic_.failed(ENOBUFS);  // the kernel keeps the reason to itself; it is a full queue
  }
  sent_since_ = sent_since_ || sent > 0;
  const auto commanded = std::count_if(frames.begin(), frames.begin() + static_cast<long>(sent),
                                       [this](const Frame& f) { return traffic_.is_command(f); });
  traffic_.handed_over(sent, frames.size(),
                       socket_.echoes ? static_cast<std::size_t>(commanded) : 0, now);
  return sent;
}

// False while there is no interface; takes up a socket that was opened anew.
bool SocketCanBus::usable() noexcept {
  const Link link = link_.load(std::memory_order_acquire);
  if (link == Link::kFresh) {
    socket_.echoes = fresh_echoes_.load(std::memory_order_relaxed);
    purges_seen_ = purges_.load(std::memory_order_relaxed);
    traffic_.forget_in_flight();
    traffic_.came_up();
    traffic_.new_connection();
    held_since_ns_.store(0, std::memory_order_relaxed);
    link_.store(Link::kUp, std::memory_order_relaxed);
  }
  return link != Link::kGone;
}

bool SocketCanBus::may_send(std::int64_t now_ns) noexcept {
  const std::uint64_t purges = purges_.load(std::memory_order_acquire);
  if (purges != purges_seen_) {
    purges_seen_ = purges;
    traffic_.purged();
    held_since_ns_.store(0, std::memory_order_relaxed);
    quiet_until_ns_ = now_ns + kQuietAfterPurgeNs;
    proven_.store(false, std::memory_order_relaxed);
    sent_since_ = false;
  }
  bus_off_.store(traffic_.state().bus_off, std::memory_order_relaxed);
  if (now_ns < quiet_until_ns_ || purging_.load(std::memory_order_acquire) ||
      !last_cycle_has_left()) {
    return false;
  }
  held_since_ns_.store(0, std::memory_order_relaxed);
  if (sent_since_) {
    proven_.store(true, std::memory_order_relaxed);
  }
  return true;
}

// What is under way has not left, and it is not for a confirmation alone.
void SocketCanBus::held() noexcept {
  if (!traffic_.state().down && held_since_ns_.load(std::memory_order_relaxed) == 0) {
    patience_ns_.store(traffic_.patience_ns(), std::memory_order_relaxed);
    held_since_ns_.store(traffic_.handed_over_ns(), std::memory_order_relaxed);
  }
}

void SocketCanBus::ask_restart() noexcept {
  if (traffic_.state().bus_off && restart_possible_.load(std::memory_order_relaxed)) {
    traffic_.restart_expected();
    restart_asked_.store(true, std::memory_order_relaxed);
  }
}

bool SocketCanBus::last_cycle_has_left() noexcept {
  if (!socket_.echoes) {
    const bool empty = queue_empty();
    if (!empty) {
      held();
    }
    return empty;
  }
  if (traffic_.in_flight() > 0 && traffic_.room() >= kMaxBatch) {
    read_batch();
  }
  if (traffic_.in_flight() == 0) {
    return true;
  }
  // The rare path: still unconfirmed. Either it still waits, in the queue or in the controller, or
  // it was destroyed, or its confirmation was. Only with a reason to believe so is it forgotten.
  if (!queue_empty()) {
    held();
    return false;
  }
  if (traffic_.confirmations_lost()) {
    traffic_.forget_in_flight();
    return true;
  }
  const control::BusState& state = traffic_.state();
  const bool healthy = !state.error_passive && !state.bus_off && !state.down;
  if (!healthy) {
    held();
  }
  const bool overdue = rt::now_ns() - traffic_.handed_over_ns() > kConfirmationLostNs;
  return healthy && overdue && traffic_.doubt_in_flight();
}

bool SocketCanBus::queue_empty() const noexcept {
  std::array<std::uint32_t, SK_MEMINFO_VARS> memory{};
  socklen_t size = sizeof memory;
  const int result =
      ::getsockopt(socket_.descriptor.get(), SOL_SOCKET, SO_MEMINFO, memory.data(), &size);
  return result == 0 && memory[SK_MEMINFO_WMEM_ALLOC] == 0;
}

std::size_t SocketCanBus::receive(std::span<ReceivedFrame> out) noexcept {
  std::size_t n = traffic_.take(out);
  if (link_.load(std::memory_order_acquire) != Link::kUp) {
    return n;
  }
  for (int read = 0; n < out.size() && read < kMaxReads; ++read) {
    const std::size_t got = read_batch();
    n += traffic_.take(out.subspan(n));
    if (got < kMaxBatch) {
      break;
    }
  }
  return n;
}

// Reads what has arrived, at most a batch, into the books. Needs room for a batch there.
std::size_t SocketCanBus::read_batch() noexcept {
  for (mmsghdr& message : in_messages_) {
    message.msg_hdr.msg_controllen = kControlBytes;
  }
  const int result =
      ::recvmmsg(socket_.descriptor.get(), in_messages_.data(), kMaxBatch, MSG_DONTWAIT, nullptr);
  if (result < 0 && errno != EAGAIN) {
    note_error(errno);
    return 0;  // not known to be empty
  }
  const std::size_t got = result > 0 ? static_cast<std::size_t>(result) : 0;
  if (got == 0) {
    return 0;
  }
  read_clocks(clock_);
  for (std::size_t i = 0; i < got; ++i) {
    take_in(in_messages_[i], in_frames_[i]);
  }
  if (got < kMaxBatch) {
    clock_.emptied();
  }
  const BusCounters& counters = traffic_.counters();
  received_.store(counters.received + counters.foreign_commands + counters.error_frames,
                  std::memory_order_relaxed);
  return got;
}

void SocketCanBus::take_in(const mmsghdr& message, const canfd_frame& raw) noexcept {
  // CMSG_NXTHDR takes a pointer to a mutable header and changes nothing.
  msghdr header = message.msg_hdr;
  std::int64_t stamp_ns = 0;
  for (cmsghdr* item = CMSG_FIRSTHDR(&header); item != nullptr; item = CMSG_NXTHDR(&header, item)) {
    if (item->cmsg_level != SOL_SOCKET) {
      continue;
    }
    if (item->cmsg_type == SCM_TIMESTAMPNS) {
      timespec time{};
      std::memcpy(&time, CMSG_DATA(item), sizeof time);
      stamp_ns = time.tv_sec * std::int64_t{1'000'000'000} + time.tv_nsec;
    } else if (item->cmsg_type == SO_RXQ_OVFL) {
      std::uint32_t dropped = 0;
      std::memcpy(&dropped, CMSG_DATA(item), sizeof dropped);
      traffic_.dropped(dropped);
    }
  }
  Frame frame;
  if (!decode_can_frame(raw, message.msg_len, frame)) {
    return;
  }
  if ((header.msg_flags & MSG_CONFIRM) != 0) {
    traffic_.confirmed();
    return;
  }
  traffic_.arrived(frame, clock_.monotonic(stamp_ns));
}

void SocketCanBus::note_error(int error_number) noexcept {
  const bool ours = purging_.load(std::memory_order_acquire) ||
                    purges_.load(std::memory_order_acquire) != purges_seen_;
  if (error_number == ENETDOWN && ours) {
    return;  // it is down for a moment, to forget what it held
  }
  traffic_.failed(error_number);
  if (error_number == ENETDOWN || interface_is_gone(error_number)) {
    traffic_.went_down(rt::now_ns());
  }
  if (interface_is_gone(error_number)) {
    traffic_.forget_in_flight();
    link_.store(Link::kGone, std::memory_order_release);
  }
}

std::unique_ptr<Bus> open_socketcan_bus(const BusOptions& options) {
  return std::make_unique<SocketCanBus>(options);
}

}  // namespace geodesic::drivers
