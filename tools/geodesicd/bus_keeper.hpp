// The thread that looks after the buses: opens again what came back, empties what stands still,
// reads error counters. It is the one thread that may keep a capability (CAP_NET_ADMIN), so it does
// nothing else: it reads no file, answers no socket and writes no log.
#pragma once

#include <array>
#include <atomic>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

#include "control/joint.hpp"
#include "drivers/arm.hpp"

namespace geodesic::tools {

class BusKeeper {
 public:
  using Health = std::array<drivers::LinkHealth, control::kMaxBuses>;

  /// Starts the thread, which inherits the caller's capabilities and gives up all but
  /// CAP_NET_ADMIN; that too unless one of `buses` is an interface that it is to bring up. `arm`
  /// outlives it.
  BusKeeper(drivers::Arm& arm, const std::vector<drivers::BusOptions>& buses);
  ~BusKeeper();
  BusKeeper(const BusKeeper&) = delete;
  BusKeeper& operator=(const BusKeeper&) = delete;

  /// Its thread's number, if that has kept CAP_NET_ADMIN; else 0. Any thread.
  int privileged_thread() const noexcept { return privileged_.load(); }

  /// As far as is known. Any thread but the real-time one.
  Health health() const;
  /// What happened since this was last asked, oldest first. Any thread but the real-time one.
  std::vector<drivers::BusNews> take_news();

 private:
  void run(bool administers);
  void look();

  drivers::Arm& arm_;
  mutable std::mutex mutex_;
  Health health_;
  std::vector<drivers::BusNews> news_;
  std::atomic<bool> stop_{false};
  std::atomic<int> privileged_{0};
  std::atomic<bool> settled_{false};
  std::thread thread_;
};

}  // namespace geodesic::tools
