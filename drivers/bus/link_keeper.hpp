// Looks after an open CAN interface from the thread that tends its bus: reads state and error
// counters, tells what changes, empties a queue that does not move. What the real-time thread sees
// of it is socketcan_bus's business. Not real-time.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "drivers/bus/bus.hpp"
#include "drivers/bus/can_link.hpp"

namespace geodesic::drivers {

class LinkKeeper {
 public:
  /// Everything given must outlive it. @param link  as it was opened
  LinkKeeper(const BusOptions& options, LinkPort& port, const CanLink& link);

  /// Reads the interface, ten times a second at most. @param received  frames that came from others
  /// to this opener, since it was opened.
  void look(std::int64_t now_ns, std::uint64_t received);

  /// Takes the interface down and up: its queue and its controller forget what they hold, and a
  /// controller that had left the bus is back. @param held_ns  for how long nothing has left
  /// @return false: not allowed (and never asked again), or it failed.
  bool purge(std::int64_t now_ns, std::int64_t held_ns);

  /// Whether this program may change the interface, as far as is known.
  bool may_change() const noexcept { return options_.bring_up && !forbidden_; }
  /// A controller that leaves the bus stays away until it is restarted.
  bool stays_off() const noexcept { return link_.restart_ms == 0; }
  /// After this long it is restarted by the kernel [ms].
  int restart_ms() const noexcept { return link_.restart_ms.value_or(0); }

  /// It was opened anew.
  void came_back(const CanLink& link);
  /// It has gone.
  void went();

  const LinkHealth& health() const noexcept { return health_; }
  void tell(bool warning, std::string text);
  std::vector<BusNews> take_news();

 private:
  void tell_changes(const CanLink& before);
  void tell_foreign(std::int64_t now_ns, std::uint64_t received);

  BusOptions options_;
  LinkPort& port_;
  CanLink link_;
  LinkHealth health_;
  std::vector<BusNews> news_;
  bool forbidden_ = false;
  bool half_purged_ = false;  // we took it down, and it has not come up
  std::int64_t next_look_ns_ = 0;
  std::int64_t purge_told_ns_ = 0;
  // Foreign frames, by windows of a second.
  std::int64_t window_ns_ = 0;
  std::uint64_t window_wire_ = 0;
  std::uint64_t window_received_ = 0;
  bool babbling_ = false;
};

}  // namespace geodesic::drivers
