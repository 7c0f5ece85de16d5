// `geodesic law`: asks the running daemon for another law, or for a start.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>

#include "tools/geodesic/command.hpp"
#include "tools/geodesic/daemon_link.hpp"

namespace geodesic::tools {

void add_law(CLI::App& app, Run& run) {
  struct LawArguments {
    DaemonArguments daemon;
    std::string law;
  };
  auto arguments = std::make_shared<LawArguments>();
  CLI::App* command =
      app.add_subcommand("law", "Switch the running daemon to a law; from off or fault: start it");
  command->add_option("NAME", arguments->law, "float, hold, damp (or zero, in simulation)")
      ->required();
  add_daemon(*command, arguments->daemon);
  command->footer(
      footer("  geodesic law hold\n"
             "  geodesic law float robot.toml --json"));
  command->callback([arguments, &run] {
    run = [arguments] {
      ControlClient client(socket_of(arguments->daemon));
      const nlohmann::json answer = ask(client, {{"cmd", "law"}, {"law", arguments->law}});
      if (arguments->daemon.json) {
        fmt::print("{}\n", answer.dump());
      } else {
        fmt::print("asked for law {}\n", arguments->law);
      }
      return kExitOk;
    };
  });
}

}  // namespace geodesic::tools
