// A bus as people at the bench use it: found, locked against a daemon, opened, and a dialogue held
// on it with pauses. What is asked is the drive families'.
#pragma once

#include <atomic>
#include <csignal>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "drivers/bench_dialogue.hpp"
#include "drivers/bus/bus.hpp"
#include "drivers/bus/bus_lock.hpp"

namespace geodesic::tools {

/// CAN interfaces under `net` that are up, by name.
std::vector<std::string> can_interfaces(const std::filesystem::path& net = "/sys/class/net");

/// The kernel's name of an interface that is named by its USB socket or serial number; any other
/// name as it is. @throws BusError naming the adapters there are.
std::string device_of(const std::string& interface);

/// The interface (by the kernel's name) is set up for CAN FD; a socket bus always carries both.
bool carries_fd(const std::string& interface, const std::filesystem::path& net = "/sys/class/net");

/// How a dialogue ended.
enum class DialogueEnd : std::uint8_t {
  kOver,     ///< by itself
  kStopped,  ///< SIGINT or SIGTERM
  kDeaf,     ///< nobody takes frames: no other node, another bit rate, no termination
  kEndless,  ///< it went on for a minute
};

/// Open, with the sole right to command it: nobody of this host does so at the same time.
class BenchBus {
 public:
  /// Pause between two frames of ours, so that who else is on the bus gets through.
  static constexpr std::int64_t kPauseNs = 500'000;
  static constexpr std::int64_t kLongestNs = 60'000'000'000;
  /// As many error frames or refused sends in a row, without one good frame, are a deaf bus.
  static constexpr int kDeafAfter = 20;

  /// @throws BusError naming who commands the bus, or why it cannot be opened.
  BenchBus(const std::string& interface, bool fd);

  /// Holds the dialogue to its end. @param progress  called now and then.
  DialogueEnd hold(drivers::BenchDialogue& dialogue, const std::atomic<bool>& stop,
                   const sigset_t& waiting_mask, const std::function<void()>& progress = {});

  drivers::Bus& bus() { return *bus_; }

 private:
  drivers::BusLock lock_;
  std::unique_ptr<drivers::Bus> bus_;
};

/// Why nobody answers at all, and what helps.
std::string deaf_text(const std::string& interface);

}  // namespace geodesic::tools
