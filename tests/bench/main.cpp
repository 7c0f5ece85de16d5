// geodesic_bench: prints figures of one part at a time, as a table or as JSON. tests/bench/run
// composes the whole report.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "tests/bench/cycle.hpp"
#include "tests/bench/dynamics.hpp"

namespace geodesic::bench {
namespace {

using nlohmann::json;

json to_json(const RobotTimings& robot) {
  json out{{"robot", robot.robot},   {"dof", robot.dof},
           {"absent", robot.absent}, {"differences", robot.differences},
           {"ns", json::object()},   {"ns_cold", json::object()}};
  for (const Timing& timing : robot.timings) {
    out[timing.cold ? "ns_cold" : "ns"][timing.function][timing.who] = {
        {"min", timing.min}, {"median", timing.median}, {"p90", timing.p90}};
  }
  return out;
}

void print(const RobotTimings& robot) {
  fmt::print(
      "\n{} ({} degrees of freedom), ns a call: min / median / 90 %; ratio to ours by median\n",
      robot.robot, robot.dof);
  std::string function;
  double ours = 0.0;
  for (const Timing& timing : robot.timings) {
    const std::string title = timing.function + (timing.cold ? ", caches swept" : "");
    if (title != function) {
      function = title;
      ours = timing.median;
      fmt::print("  {}\n", function);
    }
    fmt::print("    {:<12} {:>8.0f} {:>8.0f} {:>8.0f}   {:>6.2f}\n", timing.who, timing.min,
               timing.median, timing.p90, timing.median / ours);
  }
  for (const auto& [who, difference] : robot.differences) {
    fmt::print("  {} agrees to {:.1e}\n", who, difference);
  }
  for (const std::string& absent : robot.absent) {
    fmt::print("  absent: {}\n", absent);
  }
}

json to_json(const CycleFigures& cycle) {
  json out{{"joints", cycle.joints},
           {"buses", cycle.buses},
           {"cycles", cycle.cycles},
           {"heap_bytes_grown", cycle.heap_bytes_grown},
           {"object_bytes", cycle.object_bytes},
           {"state", cycle.state},
           {"ns", json::object()}};
  for (const Phase& phase : cycle.phases) {
    out["ns"][phase.name] = {{"min", phase.min}, {"median", phase.median}, {"p99", phase.p99}};
  }
  return out;
}

void print(const CycleFigures& cycle) {
  fmt::print("\n{} joints on {} bus(es), {} cycles, state {}; us: min / median / 99 %\n",
             cycle.joints, cycle.buses, cycle.cycles, cycle.state);
  for (const Phase& phase : cycle.phases) {
    fmt::print("    {:<12} {:>8.2f} {:>8.2f} {:>8.2f}\n", phase.name, phase.min * 1e-3,
               phase.median * 1e-3, phase.p99 * 1e-3);
  }
  fmt::print("  heap grown while cycling: {} bytes; before: {} bytes\n", cycle.heap_bytes_grown,
             cycle.object_bytes);
}

/// @param figures  a vector of what print() and to_json() know
template <typename Figures>
void show(const Figures& figures, bool as_json) {
  json all = json::array();
  for (const auto& each : figures) {
    if (as_json) {
      all.push_back(to_json(each));
    } else {
      print(each);
    }
  }
  if (as_json) {
    fmt::print("{}\n", all.dump(1));
  }
}

int run(int argc, char** argv) {
  CLI::App app("Prints figures; asserts nothing. tests/bench/run composes the whole report.");
  app.require_subcommand(1);
  bool as_json = false;

  DynamicsOptions dynamics;
  dynamics.peers = std::filesystem::canonical("/proc/self/exe").parent_path().string();
  CLI::App* timed = app.add_subcommand("dynamics", "beside Orocos KDL and MuJoCo");
  timed->add_option("URDF", dynamics.robots)->check(CLI::ExistingFile);
  timed->add_option("--floating", dynamics.floating, "URDFs whose root link floats")
      ->check(CLI::ExistingFile);
  timed->add_option("--compiled", dynamics.compiled, "folder of models compiled ahead, NAME.so")
      ->check(CLI::ExistingDirectory);
  timed->add_option("--rounds", dynamics.rounds)
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  timed->add_option("--slice", dynamics.slice_us, "one contender's turn [us]")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  timed->add_option("--cold", dynamics.cold_rounds, "rounds with swept caches")
      ->check(CLI::Range(0, 100000))
      ->capture_default_str();
  timed->add_flag("--json", as_json);

  std::string who;
  std::string function;
  long calls = 0;
  CLI::App* counted = app.add_subcommand("call", "one function, for an instruction counter");
  counted->add_option("URDF", dynamics.robots)->expected(0, 1)->check(CLI::ExistingFile);
  counted->add_option("--floating", dynamics.floating)->expected(0, 1)->check(CLI::ExistingFile);
  counted->add_option("--compiled", dynamics.compiled)->check(CLI::ExistingDirectory);
  counted->add_option("--who", who, "Geodesic, KDL, \"KDL merged\", MuJoCo")->required();
  counted->add_option("--function", function, "bias, gravity, ...")->required();
  counted->add_option("--calls", calls)->required()->check(CLI::NonNegativeNumber);

  CycleOptions cycle;
  CLI::App* cycled = app.add_subcommand("cycle", "the daemon's cycle by phase, on a bus in memory");
  cycled->add_option("JOINTS", cycle.joints, "1 to 32")->check(CLI::Range(1, 32));
  cycled->add_option("--cycles", cycle.cycles)
      ->check(CLI::Range(10L, 100'000'000L))
      ->capture_default_str();
  cycled->add_flag("--json", as_json);

  CLI11_PARSE(app, argc, argv);
  if (!cycled->parsed() && dynamics.robots.empty() && dynamics.floating.empty()) {
    throw std::runtime_error("no robot: give a URDF, or --floating URDF");
  }
  if (timed->parsed()) {
    show(measure_dynamics(dynamics), as_json);
  } else if (counted->parsed()) {
    call_only(dynamics, who, function, calls);
  } else {
    show(measure_cycle(cycle), as_json);
  }
  return 0;
}

}  // namespace
}  // namespace geodesic::bench

int main(int argc, char** argv) {
  try {
    return geodesic::bench::run(argc, argv);
  } catch (const std::exception& error) {
    fmt::print(stderr, "geodesic_bench: {}\n", error.what());
    return 1;
  }
}
