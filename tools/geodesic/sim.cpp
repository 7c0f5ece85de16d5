// `geodesic sim`: the simulated arm as a program. What it simulates is in tools/sim.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "config/findings.hpp"
#include "config/payloads.hpp"
#include "tools/geodesic/command.hpp"
#include "tools/geodesicd/options.hpp"
#include "tools/geodesicd/output_file.hpp"
#include "tools/sim/simulation.hpp"
#include "tools/sim/stop_signals.hpp"
#include "tools/sim/summary.hpp"

namespace geodesic::tools {
namespace {

struct SimArguments {
  RobotArguments robot;
  std::string pose;
  std::vector<std::string> pushes;
  std::vector<std::string> forces;
  std::vector<std::string> faults;
  std::string payload;
  std::string wire = "real";
  int priority = SimulationSettings{}.priority;
  double timestep_s = Physics::kDefaultTimestep;
  std::string trace;
  std::string summary;
  double trace_hz = 100.0;
  double release_s = 2.0;
  double seconds = 0.0;
  double floor_z = std::nan("");
  bool lockstep = false;
  bool json = false;
};

constexpr const char* kExamples =
    "  geodesic sim robot.toml --bus vcan0\n"
    "  geodesic sim robot.toml --bus unix:/tmp/arm --pose=0,0.5,-1 --push joint2:3@1+0.2\n"
    "  geodesic sim robot.toml --bus unix:/tmp/arm --lockstep --trace motion.csv --summary s.json\n"
    "  geodesic sim robot.toml --bus vcan0 --fault joint2:error=0xB@3 --fault "
    "joint1:encoder-jump=0.3@4";

SimulationSettings settings_of(const SimArguments& arguments, const config::Robot& robot) {
  SimulationSettings settings;
  settings.lockstep = arguments.lockstep;
  settings.wire = arguments.wire == "real";
  settings.priority = arguments.priority;
  settings.seconds = arguments.seconds;
  settings.trace = arguments.trace;
  settings.trace_hz = arguments.trace_hz;
  settings.plant.release_s = arguments.release_s;
  settings.plant.timestep_s = arguments.timestep_s;
  Script& script = settings.plant.script;
  for (const std::string& text : arguments.pushes) script.pushes.push_back(parse_push(text, robot));
  for (const std::string& text : arguments.forces) {
    script.forces.push_back(parse_force(text, robot));
  }
  for (const std::string& text : arguments.faults) {
    script.faults.push_back(parse_fault(text, robot));
  }
  return settings;
}

/// What the simulated arm carries: --payload, else what the file says.
void choose_payload(const std::string& name, config::Robot& robot) {
  if (!name.empty()) {
    std::vector<std::string> known{"none"};
    robot.simulation.payload.reset();
    for (std::size_t i = 0; i < robot.payloads.size(); ++i) {
      known.push_back(robot.payloads[i].name);
      if (known.back() == name) robot.simulation.payload = i;
    }
    if (name != "none" && !robot.simulation.payload) {
      throw BadInput(fmt::format("--payload: there is no [[payload]] {}{}; payloads: {}",
                                 config::quote(name), config::did_you_mean(name, known),
                                 config::list_names(known)));
    }
  }
  if (robot.simulation.payload) {
    robot.tree = config::with_payload(robot.tree, robot.payloads[*robot.simulation.payload]);
  }
}

void apply(const SimArguments& arguments, config::Robot& robot) {
  if (!arguments.pose.empty()) {
    robot.simulation.pose = parse_numbers(arguments.pose, "--pose a,b,c: one number a joint");
    if (robot.simulation.pose.size() != robot.arm.joints.size()) {
      std::string names;
      for (const auto& joint : robot.arm.joints) names += (names.empty() ? "" : ", ") + joint.name;
      throw BadInput(fmt::format("--pose has {} numbers, the robot {} joints ({})",
                                 robot.simulation.pose.size(), robot.arm.joints.size(), names));
    }
  }
  choose_payload(arguments.payload, robot);
  if (!std::isnan(arguments.floor_z)) {
    robot.simulation.floor = true;
    robot.simulation.floor_z_m = arguments.floor_z;
  }
  for (const drivers::BusOptions& bus : robot.arm.buses) {
    if (is_virtual_bus(bus.interface)) continue;
    if (arguments.lockstep) {
      throw BadInput("--lockstep is for virtual buses, but " + bus.interface +
                     " is a real one; use --bus vcan0 or --bus unix:PATH");
    }
    fmt::print(stderr,
               "geodesic: warning: {} is a real bus: if drives are on it, they and the simulated "
               "ones will answer at the same time\n",
               bus.interface);
  }
}

int run_sim(const SimArguments& arguments) {
  config::Robot robot = load(arguments.robot);
  apply(arguments, robot);
  SimulationSettings settings = settings_of(arguments, robot);
  if (!arguments.summary.empty()) {
    if (const auto problem = prepare_output(arguments.summary)) throw BadInput(*problem);
  }
  settings.ready = [&](const std::string& line, const std::vector<std::string>& warnings) {
    std::FILE* out = arguments.json ? stderr : stdout;
    for (const std::string& warning : warnings) {
      fmt::print(stderr, "geodesic: warning: {}\n", warning);
    }
    fmt::print(out, "{}\n", line);
    std::fflush(out);
  };
  const StopSignals signals;
  const SimulationReport report =
      run_simulation(robot, settings, signals.requested(), signals.waiting_mask());
  const nlohmann::ordered_json summary = to_json(report, robot);
  if (!arguments.summary.empty()) write_file(arguments.summary, summary.dump(2) + "\n");
  if (arguments.json) {
    fmt::print("{}\n", summary.dump(2));
  } else if (report.plant.release_s) {
    fmt::print("geodesic sim: {:.2f} s simulated, {:.2f} s free, largest drift {:.2e}\n",
               report.simulated_s, summary["released_s"].get<double>(),
               summary["drift_max"].get<double>());
  } else {
    fmt::print("geodesic sim: {:.2f} s simulated; the arm stayed on its stand\n",
               report.simulated_s);
  }
  return kExitOk;
}

}  // namespace

void add_sim(CLI::App& app, Run& run) {
  auto arguments = std::make_shared<SimArguments>();
  CLI::App* command = app.add_subcommand(
      "sim", "A simulated arm that answers on the robot's buses as its drives would");
  add_robot(*command, arguments->robot);
  SimArguments& a = *arguments;
  const auto repeatable = [&](const char* name, std::vector<std::string>& to, const char* text) {
    command->add_option(name, to, text)->type_size(1)->allow_extra_args(false);
  };
  command->add_option("--pose", a.pose,
                      "start at a,b,c... [rad or m], a number a joint; write --pose=-1,0 if the "
                      "first is negative");
  repeatable("--push", a.pushes,
             "JOINT:TORQUE@T+D: push a joint (name or number from 1) with TORQUE [N·m or N] from T "
             "for D seconds; T counts from the release");
  repeatable("--wrench", a.forces,
             "LINK:FX,FY,FZ@T+D: force [N, world axes] at a link's origin from T for D seconds");
  repeatable("--fault", a.faults,
             "JOINT:KIND@T (after the release), @start+T or @enabled+T: silent[=SECONDS], "
             "error=CODE, power-cycle, temperature=C, encoder-jump[=RAD], encoder-stuck, "
             "double[=RAD] (a second drive with its ids), and on the joint's whole bus "
             "babble[=SECONDS] (a flood), hold-bus=SECONDS (socket bus, real time)");
  command
      ->add_option("--release", a.release_s,
                   "a stand carries the arm until all drives have been enabled so long [s] "
                   "(default 2)")
      ->check(CLI::Range(0.0, 1e6));
  command
      ->add_option("--seconds", a.seconds, "end by itself after so much simulated time since start")
      ->check(CLI::Range(1e-3, 1e9));
  command->add_flag("--lockstep", a.lockstep,
                    "one control period of physics for each complete set of commands, however fast "
                    "they come (with geodesicd --simulated-time)");
  command
      ->add_option("--wire", a.wire,
                   "real: replies take the time of bits and drives (default); none: at once")
      ->check(CLI::IsMember({"real", "none"}));
  command
      ->add_option("--priority", a.priority,
                   "SCHED_FIFO priority of the answers, where it is allowed (default 10)")
      ->check(CLI::Range(1, 98));
  command
      ->add_option("--timestep", a.timestep_s,
                   "longest step of the mechanics [s] (default 0.00025)")
      ->check(CLI::Range(1e-5, 1e-2));
  command->add_option("--payload", a.payload,
                      "the [[payload]] that the arm really carries, or none (default: [simulation] "
                      "payload)");
  command->add_option("--floor", a.floor_z, "a floor to touch at this height [m]");
  command->add_option(
      "--trace", a.trace,
      "write the true motion as CSV: time since release, then q, v and drive torque "
      "of each joint");
  command->add_option("--trace-hz", a.trace_hz, "lines a second in the trace (default 100)")
      ->check(CLI::Range(1e-3, 1e5));
  command->add_option("--summary", a.summary,
                      "write drift, contact, frames, watchdog trips... as JSON when it ends");
  command->add_flag("--strict", a.robot.strict, "refuse where the model lint only warns");
  command->add_flag("--json", a.json, "print the summary as JSON at the end");
  command->footer(
      "\nIt says `geodesic sim: answering on ...` once it answers, and ends by SIGINT or SIGTERM.\n"
      "A socket bus (unix:PATH) that nobody serves is served by the simulator itself." +
      footer(kExamples));
  command->callback([arguments, &run] { run = [arguments] { return run_sim(*arguments); }; });
}

}  // namespace geodesic::tools
