// What `geodesic doctor` looks at, a function each. They read a SystemTree and what else they are
// given; they print nothing and change nothing.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "drivers/arm.hpp"
#include "drivers/bus/can_link.hpp"
#include "tools/geodesic/doctor_findings.hpp"
#include "tools/geodesic/system_tree.hpp"

namespace geodesic::tools {

/// What the daemon is going to ask of the machine: from the robot file, or as most have it.
struct Wishes {
  int priority = 80;               ///< SCHED_FIFO
  std::vector<int> cpus;           ///< to run on; empty: any
  bool bring_up = false;           ///< interfaces are the daemon's to bring up
  std::string program;             ///< geodesicd, as it lies in the SystemTree; empty: not found
  bool file_capabilities = false;  ///< that file carries cap_sys_nice and cap_ipc_lock
};

/// Version, preemption, time left to others, clock.
void look_at_kernel(const SystemTree& system, Findings& findings);
/// Governor, sleep states, isolation, siblings.
void look_at_processors(const SystemTree& system, const Wishes& wishes, Findings& findings);
/// Priorities, locked memory, capabilities.
void look_at_rights(const SystemTree& system, const Wishes& wishes, Findings& findings);
/// One interface: there, up, as configured, healthy, its interrupt's thread.
void look_at_bus(const SystemTree& system, drivers::LinkPort& port,
                 const drivers::BusOptions& options, const Wishes& wishes, Findings& findings);
/// The same of a socket bus.
void look_at_socket_bus(const drivers::BusOptions& options, Findings& findings);
/// Round trips to one drive, asked as the daemon asks before it enables anything.
/// @param exchanges  how many are measured    @param stopped  ends it early
void look_at_drive(const drivers::ArmOptions& arm, std::size_t joint, std::int64_t period_ns,
                   int exchanges, const std::function<bool()>& stopped, Findings& findings);

}  // namespace geodesic::tools
