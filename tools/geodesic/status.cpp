// `geodesic status`: what the running daemon does, once or live.
#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <memory>

#include "tools/geodesic/command.hpp"
#include "tools/geodesic/daemon_link.hpp"
#include "tools/geodesic/status_table.hpp"
#include "tools/sim/stop_signals.hpp"

namespace geodesic::tools {
namespace {

struct StatusArguments {
  DaemonArguments daemon;
  bool once = false;
  double interval_s = 0.2;
};

// Redraws in place on a terminal; elsewhere one after the other.
void show(const std::string& text, bool in_place, long lines_before) {
  if (in_place && lines_before > 0) fmt::print("\x1b[{}A\x1b[J", lines_before);
  fmt::print("{}{}", text, in_place ? "" : "\n");
  std::fflush(stdout);
}

int run_status(const StatusArguments& arguments) {
  const StopSignals signals;
  ControlClient client(socket_of(arguments.daemon));
  const bool in_place = isatty(STDOUT_FILENO) != 0;
  long lines = 0;
  while (true) {
    const nlohmann::json status = ask(client, {{"cmd", "status"}});
    if (arguments.daemon.json) {
      fmt::print("{}\n", status.dump());
      std::fflush(stdout);
    } else {
      const std::string text = status_table(status);
      show(text, in_place, lines);
      lines = std::count(text.begin(), text.end(), '\n');
    }
    if (arguments.once) {
      return status.value("state", std::string()) == "fault" ? kExitFault : kExitOk;
    }
    const auto whole = static_cast<time_t>(arguments.interval_s);
    const timespec nap{whole,
                       std::lround((arguments.interval_s - static_cast<double>(whole)) * 1e9)};
    ppoll(nullptr, 0, &nap, &signals.waiting_mask());
    if (signals.requested().load()) return kExitOk;
  }
}

}  // namespace

void add_status(CLI::App& app, Run& run) {
  auto arguments = std::make_shared<StatusArguments>();
  CLI::App* command = app.add_subcommand(
      "status", "A live table of the running daemon: state, joints, latencies, faults");
  add_daemon(*command, arguments->daemon);
  command->add_flag("--once", arguments->once, "show it once; exit status 3 if it is in a fault");
  command
      ->add_option("--interval", arguments->interval_s, "seconds between two looks (default 0.2)")
      ->check(CLI::Range(0.02, 3600.0));
  command->footer(
      footer("  geodesic status\n"
             "  geodesic status --once --json | jq .state"));
  command->callback([arguments, &run] { run = [arguments] { return run_status(*arguments); }; });
}

}  // namespace geodesic::tools
