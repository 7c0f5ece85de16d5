// A bus that is held still while its host goes on commanding: how old the commands are that reach
// the other end. For every kind of interface.
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <functional>
#include <thread>

#include "tests/drivers/bus/bus_testing.hpp"

namespace geodesic::drivers::testing {

/// Tends a bus as the daemon does, from a thread of its own.
class Tender {
 public:
  explicit Tender(Bus& bus) : bus_(bus) {
    bus_.tend();
    thread_ = std::thread([this] {
      while (!stop_.load()) {
        bus_.tend();
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
      }
    });
  }
  ~Tender() { stop(); }
  Tender(const Tender&) = delete;
  Tender& operator=(const Tender&) = delete;
  /// From here on the caller's thread is the one that tends, and asks for news.
  void stop() {
    stop_.store(true);
    if (thread_.joinable()) thread_.join();
  }

 private:
  Bus& bus_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

struct HeldBus {
  std::size_t arrived_before = 0;
  std::size_t arrived_after = 0;      ///< commands of the time after the hold
  std::int64_t oldest_ns = 0;         ///< of what arrived since the hold began
  std::int64_t longest_pause_ns = 0;  ///< of this machine, which makes frames look old
};

/// Commands 0x01 to 0x07 every 2 ms; holds the bus for a second once commands arrive, releases it,
/// and goes on until commands arrive again.
inline HeldBus hold_for_a_second(Bus& host, Bus& drive, const std::function<void(bool)>& hold) {
  constexpr std::size_t kEnough = 50;
  HeldBus result;
  const std::int64_t start = rt::now_ns();
  std::int64_t held = 0;
  std::int64_t released = 0;
  std::int64_t last = start;
  for (std::int64_t now = start; now < start + 3 * kPatienceNs; now = rt::now_ns()) {
    result.longest_pause_ns = std::max(result.longest_pause_ns, now - last);
    if (held == 0 && result.arrived_before >= kEnough) {
      hold(true);
      held = rt::now_ns();
    }
    if (held != 0 && released == 0 && now >= held + 1'000 * kMillisecond) {
      hold(false);
      released = rt::now_ns();
    }
    if (result.arrived_after >= kEnough) {
      break;
    }
    last = rt::now_ns();
    const auto sent_us = static_cast<std::uint32_t>((last - start) / 1000);
    std::vector<Frame> frames = make_cycle(0x01, 7, 0);
    for (Frame& frame : frames) {
      for (std::size_t i = 0; i < 4; ++i) {
        frame.data[i] = static_cast<std::uint8_t>(sent_us >> (8 * i));
      }
    }
    host.send(frames);
    std::array<ReceivedFrame, 32> answers;
    host.receive(answers);
    for (const ReceivedFrame& one : receive_for(drive, 2 * kMillisecond)) {
      std::uint32_t then_us = 0;
      for (std::size_t i = 0; i < 4; ++i) {
        then_us |= static_cast<std::uint32_t>(one.frame.data[i]) << (8 * i);
      }
      const std::int64_t sent_ns = start + std::int64_t{1000} * then_us;
      result.arrived_before += held == 0 ? 1 : 0;
      result.arrived_after += released != 0 && sent_ns > released ? 1 : 0;
      if (held != 0) {
        result.oldest_ns = std::max(result.oldest_ns, one.stamp_ns - sent_ns);
      }
    }
  }
  return result;
}

}  // namespace geodesic::drivers::testing
