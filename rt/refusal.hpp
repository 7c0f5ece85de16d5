// Why the real-time loop did not start, in words a user can act on: what was tried, the error, what
// is missing, the command that fixes it. Puts into words; tries nothing itself.
#pragma once

#include <string>
#include <vector>

#include "rt/privileges.hpp"

namespace geodesic::rt {

struct Refusal {
  std::string attempted;  ///< the call with its arguments
  int error_number = 0;   ///< errno
  std::string missing;    ///< the capability, limit or setting that stands in the way
  std::string fix;        ///< commands or settings, one way a line
};

/// "EPERM (1, Operation not permitted)".
std::string error_text(int error_number);

/// Four lines or more: "tried:", "error:" (name, number and text), "missing:", "fix:".
std::string to_string(const Refusal& refusal);

/// SCHED_FIFO at `priority` was refused with `error_number`.
Refusal explain_scheduling(const Privileges& privileges, const std::string& thread, int priority,
                           int error_number);

/// mlockall was refused with `error_number`.
Refusal explain_memory_lock(const Privileges& privileges, int error_number);

/// A thread cannot run on (all of) `cpus`.
Refusal explain_pinning(const std::string& thread, const std::vector<int>& cpus, int error_number);

/// "0,2,3": the processors this process may run on.
std::string usable_cpus();

}  // namespace geodesic::rt
