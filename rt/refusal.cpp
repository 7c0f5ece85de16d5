// The sentences: from the facts of privileges.hpp to what is missing and how to get it.
#include "rt/refusal.hpp"

#include <sched.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>

namespace geodesic::rt {
namespace {

std::string limit_text(std::uint64_t limit) {
  return limit == kUnlimited ? "unlimited" : std::to_string(limit);
}

std::string kibibytes(std::uint64_t bytes) {
  if (bytes == kUnlimited) return "unlimited";
  return std::to_string((bytes + 1023) / 1024) + " KiB";
}

/// A path as a shell takes it.
std::string shell_word(const std::string& text) {
  const bool plain = std::all_of(text.begin(), text.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 || std::strchr("/._+-", c) != nullptr;
  });
  if (plain) return text;
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

/// The ways to both privileges; one line each. Both at once: who lacks one mostly lacks the other.
std::string ways_to_privileges(const Privileges& privileges, const Capability& capability) {
  const std::string limits =
      "printf '%s - rtprio 99\\n%s - memlock unlimited\\n' " + shell_word(privileges.user) + " " +
      shell_word(privileges.user) +
      " | sudo tee /etc/security/limits.d/90-geodesic.conf   (then log in again)";
  const std::string systemd =
      "under systemd, in the unit: AmbientCapabilities=CAP_SYS_NICE CAP_IPC_LOCK";
  if (capability.bounded_out) {
    return "start the container with: --cap-add SYS_NICE --cap-add IPC_LOCK --ulimit rtprio=99 "
           "--ulimit memlock=-1\n" +
           systemd + " (and CapabilityBoundingSet= must hold both)";
  }
  if (privileges.user_namespace) {
    return "run it outside of the user namespace, or before entering: sudo prlimit --pid $$ "
           "--rtprio=99 --memlock=unlimited";
  }
  if (capability.in_file && privileges.no_new_privileges) {
    return systemd + " (file capabilities are ignored under NoNewPrivileges=)\n" + limits;
  }
  return "sudo setcap cap_sys_nice,cap_ipc_lock+ep " + shell_word(privileges.program) +
         "   (again after every build or update)\n" + limits + "\n" + systemd;
}

/// Why a capability is not effective, if that can be told. Begins with "; " or is empty.
std::string why_not_effective(const Privileges& privileges, const Capability& capability,
                              const char* name) {
  if (capability.bounded_out) {
    return std::string("; the bounding set of this process lacks ") + name +
           ", as in a container or a restricted unit";
  }
  if (!capability.in_file) return {};
  if (privileges.no_new_privileges) {
    return "; the program file carries it, but NoNewPrivs is set, so the kernel ignores that";
  }
  return "; the program file carries it, but it did not take effect (file system mounted nosuid, "
         "started by a debugger, or set after this process had started)";
}

const char* const kNamespaceCause =
    "the capability is effective only inside this user namespace, and the kernel wants it in the "
    "first one";

}  // namespace

std::string error_text(int error_number) {
  const char* const name = strerrorname_np(error_number);
  const char* const text = strerrordesc_np(error_number);
  return std::string(name != nullptr ? name : "unknown") + " (" + std::to_string(error_number) +
         ", " + (text != nullptr ? text : "no such error") + ")";
}

std::string to_string(const Refusal& refusal) {
  std::string result = "tried:   " + refusal.attempted + "\n";
  result += "error:   " + error_text(refusal.error_number) + "\n";
  result += "missing: " + refusal.missing + "\n";
  result += "fix:     ";
  for (const char c : refusal.fix) {
    result += c;
    if (c == '\n') result += "     or: ";
  }
  return result;
}

Refusal explain_scheduling(const Privileges& privileges, const std::string& thread, int priority,
                           int error_number) {
  Refusal refusal;
  refusal.attempted = "a thread \"" + thread + "\" with SCHED_FIFO at priority " +
                      std::to_string(priority) + " (sched_setscheduler)";
  refusal.error_number = error_number;

  const bool limit_allows = privileges.rtprio_limit != 0 &&
                            privileges.rtprio_limit >= static_cast<std::uint64_t>(priority);
  const Capability& capability = privileges.sys_nice;
  if (!capability.effective && !limit_allows) {
    refusal.missing = "CAP_SYS_NICE is not effective, and RLIMIT_RTPRIO is " +
                      limit_text(privileges.rtprio_limit) + " where " + std::to_string(priority) +
                      " is wanted (either would do)" +
                      why_not_effective(privileges, capability, "CAP_SYS_NICE");
    refusal.fix = ways_to_privileges(privileges, capability);
  } else if (privileges.group_runtime_us == 0) {
    refusal.missing =
        "real-time run time of this control group: " + privileges.group_file + " is 0";
    refusal.fix = "echo 950000 | sudo tee " + shell_word(privileges.group_file) +
                  "\nsudo sysctl -w kernel.sched_rt_runtime_us=-1";
  } else if (privileges.user_namespace && !limit_allows) {
    refusal.missing = kNamespaceCause;
    refusal.fix = ways_to_privileges(privileges, capability);
  } else if (privileges.seccomp) {
    refusal.missing =
        "the privilege is there, but a system call filter (seccomp) is in force and most likely "
        "forbids sched_setscheduler";
    refusal.fix =
        "under systemd: RestrictRealtime=no and @resources in SystemCallFilter=\n"
        "in a container: --cap-add SYS_NICE (its default filter then lets the call through)";
  } else {
    refusal.missing =
        "the privilege is there, but the kernel gives this control group no real-time run time "
        "(CONFIG_RT_GROUP_SCHED), or a security module forbids it; kernel.sched_rt_runtime_us is " +
        (privileges.rt_runtime_us ? std::to_string(*privileges.rt_runtime_us)
                                  : std::string("unknown"));
    refusal.fix = "sudo sysctl -w kernel.sched_rt_runtime_us=-1";
  }
  return refusal;
}

Refusal explain_memory_lock(const Privileges& privileges, int error_number) {
  Refusal refusal;
  refusal.attempted = std::string("to lock all memory (mlockall MCL_CURRENT") +
                      (privileges.memory_lock_unlimited() ? " | MCL_FUTURE)" : ")");
  refusal.error_number = error_number;
  const Capability& capability = privileges.ipc_lock;
  if (!capability.effective) {
    refusal.missing = "CAP_IPC_LOCK is not effective, and RLIMIT_MEMLOCK is " +
                      kibibytes(privileges.memlock_limit) + " where this process has " +
                      kibibytes(privileges.memory_bytes) +
                      " (either the capability or \"unlimited\" would do)" +
                      why_not_effective(privileges, capability, "CAP_IPC_LOCK");
    refusal.fix = ways_to_privileges(privileges, capability);
  } else if (privileges.user_namespace) {
    refusal.missing = kNamespaceCause;
    refusal.fix = ways_to_privileges(privileges, capability);
  } else if (error_number == ENOMEM || error_number == EAGAIN) {
    refusal.missing = "memory: not all of the " + kibibytes(privileges.memory_bytes) +
                      " of this process can be held in memory at once";
    refusal.fix = "give the machine, or the control group (MemoryMax=), more memory";
  } else {
    refusal.missing =
        "the privilege is there, but a system call filter (seccomp) or a security module forbids "
        "mlockall";
    refusal.fix = "under systemd: @memlock in SystemCallFilter=";
  }
  return refusal;
}

Refusal explain_pinning(const std::string& thread, const std::vector<int>& cpus, int error_number) {
  std::string list;
  for (const int cpu : cpus) list += (list.empty() ? "" : ",") + std::to_string(cpu);
  Refusal refusal;
  refusal.attempted = "to pin the thread \"" + thread + "\" to the processors " + list;
  refusal.error_number = error_number;
  refusal.missing = "not all of these processors are there for this process: it may use " +
                    usable_cpus() + " (what is online, less what a cpuset forbids)";
  refusal.fix = "name processors out of " + usable_cpus() +
                ", or none\nunder systemd or in a container: AllowedCPUs=, --cpuset-cpus";
  return refusal;
}

std::string usable_cpus() {
  cpu_set_t set;
  CPU_ZERO(&set);
  if (sched_getaffinity(0, sizeof(set), &set) != 0) return "unknown";
  std::string list;
  for (int cpu = 0; cpu < CPU_SETSIZE; ++cpu) {
    if (CPU_ISSET(static_cast<std::size_t>(cpu), &set)) {
      list += (list.empty() ? "" : ",") + std::to_string(cpu);
    }
  }
  return list;
}

}  // namespace geodesic::rt
