// Brings a CAN interface into the state that the configuration wants, where that is allowed, and
// says in plain words why it cannot be used otherwise. Not real-time; once it is open, link_keeper
// looks after it.
#pragma once

#include <vector>

#include "drivers/bus/bus.hpp"
#include "drivers/bus/can_link.hpp"

namespace geodesic::drivers {

/// @param device  the interface's own name (resolve_interface())
/// @param news    gets what has been changed
/// @return the interface as it is now: CAN, up, and as configured. Openers without
///         BusOptions::transmit (monitors, simulated drives) get it as it is, if it carries their
///         frames: its bit rate is not theirs to judge.
/// @throws BusError: what was found, what is expected, and the exact line that helps.
CanLink prepare_link(LinkPort& port, const BusOptions& options, const std::string& device,
                     std::vector<BusNews>& news);

/// Throws `found (reason); fix: fix`, with the name the configuration has for the bus before it.
[[noreturn]] void refuse_bus(const BusOptions& options, const std::string& found, int error,
                             const std::string& fix);

}  // namespace geodesic::drivers
