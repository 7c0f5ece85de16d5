// The buses of a simulated robot; see the header.
#include "tools/sim/sim_buses.hpp"

#include <poll.h>

#include <algorithm>
#include <ctime>

#include "drivers/bus/unix_address.hpp"
#include "rt/clock.hpp"

namespace geodesic::tools {

SimBuses::SimBuses(const std::vector<drivers::BusOptions>& options) {
  for (const drivers::BusOptions& wanted : options) {
    Entry entry;
    entry.interface = wanted.interface;
    if (drivers::is_socket_bus(wanted.interface) && !drivers::socket_bus_served(wanted.interface)) {
      drivers::SocketBusHubOptions hub;
      hub.path = wanted.interface;
      entry.hub = std::make_unique<drivers::SocketBusHub>(hub);
    }
    drivers::BusOptions hearing = wanted;
    hearing.receive.clear();
    hearing.transmit.clear();
    entry.bus = drivers::open_bus(hearing);
    buses_.push_back(std::move(entry));
  }
}

void SimBuses::wait(std::int64_t until_ns, const sigset_t& mask) {
  wait_for(until_ns - rt::now_ns(), mask);
}

void SimBuses::wait_for(std::int64_t duration_ns, const sigset_t& mask) {
  constexpr int kIdleWakesBeforePause = 3;
  constexpr std::int64_t kPauseNs = 2'000'000;
  std::array<pollfd, control::kMaxBuses> polled{};
  nfds_t count = 0;
  // A bus that went down may poll ready with nothing to read: pause rather than spin.
  if (idle_wakes_ < kIdleWakesBeforePause) {
    for (const Entry& entry : buses_) {
      if (count < polled.size()) polled[count++] = {entry.bus->descriptor(), POLLIN, 0};
    }
  } else {
    duration_ns = std::min(duration_ns, kPauseNs);
  }
  const std::int64_t left = std::max<std::int64_t>(duration_ns, 0);
  const timespec timeout{static_cast<time_t>(left / 1'000'000'000),
                         static_cast<long>(left % 1'000'000'000)};
  if (ppoll(polled.data(), count, &timeout, &mask) <= 0) idle_wakes_ = -1;
}

void SimBuses::hold(std::size_t bus, bool held) {
  Entry& entry = buses_[bus];
  if (entry.hub == nullptr || entry.held == held) return;
  entry.held = held;
  entry.hub->hold(held);
}

void SimBuses::flood(std::size_t bus, std::size_t frames) {
  drivers::Frame frame;  // identifier 0
  frame.length = 8;
  for (std::size_t i = 0; i < frames; ++i) queue(bus, frame);
}

void SimBuses::queue(std::size_t bus, const drivers::Frame& frame) {
  buses_[bus].outgoing.push_back(frame);
}

void SimBuses::flush() {
  for (Entry& entry : buses_) {
    std::span<const drivers::Frame> rest(entry.outgoing);
    while (!rest.empty()) {
      const auto batch = rest.first(std::min(rest.size(), drivers::Bus::kMaxBatch));
      entry.dropped += batch.size() - entry.bus->send(batch);
      rest = rest.subspan(batch.size());
    }
    entry.outgoing.clear();
  }
}

}  // namespace geodesic::tools
