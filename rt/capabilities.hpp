// Giving up what this process may do beyond its user's rights: all but the two capabilities of real
// time at the start, those too once the loop runs. What it has is read by privileges.hpp.
#pragma once

#include <string>

namespace geodesic::rt {

/// Keeps CAP_SYS_NICE and CAP_IPC_LOCK of what the process has, gives up every other capability,
/// also for programs it might start, and forbids new privileges. Before, it lifts RLIMIT_MEMLOCK as
/// far as it may, so that locked memory can grow when the capability is gone. To be called before
/// the first thread is started. Not real-time.
/// @param network  keep CAP_NET_ADMIN too, for the thread that looks after CAN interfaces
/// @return the capabilities given up, "cap_net_admin,cap_net_raw"; empty: there were none.
std::string keep_realtime_capabilities(bool network = false);

/// Gives up every capability of the calling thread for good; the scheduling it has and the memory
/// it has locked stay. Allocates nothing. @return 0 or errno. Not real-time.
int drop_thread_capabilities() noexcept;

/// Gives up every capability of the calling thread but CAP_NET_ADMIN, if it has that. Allocates
/// nothing. @return whether it has it. Not real-time.
bool keep_only_network_administration() noexcept;

/// Which thread of this process still has a capability in any of its sets but the bounding one:
/// "THREAD: CapPrm 0000000000804000"; empty: none. Not real-time.
/// @param but  thread that is not looked at; 0: look at all
std::string capabilities_left(int but = 0);

/// Whether keep_realtime_capabilities() has forbidden new privileges, and nobody before it.
bool forbade_new_privileges() noexcept;

}  // namespace geodesic::rt
