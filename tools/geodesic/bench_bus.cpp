// Buses for people at the bench; see the header.
#include "tools/geodesic/bench_bus.hpp"

#include <fmt/format.h>
#include <poll.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <ctime>
#include <fstream>

#include "drivers/bus/interface_name.hpp"
#include "drivers/bus/unix_address.hpp"
#include "rt/clock.hpp"

namespace geodesic::tools {
namespace {

constexpr int kArpHardwareCan = 280;   // ARPHRD_CAN, linux/if_arp.h
constexpr unsigned kInterfaceUp = 1U;  // IFF_UP
constexpr int kFdMtu = 72;             // CANFD_MTU

long number_in(const std::filesystem::path& file, int base) {
  std::string text;
  std::getline(std::ifstream(file), text);
  return std::strtol(text.c_str(), nullptr, base);
}

drivers::BusOptions options_of(const std::string& interface, bool fd) {
  drivers::BusOptions options;
  options.name = interface;
  options.interface = interface;
  options.fd = fd;
  return options;
}

}  // namespace

std::vector<std::string> can_interfaces(const std::filesystem::path& net) {
  std::vector<std::string> found;
  std::error_code none;
  for (const auto& entry : std::filesystem::directory_iterator(net, none)) {
    if (number_in(entry.path() / "type", 10) == kArpHardwareCan &&
        (static_cast<unsigned>(number_in(entry.path() / "flags", 16)) & kInterfaceUp) != 0) {
      found.push_back(entry.path().filename().string());
    }
  }
  std::sort(found.begin(), found.end());
  return found;
}

bool carries_fd(const std::string& interface, const std::filesystem::path& net) {
  return drivers::is_socket_bus(interface) || number_in(net / interface / "mtu", 10) >= kFdMtu;
}

std::string device_of(const std::string& interface) {
  return drivers::is_socket_bus(interface) ? interface : drivers::resolve_interface(interface);
}

BenchBus::BenchBus(const std::string& interface, bool fd)
    : lock_(interface), bus_(drivers::open_bus(options_of(interface, fd))) {}

DialogueEnd BenchBus::hold(drivers::BenchDialogue& dialogue, const std::atomic<bool>& stop,
                           const sigset_t& waiting_mask, const std::function<void()>& progress) {
  constexpr std::int64_t kLookNs = 100'000'000;
  std::array<drivers::ReceivedFrame, 64> batch;
  const std::int64_t end_ns = rt::now_ns() + kLongestNs;
  std::int64_t next_ns = 0;
  std::int64_t look_ns = 0;
  int deaf = 0;
  while (!dialogue.over()) {
    const std::int64_t now_ns = rt::now_ns();
    if (stop.load()) return DialogueEnd::kStopped;
    if (now_ns > end_ns) return DialogueEnd::kEndless;
    if (now_ns >= next_ns) {
      if (const std::optional<drivers::Frame> frame = dialogue.transmit(now_ns)) {
        deaf += bus_->send({&*frame, 1}) == 0 ? 1 : 0;
        next_ns = now_ns + kPauseNs;
      }
    }
    if (progress && now_ns >= look_ns) {
      look_ns = now_ns + kLookNs;
      progress();
    }
    pollfd wait{bus_->descriptor(), POLLIN, 0};
    const timespec nap{0, kPauseNs};
    if (ppoll(&wait, 1, &nap, &waiting_mask) > 0 && (wait.revents & (POLLHUP | POLLERR)) != 0) {
      ++deaf;
      const timespec pause{0, kPauseNs};
      ppoll(nullptr, 0, &pause, &waiting_mask);
    }
    const std::size_t count = bus_->receive(batch);
    for (std::size_t i = 0; i < std::min(count, batch.size()); ++i) {
      deaf = batch[i].frame.error ? deaf + 1 : 0;
      if (!batch[i].frame.error) dialogue.receive(batch[i]);
    }
    if (deaf > kDeafAfter || bus_->state().bus_off || bus_->state().down) {
      return DialogueEnd::kDeaf;
    }
  }
  return DialogueEnd::kOver;
}

std::string deaf_text(const std::string& interface) {
  return drivers::is_socket_bus(interface)
             ? fmt::format("{}: whoever served the socket bus has gone", interface)
             : fmt::format(
                   "{0}: nobody takes our frames: no drive is powered, its bit rate is "
                   "another one, or a wire or the termination is missing; look at: ip "
                   "-details -statistics link show {0}",
                   interface);
}

}  // namespace geodesic::tools
