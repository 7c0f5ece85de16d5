// The wire of the socket bus: one thread, one poll loop. Message layout lives in socket_bus_wire,
// the order of frames in arbitration, their duration in bit_timing.
#include "drivers/bus/socket_bus_hub.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/prctl.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <optional>
#include <vector>

#include "drivers/bus/arbitration.hpp"
#include "drivers/bus/bit_timing.hpp"
#include "drivers/bus/bus.hpp"
#include "drivers/bus/socket_bus_listener.hpp"
#include "drivers/bus/socket_bus_wire.hpp"
#include "drivers/bus/unix_address.hpp"
#include "rt/clock.hpp"

namespace geodesic::drivers {
namespace {

// Beyond this many waiting frames the hub leaves the rest in the senders' sockets.
constexpr std::size_t kMaxWaiting = 1024;
// So one client that floods does not starve the others.
constexpr int kMessagesPerTurn = 16;

struct Client {
  Descriptor socket;
  std::uint64_t number = 0;
  bool wants_confirmation = false;
  bool closed = false;
  bool owes_news = false;  // it has not been told of its latest losses
  std::uint64_t dropped = 0;
  WireWriter out;
};

struct Waiting {
  Frame frame;
  std::uint64_t sender = 0;
  std::int64_t arrival_ns = 0;
  std::uint64_t sequence = 0;
};

}  // namespace

class SocketBusHub::Wire {
 public:
  explicit Wire(const SocketBusHubOptions& options)
      : options_(options), listener_(socket_bus_path(options.path)) {}

  void run(int wake, const std::atomic<bool>& stop);

  std::atomic<std::uint64_t> carried{0};
  std::atomic<std::uint64_t> dropped{0};
  std::atomic<std::size_t> clients_now{0};
  std::atomic<bool> held{false};

 private:
  bool wait(int wake);
  void accept_clients();
  void read_clients(std::int64_t now);
  void take_in(Client& client, const WireReader& message, std::int64_t now);
  void advance(std::int64_t now);
  std::size_t winner(std::int64_t now) const;
  Waiting pop(std::size_t index);
  void forget(Client& client, std::int64_t now);
  void deliver(const Waiting& item, std::int64_t stamp);
  void flush(Client& client);
  void flush_all();

