// Finding the running daemon that a command talks to; see the header.
#include "tools/geodesic/daemon_link.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <system_error>
#include <vector>

#include "tools/geodesic/command.hpp"

namespace geodesic::tools {
namespace {

std::vector<std::filesystem::path> sockets_served(const PathEnvironment& environment,
                                                  std::string& looked_in) {
  std::vector<std::filesystem::path> served;
  for (const std::filesystem::path& candidate : control_path_candidates("any", environment)) {
    const std::filesystem::path folder = candidate.parent_path();
    looked_in += (looked_in.empty() ? "" : ", ") + folder.string();
    std::error_code error;
    for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
      if (entry.path().extension() != ".sock") continue;
      try {
        const ControlClient client(entry.path());
        served.push_back(entry.path());
      } catch (const ControlError&) {
        continue;  // left behind by a daemon that is gone, or somebody else's
      }
    }
  }
  std::sort(served.begin(), served.end());
  served.erase(std::unique(served.begin(), served.end()), served.end());
  return served;
}

}  // namespace

void add_daemon(CLI::App& command, DaemonArguments& arguments) {
  command.add_option("ROBOT.toml", arguments.robot,
                     "the robot whose daemon is meant (default: the only one running)");
  command.add_option("--socket", arguments.socket, "the daemon's control socket");
  command.add_flag("--json", arguments.json, "the daemon's answer as JSON");
}

std::filesystem::path socket_of(const DaemonArguments& arguments,
                                const PathEnvironment& environment) {
  if (!arguments.socket.empty()) return arguments.socket;
  if (!arguments.robot.empty()) {
    return find_control_socket(load({arguments.robot, {}, false}).name);
  }
  std::string looked_in;
  const std::vector<std::filesystem::path> served = sockets_served(environment, looked_in);
  if (served.empty()) {
    throw BadInput("no daemon is running (looked in " + looked_in +
                   "); start one by `geodesicd ROBOT.toml`, or name its socket by --socket PATH");
  }
  if (served.size() > 1) {
    std::string names;
    for (const auto& path : served) names += "\n  --socket " + path.string();
    throw BadInput("more than one daemon is running; say which:" + names);
  }
  return served.front();
}

nlohmann::json ask(ControlClient& client, const nlohmann::json& request) {
  nlohmann::json answer = client.request(request);
  if (!answer.value("ok", false)) {
    throw BadInput(answer.value("error", std::string("the daemon refuses without a reason")));
  }
  return answer;
}

}  // namespace geodesic::tools
