// `geodesic stop`: asks the running daemon for a controlled stop.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>

#include "tools/geodesic/command.hpp"
#include "tools/geodesic/daemon_link.hpp"

namespace geodesic::tools {

void add_stop(CLI::App& app, Run& run) {
  struct StopArguments {
    DaemonArguments daemon;
    bool exit = false;
  };
  auto arguments = std::make_shared<StopArguments>();
  CLI::App* command = app.add_subcommand(
      "stop", "Controlled stop: braked to rest, lowered while the drives damp, then off");
  add_daemon(*command, arguments->daemon);
  command->add_flag("--exit", arguments->exit, "the daemon ends afterwards");
  command->footer(
      "\nReturns as soon as the daemon has taken the request; `geodesic status` shows "
      "the rest." +
      footer("  geodesic stop\n"
             "  geodesic stop --exit robot.toml"));
  command->callback([arguments, &run] {
    run = [arguments] {
      ControlClient client(socket_of(arguments->daemon));
      const nlohmann::json answer = ask(client, {{"cmd", "stop"}, {"exit", arguments->exit}});
      if (arguments->daemon.json) {
        fmt::print("{}\n", answer.dump());
      } else {
        fmt::print("{}\n", arguments->exit ? "asked to stop and end" : "asked to stop");
      }
      return kExitOk;
    };
  });
}

}  // namespace geodesic::tools
