// Reads capabilities by libcap, limits by getrlimit, and the rest from /proc and the cgroup files.
#include "rt/privileges.hpp"

#include <pwd.h>
#include <sys/capability.h>
#include <sys/resource.h>
#include <unistd.h>

#include <array>
#include <climits>
#include <fstream>
#include <sstream>
#include <vector>

#include "rt/capabilities.hpp"

namespace geodesic::rt {
namespace {

bool has_flag(cap_t set, cap_value_t capability, cap_flag_t kind) {
  cap_flag_value_t value = CAP_CLEAR;
  return set != nullptr && cap_get_flag(set, capability, kind, &value) == 0 && value == CAP_SET;
}

Capability read_capability(cap_t process, cap_t file, cap_value_t capability) {
  Capability result;
  result.effective = has_flag(process, capability, CAP_EFFECTIVE);
  result.bounded_out = cap_get_bound(capability) == 0;
  result.in_file = has_flag(file, capability, CAP_PERMITTED);
  return result;
}

std::uint64_t soft_limit(int resource) {
  rlimit limit{};
  if (getrlimit(static_cast<__rlimit_resource>(resource), &limit) != 0) return 0;
  return limit.rlim_cur == RLIM_INFINITY ? kUnlimited : limit.rlim_cur;
}

std::optional<std::int64_t> read_number(const std::string& path) {
  std::ifstream file(path);
  std::int64_t value = 0;
  if (file >> value) return value;
  return std::nullopt;
}

/// The value after "NAME:" in /proc/self/status, or 0.
long status_number(const std::string& name) {
  std::ifstream file("/proc/thread-self/status");
  for (std::string word; file >> word;) {
    long value = 0;
    if (word == name + ":" && file >> value) return value;
  }
  return 0;
}

std::string program_path() {
  std::array<char, PATH_MAX> buffer{};
  const ssize_t length = readlink("/proc/self/exe", buffer.data(), buffer.size());
  if (length <= 0) return "PROGRAM";
  std::string path(buffer.data(), static_cast<std::size_t>(length));
  const std::string deleted =
      " (deleted)";  // rebuilt while it runs: the path still is the right one
  if (path.ends_with(deleted)) path.resize(path.size() - deleted.size());
  return path;
}

std::string user_name() {
  std::vector<char> buffer(4096);
  passwd entry{};
  passwd* found = nullptr;
  if (getpwuid_r(geteuid(), &entry, buffer.data(), buffer.size(), &found) == 0 &&
      found != nullptr) {
    return entry.pw_name;
  }
  return std::to_string(geteuid());
}

/// Where a version 1 "cpu" control group of this process keeps its real-time budget.
std::string group_runtime_file() {
  std::ifstream groups("/proc/self/cgroup");
  for (std::string line; std::getline(groups, line);) {
    // "4:cpu,cpuacct:/user.slice"; the one of version 2, "0::/...", has no such file
    std::istringstream fields(line);
    std::string number;
    std::string controllers;
    std::string path;
    std::getline(fields, number, ':');
    std::getline(fields, controllers, ':');
    std::getline(fields, path);
    if (controllers != "cpu" && !controllers.starts_with("cpu,") &&
        controllers.find(",cpu,") == std::string::npos && !controllers.ends_with(",cpu")) {
      continue;
    }
    for (const std::string& mount : {controllers, std::string("cpu")}) {
      std::string file = "/sys/fs/cgroup/";
      file.append(mount).append(path);
      if (!file.ends_with('/')) file += '/';
      file += "cpu.rt_runtime_us";
      if (access(file.c_str(), F_OK) == 0) return file;
    }
  }
  return {};
}

bool in_user_namespace() {
  // The first namespace maps every identifier to itself.
  std::ifstream file("/proc/self/uid_map");
  std::uint64_t inside = 0;
  std::uint64_t outside = 0;
  std::uint64_t count = 0;
  if (!(file >> inside >> outside >> count)) return false;
  return inside != 0 || outside != 0 || count < UINT32_MAX;
}

}  // namespace

Privileges read_privileges() {
  Privileges result;
  result.program = program_path();
  result.user = user_name();

  const cap_t process = cap_get_proc();
  const cap_t file = cap_get_file(result.program.c_str());  // null where the file carries none
  result.sys_nice = read_capability(process, file, CAP_SYS_NICE);
  result.ipc_lock = read_capability(process, file, CAP_IPC_LOCK);
  if (file != nullptr) cap_free(file);
  if (process != nullptr) cap_free(process);

  result.rtprio_limit = soft_limit(RLIMIT_RTPRIO);
  result.memlock_limit = soft_limit(RLIMIT_MEMLOCK);
  const std::int64_t pages = read_number("/proc/self/statm").value_or(0);
  result.memory_bytes =
      static_cast<std::uint64_t>(pages) * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
  result.user_namespace = in_user_namespace();
  result.no_new_privileges = status_number("NoNewPrivs") != 0 && !forbade_new_privileges();
  result.seccomp = status_number("Seccomp") != 0;
  result.rt_runtime_us = read_number("/proc/sys/kernel/sched_rt_runtime_us");
  result.group_file = group_runtime_file();
  if (!result.group_file.empty()) result.group_runtime_us = read_number(result.group_file);
  return result;
}

}  // namespace geodesic::rt
