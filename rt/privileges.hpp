// What this process may do about real time, as read from the kernel. Facts only; what they mean for
// the user is put into words by refusal.hpp.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace geodesic::rt {

/// A limit that is not set.
inline constexpr std::uint64_t kUnlimited = UINT64_MAX;

struct Capability {
  bool effective = false;    ///< the calling thread has it now
  bool bounded_out = false;  ///< the bounding set lacks it: nothing this process starts can get it
  bool in_file = false;      ///< the program file carries it (setcap)
};

struct Privileges {
  Capability sys_nice;              ///< CAP_SYS_NICE: real-time scheduling
  Capability ipc_lock;              ///< CAP_IPC_LOCK: locked memory without limit
  std::uint64_t rtprio_limit = 0;   ///< RLIMIT_RTPRIO, soft: highest priority without CAP_SYS_NICE
  std::uint64_t memlock_limit = 0;  ///< RLIMIT_MEMLOCK, soft [bytes]
  std::uint64_t memory_bytes = 0;   ///< size of this process' address space [bytes]
  bool user_namespace = false;  ///< in a user namespace of its own: capabilities count only there
  bool no_new_privileges = false;  ///< NoNewPrivs, and not by us: file capabilities are ignored
  bool seccomp = false;            ///< a system call filter is in force
  std::optional<std::int64_t> rt_runtime_us;  ///< kernel.sched_rt_runtime_us; -1: no limit
  std::string group_file;  ///< cpu.rt_runtime_us of the control group; empty: there is none
  std::optional<std::int64_t> group_runtime_us;  ///< what it says
  std::string program;                           ///< real path of the running program
  std::string user;                              ///< name, or number where it has no name

  /// Whether what this process maps may all be locked, now and later.
  bool memory_lock_unlimited() const {
    return (ipc_lock.effective && !user_namespace) || memlock_limit == kUnlimited;
  }
};

/// Reads all of it for the calling thread. Never fails: what cannot be read keeps its default. Not
/// real-time.
Privileges read_privileges();

}  // namespace geodesic::rt
