// geodesicd's command line.
#include "tools/geodesicd/options.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <iostream>

#include "drivers/bus/unix_address.hpp"

namespace geodesic::tools {
namespace {

constexpr const char* kDescription =
    "geodesicd holds a robot arm up: it reads the joints from their drives, evaluates gravity and\n"
    "Coriolis compensation from the arm's URDF, and writes torques, once every period.";

constexpr const char* kFooter = R"(
Ending it
  SIGINT or SIGTERM: a controlled stop (the arm is braked to rest and lowered while the
  drives damp), drives disabled, then exit. The same signal again changes nothing; a third one
  within the stop takes torque off at once: an arm that is not at rest falls.
  A fault stops the arm by itself; the daemon then stays, tells why, and waits for `geodesic law`
  (or ends, with --exit-on-fault).

Tuning it while it runs
  When the robot's file or its URDF is saved, or on SIGHUP, both are read again and checked whole.
  Gains, friction, limits, payload, gravity, thresholds and times move over without a step in
  torque; one change that needs a restart, or one mistake, and nothing is taken: the log says why.
  `geodesic tune ROBOT.toml KEY=VALUE` does the same by hand. A tuned value stands until it is undone
  or the file is saved with another value for that option.

Control socket
  --socket PATH, else $XDG_RUNTIME_DIR/geodesic/NAME.sock, /run/geodesic/NAME.sock or
  /tmp/geodesic-UID/NAME.sock, whichever can be written first; open to owner and group.

Exit codes
  0  ended cleanly
  1  bad configuration, or the start was refused (the reason is on stderr)
  2  wrong usage
  3  ended in a fault, or torque was forced off

Examples
  geodesicd robot.toml                                  as the file says
  geodesicd robot.toml --bus vcan0                      against `geodesic sim robot.toml --bus vcan0`
  geodesicd robot.toml --compiled robot.compiled.so     with what `geodesic compile robot.toml` built
  geodesicd robot.toml --no-start                       connect nothing until `geodesic law float`
  geodesicd robot.toml --bus unix:/tmp/arm.bus --simulated-time --seconds 20 \
            --summary run.json --trace run.csv          a repeatable run, faster than real time)";

const std::array<std::string, 4> kLaws{"float", "hold", "damp", "zero"};

void describe_options(CLI::App& app, CommandLine& line, std::string& level) {
  app.add_option("ROBOT.toml", line.robot, "the robot's file")->required()->type_name("");
  app.add_option("--bus", line.buses,
                 "use this interface instead of the file's (can0, vcan0, unix:PATH); once for all "
                 "buses, or once for each in the file's order")
      ->type_size(1)
      ->type_name("INTERFACE")
      ->allow_extra_args(false);
  app.add_option("--law", line.law, "start with this law: float, hold, damp or zero")
      ->check(CLI::IsMember(std::vector<std::string>(kLaws.begin(), kLaws.end())));
  app.add_option(
         "--compiled", line.compiled,
         "compute with the model that `geodesic compile` has built, once it has agreed with "
         "the robot's file in a thousand states; none: without, whatever the file says")
      ->type_name("FILE");
  app.add_flag("--no-start", line.no_start, "stay off until `geodesic law NAME` asks for a start");
  app.add_option("--seconds", line.seconds,
                 "a controlled stop so long after the arm became active, then exit; seconds of "
                 "simulated time with --simulated-time")
      ->check(CLI::Range(1e-3, 1e9));
  app.add_flag("--exit-on-fault", line.exit_on_fault,
               "end after a fault's stop instead of waiting for an operator");
  app.add_flag("--strict", line.strict, "refuse to start where the model lint only warns");
  app.add_flag("--best-effort", line.best_effort,
               "start even where real-time scheduling, locked memory or the seal is refused");
  app.add_flag("--no-seal", line.no_seal,
               "for debugging: let the real-time thread make any system call");
  app.add_flag("--simulated-time", line.simulated_time,
               "virtual buses only: do not sleep, wait for every reply, advance by one period a "
               "cycle (with `geodesic sim --lockstep`)");
  app.add_flag("--allow-zero-law", line.allow_zero_law,
               "virtual buses only: accept the law zero, which lets the arm fall");
  app.add_option("--summary", line.summary, "write a summary of the run as JSON when it ends")
      ->type_name("FILE");
  app.add_option("--trace", line.trace, "write joints, torques and state as CSV")
      ->type_name("FILE");
  app.add_option("--trace-hz", line.trace_hz, "rows a second in the trace (default 100)")
      ->check(CLI::Range(1e-3, 1e5));
  app.add_option("--socket", line.socket, "where `geodesic status`, `law` and `stop` reach it")
      ->type_name("PATH");
  app.add_option("--log-level", level, "debug, info, warning, error or critical (default info)")
      ->check(CLI::IsMember(severity_names()));
  app.add_flag("--json", line.json, "log lines as JSON objects");
}

}  // namespace

ParseResult parse_command_line(int argc, const char* const* argv) {
  CommandLine line;
  std::string level = "info";
  CLI::App app(kDescription, "geodesicd");
  app.footer(kFooter);
  app.get_formatter()->column_width(28);
  app.set_version_flag("--version", "geodesicd " GEODESIC_VERSION, "print the version");
  describe_options(app, line, level);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    const bool asked = app.exit(error, std::cout, std::cerr) == 0;
    return {std::nullopt, asked ? ExitCode::kClean : ExitCode::kUsage};
  }
  const auto& names = severity_names();
  line.log_level =
      static_cast<Severity>(std::find(names.begin(), names.end(), level) - names.begin());
  return {line, ExitCode::kClean};
}

bool is_virtual_bus(const std::string& interface) {
  if (drivers::is_socket_bus(interface)) {
    return true;
  }
  const bool named = interface.rfind("vcan", 0) == 0 || interface.rfind("vxcan", 0) == 0;
  // An interface can be renamed; what has a device behind it is hardware, whatever its name.
  std::error_code ignored;
  return named && !std::filesystem::exists("/sys/class/net/" + interface + "/device", ignored);
}

std::optional<std::string> apply(const CommandLine& options, config::Robot& robot) {
  const auto real =
      std::find_if(robot.arm.buses.begin(), robot.arm.buses.end(),
                   [](const drivers::BusOptions& bus) { return !is_virtual_bus(bus.interface); });
  const auto refuse = [&](const char* what) {
    return std::string(what) + " is for virtual buses (vcan*, vxcan*, unix:PATH), but " +
           real->interface + " may have a real arm on it; use --bus vcan0, or leave it out";
  };
  if (real != robot.arm.buses.end() && options.simulated_time) {
    return refuse("--simulated-time");
  }
  if (real != robot.arm.buses.end() && options.allow_zero_law) {
    return refuse("--allow-zero-law");
  }
  if (!options.law.empty()) {
    robot.controller.law = control::law_from_string(options.law).value_or(robot.controller.law);
  }
  if (robot.controller.law == control::LawKind::kZero && !options.allow_zero_law) {
    return "the law zero lets the arm fall: it needs --allow-zero-law (virtual buses only)";
  }
  if (!options.compiled.empty()) {
    robot.compiled = options.compiled == "none" ? "" : options.compiled;
  }
  robot.controller.allow_zero_law = options.allow_zero_law;
  robot.controller.start_active = robot.controller.start_active && !options.no_start;
  robot.arm.simulated_time = options.simulated_time;
  return std::nullopt;
}

}  // namespace geodesic::tools
