// Forking, and dropping privileges by libcap and setrlimit.
#include "tests/rt/child.hpp"

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <fstream>
#include <iterator>

namespace geodesic::rt::test {

bool locked_pages_never_fault() {
  std::ifstream file("/proc/cpuinfo");
  const std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  return kMemoryCanBeLocked && text.find("User Mode Linux") == std::string::npos;
}

std::string in_child(const std::function<std::string()>& work) {
  std::array<int, 2> ends{};
  if (pipe(ends.data()) != 0) return "no pipe";
  const pid_t child = fork();
  if (child == 0) {
    close(ends[0]);
    const std::string result = work();
    const ssize_t written = write(ends[1], result.data(), result.size());
    _exit(written == static_cast<ssize_t>(result.size()) ? 0 : 1);
  }
  close(ends[1]);
  std::string result;
  std::array<char, 4096> buffer{};
  for (ssize_t got = 0; (got = read(ends[0], buffer.data(), buffer.size())) > 0;) {
    result.append(buffer.data(), static_cast<std::size_t>(got));
  }
  close(ends[0]);
  int status = 0;
  waitpid(child, &status, 0);
  if (status != 0) result += "\nthe child ended with status " + std::to_string(status);
  return result;
}

void drop(const std::vector<cap_value_t>& capabilities) {
  const cap_t set = cap_get_proc();
  const auto count = static_cast<int>(capabilities.size());
  for (const cap_flag_t flag : {CAP_EFFECTIVE, CAP_PERMITTED, CAP_INHERITABLE}) {
    cap_set_flag(set, flag, count, capabilities.data(), CAP_CLEAR);
  }
  cap_set_proc(set);
  cap_free(set);
}

void limit(int resource, unsigned long value) {
  const rlimit wanted{value, value};
  setrlimit(static_cast<__rlimit_resource>(resource), &wanted);
}

}  // namespace geodesic::rt::test
