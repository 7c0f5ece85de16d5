// Where the control socket of a robot's daemon is. No sockets are opened here.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>
#include <vector>

namespace geodesic::tools {

/// What the choice of a path depends on; tests put their own in.
struct PathEnvironment {
  std::filesystem::path runtime_dir;  ///< $XDG_RUNTIME_DIR; empty: not set
  std::filesystem::path run_dir = "/run";
  std::filesystem::path tmp_dir = "/tmp";
  uid_t uid = 0;

  /// Of this process.
  static PathEnvironment current();
};

/// Every place where the daemon of `robot` may keep its socket, the preferred first:
/// RUNTIME_DIR/geodesic/NAME.sock, /run/geodesic/NAME.sock, /tmp/geodesic-UID/NAME.sock. Characters
/// of the name that do not belong in a file name become '_'.
std::vector<std::filesystem::path> control_path_candidates(const std::string& robot,
                                                           const PathEnvironment& environment);

/// Where a daemon puts its socket: the first candidate whose folder it can write or make.
std::filesystem::path control_path(const std::string& robot, const PathEnvironment& environment);

}  // namespace geodesic::tools
