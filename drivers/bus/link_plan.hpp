// What a CAN interface should be, as the configuration has it, against what it is: differences in
// words, the change that ends them, and the `ip link` line that does the same. Changes nothing. Not
// real-time.
#pragma once

#include <string>
#include <vector>

#include "drivers/bus/bus.hpp"
#include "drivers/bus/can_link.hpp"

namespace geodesic::drivers {

/// "bit rate 500000, configured 1000000"; empty: it is as configured and up. What the
/// configuration leaves open, and what the interface does not tell, is no difference.
std::vector<std::string> link_differences(const CanLink& link, const BusOptions& options);

/// How to end the differences: a controller and an MTU are changed while the interface is down, so
/// `down_first` says to take it down, if it is up; then `change`, which ends with up.
struct LinkPlan {
  bool down_first = false;
  LinkChange change;
};
LinkPlan link_plan(const CanLink& link, const BusOptions& options);

/// "ip link set can0 txqueuelen 64 up type can bitrate 1000000 restart-ms 100" and the like, for a
/// shell; begins by taking an interface down that is up. `link` is null for one that is not there.
std::string link_command(const std::string& device, const BusOptions& options,
                         const CanLink* link = nullptr);

/// By its name, where nothing else is known of it.
bool is_virtual_can(const std::string& device);

}  // namespace geodesic::drivers