  SocketBusHubOptions options_;
  SocketBusListener listener_;
  std::vector<std::unique_ptr<Client>> clients_;
  std::vector<Waiting> waiting_;
  std::optional<Waiting> on_wire_;
  std::int64_t wire_free_ns_ = 0;
  std::uint64_t next_client_ = 1;
  std::uint64_t next_sequence_ = 0;
  std::vector<pollfd> polled_;
};

void SocketBusHub::Wire::run(int wake, const std::atomic<bool>& stop) {
  ::prctl(PR_SET_NAME, "geodesic-bus");
  ::prctl(PR_SET_TIMERSLACK, 1UL);
  while (!stop.load(std::memory_order_relaxed)) {
    if (wait(wake)) {
      std::uint64_t ignored = 0;
      [[maybe_unused]] const auto n = ::read(wake, &ignored, sizeof ignored);
    }
    const std::int64_t now = rt::now_ns();
    read_clients(now);
    accept_clients();  // after reading: who connected before a frame was sent is given it
    if (held.load(std::memory_order_relaxed)) {
      wire_free_ns_ = std::max(wire_free_ns_, now);
    } else {
      advance(now);
    }
    flush_all();
    std::erase_if(clients_, [](const auto& client) { return client->closed; });
    clients_now.store(clients_.size(), std::memory_order_relaxed);
  }
}

// @return true if somebody woke the hub on purpose.
bool SocketBusHub::Wire::wait(int wake) {
  const bool full = waiting_.size() >= kMaxWaiting;
  polled_.clear();
  polled_.push_back({.fd = wake, .events = POLLIN, .revents = 0});
  polled_.push_back({.fd = listener_.descriptor(), .events = POLLIN, .revents = 0});
  for (const auto& client : clients_) {
    const int events = (full ? 0 : POLLIN) | (client->owes_news ? POLLOUT : 0);
    // One that has hung up would wake us though nothing is asked of it, again and again.
    polled_.push_back({.fd = events != 0 ? client->socket.get() : -1,
                       .events = static_cast<short>(events),
                       .revents = 0});
  }
  timespec timeout{};
  const bool timed = on_wire_.has_value() && !held.load(std::memory_order_relaxed);
  if (timed) {
    const std::int64_t left = std::max<std::int64_t>(0, wire_free_ns_ - rt::now_ns());
    timeout.tv_sec = left / rt::kNanosecondsPerSecond;
    timeout.tv_nsec = left % rt::kNanosecondsPerSecond;
  }
  ::ppoll(polled_.data(), polled_.size(), timed ? &timeout : nullptr, nullptr);
  return (polled_.front().revents & POLLIN) != 0;
}

void SocketBusHub::Wire::accept_clients() {
  for (Descriptor socket = listener_.accept(); socket.valid(); socket = listener_.accept()) {
    auto client = std::make_unique<Client>();
    client->socket = std::move(socket);
    client->number = next_client_++;
    clients_.push_back(std::move(client));
  }
}

void SocketBusHub::Wire::read_clients(std::int64_t now) {
  std::array<std::byte, kWireMessageBytes> buffer;
  for (const auto& client : clients_) {
    for (int turn = 0; turn < kMessagesPerTurn && waiting_.size() < kMaxWaiting; ++turn) {
      const ssize_t size = ::recv(client->socket.get(), buffer.data(), buffer.size(), MSG_DONTWAIT);
      if (size < 0 && (errno == EAGAIN || errno == EINTR)) {
        break;
      }
      const WireReader message({buffer.data(), size > 0 ? static_cast<std::size_t>(size) : 0});
      if (size <= 0 || !message.valid()) {  // it left, or speaks something else
        client->closed = true;
        break;
      }
      take_in(*client, message, now);
    }
  }
}

void SocketBusHub::Wire::take_in(Client& client, const WireReader& message, std::int64_t now) {
  client.wants_confirmation = (message.header().flags & WireMessageHeader::kWantsConfirmation) != 0;
  if ((message.header().flags & WireMessageHeader::kForget) != 0) {
    forget(client, now);
  }
  WireReader reader = message;
  WireReader::Item item;
  while (reader.next(item)) {
    if (item.frame.error || is_can_length(item.frame.length, item.frame.fd)) {
      waiting_.push_back({item.frame, client.number, now, next_sequence_++});
    }
  }
}

// Brings the wire up to `now`: what has ended is delivered, what may begin begins.
void SocketBusHub::Wire::advance(std::int64_t now) {
  for (;;) {
    if (on_wire_) {
      if (wire_free_ns_ > now) {
        return;
      }
      deliver(*on_wire_, wire_free_ns_);
      on_wire_.reset();
    }
    if (waiting_.empty()) {
      return;
    }
    Waiting next = pop(winner(now));
    if (options_.paced && !next.frame.error) {
      wire_free_ns_ = std::max(wire_free_ns_, next.arrival_ns) +
                      frame_time_ns(next.frame, options_.bit_rate, options_.data_bit_rate);
      on_wire_ = next;
    } else {
      deliver(next, now);
    }
  }
}

// Index of the frame that wins the wire among those that wait at the moment it becomes free; an
// unpaced wire is free whenever the hub looks.
std::size_t SocketBusHub::Wire::winner(std::int64_t now) const {
  const auto first = std::min_element(
      waiting_.begin(), waiting_.end(),
      [](const Waiting& a, const Waiting& b) { return a.arrival_ns < b.arrival_ns; });
  const std::int64_t moment = options_.paced ? std::max(wire_free_ns_, first->arrival_ns) : now;
  std::size_t best = static_cast<std::size_t>(first - waiting_.begin());
  for (std::size_t i = 0; i < waiting_.size(); ++i) {
    if (waiting_[i].arrival_ns > moment) {
      continue;
    }
    const std::uint32_t key = arbitration_key(waiting_[i].frame);
    const std::uint32_t best_key = arbitration_key(waiting_[best].frame);
    if (key < best_key || (key == best_key && waiting_[i].sequence < waiting_[best].sequence)) {
      best = i;
    }
  }
  return best;
}

// As a controller that is stopped: what waits is gone, and what stands still on a held wire too.
void SocketBusHub::Wire::forget(Client& client, std::int64_t now) {
  std::size_t gone =
      std::erase_if(waiting_, [&](const Waiting& item) { return item.sender == client.number; });
  if (held.load(std::memory_order_relaxed) && on_wire_ && on_wire_->sender == client.number) {
    on_wire_.reset();
    ++gone;
  }
  for (; client.wants_confirmation && gone > 0; --gone) {
    if (client.out.full()) {
      flush(client);
    }
    client.out.add_confirmation(now);
  }
}

Waiting SocketBusHub::Wire::pop(std::size_t index) {
  const Waiting item = waiting_[index];
  waiting_[index] = waiting_.back();
  waiting_.pop_back();
  return item;
}

void SocketBusHub::Wire::deliver(const Waiting& item, std::int64_t stamp) {
  carried.fetch_add(1, std::memory_order_relaxed);
  for (const auto& client : clients_) {
    const bool own = client->number == item.sender;
    if (own && !client->wants_confirmation) {
      continue;
    }
    if (client->out.full()) {
      flush(*client);
    }
    if (own) {
      client->out.add_confirmation(stamp);
    } else {
      client->out.add(item.frame, stamp);
    }
  }
}

// Hands over what has gathered for a client; a client that does not take it loses it.
void SocketBusHub::Wire::flush(Client& client) {
  const auto message = client.out.finish(0, client.dropped);
  const ssize_t result =
      ::send(client.socket.get(), message.data(), message.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
  if (result >= 0) {
    client.owes_news = false;
  } else if (errno == EAGAIN || errno == ENOBUFS) {
    client.dropped += client.out.frames();
    dropped.fetch_add(client.out.frames(), std::memory_order_relaxed);
    client.owes_news = true;
  } else {
    client.closed = true;
  }
  client.out.clear();
}

void SocketBusHub::Wire::flush_all() {
  for (const auto& client : clients_) {
    if (!client->closed && (client->out.frames() > 0 || client->owes_news)) {
      flush(*client);
    }
  }
}

SocketBusHub::SocketBusHub(const SocketBusHubOptions& options)
    : wire_(std::make_unique<Wire>(options)), wake_(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
  // Signals are the program's business, so the hub's thread takes none.
  sigset_t all;
  sigset_t before;
  sigfillset(&all);
  ::pthread_sigmask(SIG_SETMASK, &all, &before);
  thread_ = std::thread([this] { wire_->run(wake_.get(), stop_); });
  ::pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

SocketBusHub::~SocketBusHub() {
  stop_.store(true, std::memory_order_relaxed);
  ::eventfd_write(wake_.get(), 1);
  thread_.join();
}

SocketBusHubCounters SocketBusHub::counters() const noexcept {
  return {.carried = wire_->carried.load(std::memory_order_relaxed),
          .dropped = wire_->dropped.load(std::memory_order_relaxed),
          .clients = wire_->clients_now.load(std::memory_order_relaxed)};
}

void SocketBusHub::hold(bool held) noexcept {
  wire_->held.store(held, std::memory_order_relaxed);
  ::eventfd_write(wake_.get(), 1);
}

}  // namespace geodesic::drivers
