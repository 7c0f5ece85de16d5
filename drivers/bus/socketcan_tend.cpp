// What a SocketCAN bus does beside sending and receiving, on the thread that tends it: open, open
// again, empty, restart, look.
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <exception>
#include <utility>

#include "drivers/bus/interface_name.hpp"
#include "drivers/bus/link_setup.hpp"
#include "drivers/bus/socketcan_bus.hpp"
#include "rt/clock.hpp"

namespace geodesic::drivers {
namespace {

// Where the last purge was not followed by a frame that left, the next comes sooner.
constexpr std::int64_t kPurgeAgainAfterNs = 2'000'000;
constexpr std::int64_t kAheadNs = 10'000'000;  // of the kernel's restart
constexpr std::int64_t kTriesApartNs = 50'000'000;

}  // namespace

CanSocket SocketCanBus::open() {
  std::string device = resolve_interface(options_.interface);
  if (!options_.transmit.empty() && (!lock_ || device != device_)) {
    BusLock lock(device);  // before anything is changed
    lock_ = std::move(lock);
  }
  device_ = std::move(device);
  std::vector<BusNews> news;
  const CanLink link = prepare_link(port_, options_, device_, news);
  CanSocket socket = open_can_socket(options_, link);
  if (keeper_) {
    keeper_->came_back(link);
  } else {
    keeper_.emplace(options_, port_, link);
  }
  for (BusNews& one : news) {
    keeper_->tell(one.warning, std::move(one.text));
  }
  return socket;
}

void SocketCanBus::tend() noexcept {
  tended_.store(true, std::memory_order_relaxed);
  const std::int64_t now = rt::now_ns();
  try {
    if (link_.load(std::memory_order_acquire) == Link::kGone) {
      tend_gone(now);
    } else {
      tend_up(now);
    }
  } catch (const std::exception& problem) {
    // No adapter, mostly: told once, tried again and again.
    if (last_refusal_ != problem.what()) {
      last_refusal_ = problem.what();
      keeper_->tell(true, fmt::format("not open again yet: {}", last_refusal_));
    }
  }
}

void SocketCanBus::tend_gone(std::int64_t now_ns) {
  if (!set_aside_) {
    ::dup3(idle_.get(), socket_.descriptor.get(), O_CLOEXEC);  // keeps the number: callers poll it
    set_aside_ = true;
    next_try_ns_ = now_ns + kTriesApartNs;
    last_refusal_.clear();
    keeper_->went();
    keeper_->tell(
        true, fmt::format("interface {} has gone; it is opened again when it is back", device_));
    return;
  }
  if (now_ns < next_try_ns_) {
    return;
  }
  next_try_ns_ = now_ns + kTriesApartNs;
  const CanSocket fresh = open();
  if (::dup3(fresh.descriptor.get(), socket_.descriptor.get(), O_CLOEXEC) < 0) {
    return;
  }
  set_aside_ = false;
  fresh_echoes_.store(fresh.echoes, std::memory_order_relaxed);
  keeper_->tell(false, fmt::format("interface {} is back and open again", device_));
  link_.store(Link::kFresh, std::memory_order_release);
}

void SocketCanBus::tend_up(std::int64_t now_ns) {
  const bool stays_off = keeper_->stays_off();
  const std::int64_t held_since = held_since_ns_.load(std::memory_order_relaxed);
  const bool bus_off = bus_off_.load(std::memory_order_relaxed);
  std::int64_t patience = proven_.load(std::memory_order_relaxed)
                              ? patience_ns_.load(std::memory_order_relaxed)
                              : kPurgeAgainAfterNs;
  if (bus_off) {  // not before its time is over, and before the kernel sends what waited
    patience = std::max(patience, keeper_->restart_ms() * std::int64_t{1'000'000} - kAheadNs);
  }
  const bool held = held_since != 0 && now_ns - held_since > patience && !(stays_off && bus_off);
  const bool asked = restart_asked_.exchange(false, std::memory_order_relaxed);
  if (keeper_->may_change() && (held || asked)) {
    purging_.store(true, std::memory_order_release);
    if (keeper_->purge(now_ns, held ? now_ns - held_since : 0)) {
      // The socket's memory of having been down is not to be taken for news.
      int error = 0;
      socklen_t size = sizeof error;
      ::getsockopt(socket_.descriptor.get(), SOL_SOCKET, SO_ERROR, &error, &size);
      purges_.fetch_add(1, std::memory_order_release);
    }
    purging_.store(false, std::memory_order_release);
  }
  restart_possible_.store(keeper_->may_change() && stays_off, std::memory_order_relaxed);
  keeper_->look(now_ns, received_.load(std::memory_order_relaxed));
}

}  // namespace geodesic::drivers
