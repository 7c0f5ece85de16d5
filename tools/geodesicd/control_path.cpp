// Choice of the control socket's path.
#include "tools/geodesicd/control_path.hpp"

#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <system_error>

namespace geodesic::tools {
namespace {

std::string file_name(const std::string& robot) {
  std::string name = robot.empty() ? "robot" : robot;
  std::replace_if(
      name.begin(), name.end(),
      [](unsigned char c) { return std::isalnum(c) == 0 && c != '-' && c != '_' && c != '.'; },
      '_');
  if (name.front() == '.') {
    name.front() = '_';
  }
  return name + ".sock";
}

bool writable_or_creatable(const std::filesystem::path& folder) {
  std::error_code error;
  const std::filesystem::path& probe =
      std::filesystem::exists(folder, error) ? folder : folder.parent_path();
  return ::access(probe.c_str(), W_OK | X_OK) == 0;
}

}  // namespace

PathEnvironment PathEnvironment::current() {
  PathEnvironment environment;
  if (const char* runtime = std::getenv("XDG_RUNTIME_DIR"); runtime != nullptr) {
    environment.runtime_dir = runtime;
  }
  environment.uid = ::geteuid();
  return environment;
}

std::vector<std::filesystem::path> control_path_candidates(const std::string& robot,
                                                           const PathEnvironment& environment) {
  const std::string name = file_name(robot);
  std::vector<std::filesystem::path> candidates;
  if (environment.runtime_dir.is_absolute()) {
    candidates.push_back(environment.runtime_dir / "geodesic" / name);
  }
  candidates.push_back(environment.run_dir / "geodesic" / name);
  candidates.push_back(environment.tmp_dir / ("geodesic-" + std::to_string(environment.uid)) /
                       name);
  return candidates;
}

std::filesystem::path control_path(const std::string& robot, const PathEnvironment& environment) {
  const std::vector<std::filesystem::path> candidates = control_path_candidates(robot, environment);
  const auto found = std::find_if(
      candidates.begin(), candidates.end(),
      [](const std::filesystem::path& path) { return writable_or_creatable(path.parent_path()); });
  return found != candidates.end() ? *found : candidates.back();
}

}  // namespace geodesic::tools
