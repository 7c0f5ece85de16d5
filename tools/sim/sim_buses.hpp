// The buses of a simulated robot: opened to hear everything, a hub hosted where nobody serves a
// socket bus, replies handed over in batches. Knows no drives.
#pragma once

#include <array>
#include <csignal>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "drivers/bus/bus.hpp"
#include "drivers/bus/socket_bus_hub.hpp"

namespace geodesic::tools {

class SimBuses {
 public:
  /// @throws drivers::BusError if one cannot be opened.
  explicit SimBuses(const std::vector<drivers::BusOptions>& options);

  std::size_t size() const noexcept { return buses_.size(); }
  const std::string& interface(std::size_t bus) const noexcept { return entry(bus).interface; }
  bool hosts_hub(std::size_t bus) const noexcept { return entry(bus).hub != nullptr; }
  const drivers::BusCounters& counters(std::size_t bus) const { return entry(bus).bus->counters(); }
  std::uint64_t dropped(std::size_t bus) const noexcept { return entry(bus).dropped; }

  /// Holds a hub hosted here still, or lets it go.
  void hold(std::size_t bus, bool held);
  /// Queues `frames` frames that win every arbitration.
  void flood(std::size_t bus, std::size_t frames);

  /// Sleeps until a frame has come, a signal that `mask` lets through, or until_ns
  /// (CLOCK_MONOTONIC).
  void wait(std::int64_t until_ns, const sigset_t& mask);
  /// The same for a duration; reads no clock.
  void wait_for(std::int64_t duration_ns, const sigset_t& mask);

  /// Calls hear(bus, frame, stamp_ns) for every frame that has come. @return how many.
  template <class Hear>
  std::size_t read(Hear&& hear) {
    std::size_t total = 0;
    for (std::size_t bus = 0; bus < buses_.size(); ++bus) {
      std::array<drivers::ReceivedFrame, 32> batch;
      std::size_t count = 0;
      do {
        count = buses_[bus].bus->receive(batch);
        for (std::size_t i = 0; i < count; ++i) {
          if (batch[i].frame.error) continue;  // no drive reads those
          hear(bus, batch[i].frame, batch[i].stamp_ns);
        }
        total += count;
      } while (count == batch.size());
    }
    idle_wakes_ = total == 0 ? idle_wakes_ + 1 : 0;
    return total;
  }

  /// Queues a reply; flush() sends all that are queued, one batch a bus.
  void queue(std::size_t bus, const drivers::Frame& frame);
  void flush();

 private:
  struct Entry {
    std::string interface;
    std::unique_ptr<drivers::SocketBusHub> hub;
    std::unique_ptr<drivers::Bus> bus;
    std::vector<drivers::Frame> outgoing;
    std::uint64_t dropped = 0;
    bool held = false;
  };
  const Entry& entry(std::size_t bus) const noexcept { return buses_[bus]; }

  std::vector<Entry> buses_;
  int idle_wakes_ = 0;
};

}  // namespace geodesic::tools
