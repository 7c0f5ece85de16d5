// `geodesic`: the command line. Picks the subcommand, turns errors into words and exit statuses.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>
#include <iostream>
#include <string>
#include <vector>

#include "config/findings.hpp"
#include "drivers/bus/bus.hpp"
#include "tools/geodesic/command.hpp"
#include "tools/geodesicd/control_socket.hpp"

namespace geodesic::tools {
namespace {

constexpr const char* kExamples =
    "  geodesic check robot.toml                 is this file right? does the bus carry the rate?\n"
    "  geodesic sim robot.toml --bus vcan0       a simulated arm that answers on vcan0\n"
    "  geodesic status                           what the running daemon does\n"
    "  geodesic law hold                         hold the pose\n"
    "  geodesic tune robot.toml payload=box      change a running robot without a jolt\n"
    "  geodesic scan can0                        which drives answer here?\n"
    "  geodesic doctor robot.toml                what keeps this machine from real time?\n"
    "  geodesic COMMAND --help                   all about a command";

// CLI11 answers a mistyped command with "a subcommand is required"; this names it.
bool is_no_command(const CLI::App& app, const std::string& word) {
  std::vector<std::string> known;
  for (const CLI::App* command : app.get_subcommands(nullptr)) {
    known.emplace_back(command->get_name());
  }
  if (word.starts_with('-') || std::find(known.begin(), known.end(), word) != known.end()) {
    return false;
  }
  fmt::print(stderr, "geodesic: there is no command \"{}\"{}; commands: {}\n", word,
             config::did_you_mean(word, known), config::list_names(known));
  return true;
}

int call(int argc, const char* const* argv) {
  CLI::App app(
      "Tools for robot arms that float: simulate, check, compute, decode, and talk to the "
      "running daemon (geodesicd).",
      "geodesic");
  app.set_version_flag("--version", "geodesic " GEODESIC_VERSION, "print the version");
  app.require_subcommand(1);
  app.footer(footer(kExamples));
  Run run;
  add_sim(app, run);
  add_bus(app, run);
  add_check(app, run);
  add_model(app, run);
  add_derive(app, run);
  add_compile(app, run);
  add_shoot(app, run);
  add_scan(app, run);
  add_doctor(app, run);
  add_decode(app, run);
  add_zero(app, run);
  add_jog(app, run);
  add_status(app, run);
  add_law(app, run);
  add_stop(app, run);
  add_faults(app, run);
  add_tune(app, run);
  if (argc > 1 && is_no_command(app, argv[1])) {
    return kExitUsage;
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error, std::cout, std::cerr) == 0 ? kExitOk : kExitUsage;
  }
  return run ? run() : kExitUsage;
}

int guarded(int argc, const char* const* argv) {
  try {
    return call(argc, argv);
  } catch (const BadInput& bad) {
    if (*bad.what() != '\0') fmt::print(stderr, "geodesic: error: {}\n", bad.what());
  } catch (const std::exception& error) {  // BusError, ControlError, std::invalid_argument, ...
    fmt::print(stderr, "geodesic: error: {}\n", error.what());
  }
  return kExitRefused;
}

}  // namespace
}  // namespace geodesic::tools

int main(int argc, char** argv) {
  return geodesic::tools::guarded(argc, argv);
}
