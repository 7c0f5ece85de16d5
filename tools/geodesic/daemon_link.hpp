// Finding the running daemon that a command talks to. What is said is in geodesicd/requests.hpp.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "tools/geodesicd/control_path.hpp"
#include "tools/geodesicd/control_socket.hpp"

// NOLINTNEXTLINE(readability-identifier-naming): the library's own name
namespace CLI {
class App;
}

namespace geodesic::tools {

struct DaemonArguments {
  std::string robot;   ///< a robot's file; empty: the only daemon there is
  std::string socket;  ///< empty: found by the robot's name
  bool json = false;
};

/// Adds [ROBOT.toml], --socket and --json.
void add_daemon(CLI::App& command, DaemonArguments& arguments);

/// --socket; else by the robot's name; else the only socket that somebody serves.
/// @throws BadInput if the file is bad, or no daemon or more than one is found.
std::filesystem::path socket_of(const DaemonArguments& arguments,
                                const PathEnvironment& environment = PathEnvironment::current());

/// Asks once and gives the answer, which has "ok": true.
/// @throws BadInput with the daemon's own words if it refuses; ControlError if it does not answer.
nlohmann::json ask(ControlClient& client, const nlohmann::json& request);

}  // namespace geodesic::tools
