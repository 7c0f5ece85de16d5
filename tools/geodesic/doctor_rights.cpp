// What a user's processes may do about real time, under the doctor's eye; see doctor_looks.hpp.
#include <fmt/format.h>

#include <cstdint>
#include <sstream>

#include "tools/geodesic/doctor_looks.hpp"

namespace geodesic::tools {
namespace {

constexpr int kNetAdmin = 12;  // linux/capability.h
constexpr int kIpcLock = 14;
constexpr int kSysNice = 23;

/// A mask of /proc/self/status, "CapEff:\t0000000000804000"; 0 if it is not there.
std::uint64_t mask_of(const std::string& status, const std::string& key) {
  const std::size_t at = status.find(key + ":");
  if (at == std::string::npos) return 0;
  return std::strtoull(status.c_str() + at + key.size() + 1, nullptr, 16);
}

bool has(std::uint64_t mask, int capability) {
  return (mask >> static_cast<unsigned>(capability) & 1U) != 0;
}

/// The soft limit of a line of /proc/self/limits; UINT64_MAX: unlimited.
std::optional<std::uint64_t> limit_of(const std::string& limits, const std::string& name) {
  const std::size_t at = limits.find(name);
  if (at == std::string::npos) return std::nullopt;
  std::istringstream rest(limits.substr(at + name.size()));
  std::string soft;
  rest >> soft;
  if (soft == "unlimited") return UINT64_MAX;
  return std::strtoull(soft.c_str(), nullptr, 10);
}

/// Why the daemon's file does not help; begins with ", " or is empty.
std::string about_file(const Wishes& wishes, bool no_new_privileges) {
  if (wishes.program.empty()) return ", and geodesicd was not found beside this program";
  if (!wishes.file_capabilities) return ", and geodesicd's file carries no capability";
  return no_new_privileges ? ", and NoNewPrivs makes the kernel ignore those of geodesicd's file"
                           : ", and the bounding set lacks what geodesicd's file carries";
}

}  // namespace

void look_at_rights(const SystemTree& system, const Wishes& wishes, Findings& findings) {
  Area area("rights", findings);
  const std::string status = system.read("/proc/self/status").value_or("");
  const std::string limits = system.read("/proc/self/limits").value_or("");
  const std::uint64_t effective = mask_of(status, "CapEff");
  const std::uint64_t bounding = mask_of(status, "CapBnd");
  const bool no_new = mask_of(status, "NoNewPrivs") == 1;
  const std::string map = system.read("/proc/self/uid_map").value_or("0 0 4294967295");
  const bool first_namespace = map.find("4294967295") != std::string::npos;
  const auto allowed = [&](int capability) {
    const bool by_file = wishes.file_capabilities && !no_new && has(bounding, capability);
    return first_namespace && (has(effective, capability) || by_file);
  };
  const std::string program = wishes.program.empty() ? "geodesicd" : wishes.program;
  const std::string set = fmt::format(
      "sudo setcap cap_sys_nice,cap_ipc_lock+ep {}   (or run it by the unit of "
      "tools/geodesicd/UNIT.md)",
      program);
  const std::string file = about_file(wishes, no_new);

  const std::uint64_t priority = limit_of(limits, "Max realtime priority").value_or(0);
  const bool by_limit = priority >= static_cast<std::uint64_t>(wishes.priority);
  if (allowed(kSysNice) || by_limit) {
    area.ok("priority",
            allowed(kSysNice)
                ? fmt::format("CAP_SYS_NICE: SCHED_FIFO {} is allowed", wishes.priority)
                : fmt::format("limit {} allows SCHED_FIFO {}",
                              priority == UINT64_MAX ? "unlimited" : std::to_string(priority),
                              wishes.priority));
  } else {
    area.bad("priority",
             fmt::format("SCHED_FIFO {} is not allowed: no CAP_SYS_NICE, limit of real-time "
                         "priority {}{}",
                         wishes.priority, priority, file),
             set);
  }
  const std::uint64_t locked = limit_of(limits, "Max locked memory").value_or(0);
  if (allowed(kIpcLock) || locked == UINT64_MAX) {
    area.ok("locked memory", allowed(kIpcLock) ? "CAP_IPC_LOCK: without limit" : "without limit");
  } else {
    area.bad("locked memory",
             fmt::format("at most {} KiB may be locked, and no CAP_IPC_LOCK: page faults can hold "
                         "a cycle up{}",
                         locked / 1024, file),
             set);
  }
  if (!first_namespace) {
    area.warn("namespace",
              "in a user namespace of its own: the kernel does not count its capabilities",
              "run it outside of the container or user namespace, or start the container with: "
              "--cap-add SYS_NICE --cap-add IPC_LOCK --ulimit rtprio=99 --ulimit memlock=-1");
  }
  if (wishes.bring_up && !allowed(kNetAdmin)) {
    area.warn("CAP_NET_ADMIN",
              "the robot file wants interfaces brought up, which takes CAP_NET_ADMIN: they have to "
              "be up already",
              fmt::format("sudo setcap cap_sys_nice,cap_ipc_lock,cap_net_admin+ep {}", program));
  }
}

}  // namespace geodesic::tools
