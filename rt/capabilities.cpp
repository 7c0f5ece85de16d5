// Capabilities are a thread's own: every thread gives up its set itself.
#include "rt/capabilities.hpp"

#include <sys/capability.h>
#include <sys/prctl.h>
#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <memory>
#include <system_error>
#include <type_traits>

namespace geodesic::rt {
namespace {

bool new_privileges_forbidden_here = false;

struct FreeSet {
  void operator()(cap_t set) const { cap_free(set); }
};
using Set = std::unique_ptr<std::remove_pointer_t<cap_t>, FreeSet>;

bool is_kept(cap_value_t capability, bool network) {
  return capability == CAP_SYS_NICE || capability == CAP_IPC_LOCK ||
         (network && capability == CAP_NET_ADMIN);
}

void lift_memory_limit() {
  rlimit limit{};
  getrlimit(RLIMIT_MEMLOCK, &limit);
  const rlimit none{RLIM_INFINITY, RLIM_INFINITY};
  if (setrlimit(RLIMIT_MEMLOCK, &none) != 0 && limit.rlim_cur != limit.rlim_max) {
    limit.rlim_cur = limit.rlim_max;
    setrlimit(RLIMIT_MEMLOCK, &limit);
  }
}

std::string name_of(cap_value_t capability) {
  const std::unique_ptr<char, int (*)(void*)> name(cap_to_name(capability), &cap_free);
  return name ? std::string(name.get()) : std::to_string(capability);
}

}  // namespace

std::string keep_realtime_capabilities(bool network) {
  lift_memory_limit();
  const Set before(cap_get_proc());
  const Set after(cap_init());
  if (!before || !after) return {};
  std::string given_up;
  for (cap_value_t capability = 0; capability < cap_max_bits(); ++capability) {
    cap_flag_value_t had = CAP_CLEAR;
    cap_get_flag(before.get(), capability, CAP_PERMITTED, &had);
    if (had == CAP_SET && is_kept(capability, network)) {
      cap_set_flag(after.get(), CAP_PERMITTED, 1, &capability, CAP_SET);
      cap_set_flag(after.get(), CAP_EFFECTIVE, 1, &capability, CAP_SET);
    } else if (had == CAP_SET) {
      given_up += (given_up.empty() ? "" : ",") + name_of(capability);
    }
    // Refused to whoever lacks CAP_SETPCAP; no new privileges makes that good. What we would need
    // and lack stays, so that its absence can still be explained.
    if (!is_kept(capability, network) || had == CAP_SET) cap_drop_bound(capability);
  }
  cap_reset_ambient();
  cap_set_proc(after.get());
  const bool forbidden_before = prctl(PR_GET_NO_NEW_PRIVS, 0UL, 0UL, 0UL, 0UL) == 1;
  new_privileges_forbidden_here =
      prctl(PR_SET_NO_NEW_PRIVS, 1UL, 0UL, 0UL, 0UL) == 0 && !forbidden_before;
  return given_up;
}

int drop_thread_capabilities() noexcept {
  __user_cap_header_struct header{_LINUX_CAPABILITY_VERSION_3, 0};
  std::array<__user_cap_data_struct, _LINUX_CAPABILITY_U32S_3> nothing{};
  return capset(&header, nothing.data()) == 0 ? 0 : errno;
}

bool keep_only_network_administration() noexcept {
  __user_cap_header_struct header{_LINUX_CAPABILITY_VERSION_3, 0};
  std::array<__user_cap_data_struct, _LINUX_CAPABILITY_U32S_3> had{};
  std::array<__user_cap_data_struct, _LINUX_CAPABILITY_U32S_3> kept{};
  constexpr std::uint32_t kNetwork = 1U << CAP_NET_ADMIN;
  if (capget(&header, had.data()) == 0) {
    kept[0].permitted = had[0].permitted & kNetwork;
    kept[0].effective = kept[0].permitted;
  }
  return capset(&header, kept.data()) == 0 && kept[0].permitted != 0;
}

std::string capabilities_left(int but) {
  std::error_code gone;  // a thread may end while we look
  for (const auto& thread : std::filesystem::directory_iterator("/proc/self/task", gone)) {
    if (thread.path().filename() == std::to_string(but)) continue;
    std::ifstream status(thread.path() / "status");
    for (std::string line; std::getline(status, line);) {
      const bool held = line.starts_with("CapInh:") || line.starts_with("CapPrm:") ||
                        line.starts_with("CapEff:") || line.starts_with("CapAmb:");
      if (held && line.find_first_not_of("0\t ", 7) != std::string::npos) {
        line.erase(std::remove(line.begin(), line.end(), ':'), line.end());
        std::replace(line.begin(), line.end(), '\t', ' ');
        return thread.path().filename().string() + ": " + line;
      }
    }
  }
  return {};
}

bool forbade_new_privileges() noexcept {
  return new_privileges_forbidden_here;
}

}  // namespace geodesic::rt
