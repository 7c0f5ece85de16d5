// `geodesic check`: all of the validation, the bus budget, and the model in plain words.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "config/budget.hpp"
#include "config/setup.hpp"
#include "tools/geodesic/command.hpp"
#include "tools/geodesic/timeline.hpp"
#include "tools/geodesic/workload.hpp"

namespace geodesic::tools {
namespace {

using nlohmann::ordered_json;

struct CheckArguments {
  RobotArguments robot;
  bool json = false;
  std::string plot;
};

constexpr const char* kExamples =
    "  geodesic check config/robots/openarm/robot.toml\n"
    "  geodesic check robot.toml --strict --json\n"
    "  geodesic check robot.toml --plot cycle.png";

ordered_json figure(double value) {
  return std::isfinite(value) ? ordered_json(value) : ordered_json(nullptr);
}

ordered_json report_json(const config::Robot& robot, const control::Mechanism& mechanism,
                         const config::BudgetReport& budget, const Workload& workload) {
  ordered_json buses = ordered_json::array();
  for (std::size_t i = 0; i < budget.buses.size(); ++i) {
    const drivers::BusOptions& bus = robot.arm.buses[i];
    const config::BusLoad& load = budget.buses[i];
    buses.push_back({{"name", load.name},
                     {"interface", load.interface},
                     {"fd", bus.fd},
                     {"bit_rate", bus.bit_rate},
                     {"data_bit_rate", bus.fd ? ordered_json(bus.data_bit_rate) : nullptr},
                     {"drives", load.drives},
                     {"frames", load.budget().frames},
                     {"best_us", static_cast<double>(load.budget().best_ns) * 1e-3},
                     {"worst_us", static_cast<double>(load.budget().worst_ns) * 1e-3},
                     {"worst_load", load.budget().worst_load},
                     {"usable", load.budget().usable},
                     {"max_rate_hz", load.budget().max_rate_hz},
                     {"arithmetic", load.arithmetic},
                     {"timeline", timeline_json(robot, i, load)}});
  }
  ordered_json joints = ordered_json::array();
  for (std::size_t i = 0; i < workload.joints.size(); ++i) {
    const JointWorkload& joint = workload.joints[i];
    joints.push_back({{"name", robot.arm.joints[i].name},
                      {"gravity_max", joint.gravity_max},
                      {"worst_pose", joint.worst_pose},
                      {"available", figure(joint.available)},
                      {"torque_limit", figure(joint.torque_limit)},
                      {"drive_range", figure(joint.drive_range)},
                      {"effort", figure(joint.effort)},
                      {"enough", joint.gravity_max <= joint.available}});
  }
  return {{"robot", robot.name},
          {"file", robot.file.string()},
          {"urdf", robot.urdf.string()},
          {"rate_hz", 1e9 / static_cast<double>(robot.period_ns)},
          {"moving_mass_kg", mechanism.moving_mass()},
          {"reach_m", workload.reach_m},
          {"buses", std::move(buses)},
          {"joints", std::move(joints)}};
}

void print_buses(const config::Robot& robot, const config::BudgetReport& budget) {
  fmt::print("\n{:<13} {:<13} {:<18}{:>7}{:>12}{:>12}{:>8}{:>11}\n", "bus", "interface", "bit/s",
             "frames", "best [us]", "worst [us]", "load", "at most");
  for (std::size_t i = 0; i < budget.buses.size(); ++i) {
    const drivers::BusOptions& bus = robot.arm.buses[i];
    const drivers::BusBudget& load = budget.buses[i].budget();
    const std::string rate = bus.fd ? fmt::format("{}/{} FD", bus.bit_rate, bus.data_bit_rate)
                                    : fmt::format("{}", bus.bit_rate);
    fmt::print("{:<13} {:<13} {:<18}{:>7}{:>12.1f}{:>12.1f}{:>7.0f}%{:>8.0f} Hz\n", bus.name,
               bus.interface, rate, load.frames, static_cast<double>(load.best_ns) * 1e-3,
               static_cast<double>(load.worst_ns) * 1e-3, 100.0 * load.worst_load,
               load.max_rate_hz);
  }
  for (const config::BusLoad& load : budget.buses) fmt::print("{}\n", load.arithmetic);
}

void print_model(const config::Robot& robot, const control::Mechanism& mechanism,
                 const Workload& workload) {
  fmt::print("\n{:.3f} kg move; the tool ({}) reaches {:.3f} m from the first joint.\n",
             mechanism.moving_mass(), robot.tool_link.empty() ? "last link" : robot.tool_link,
             workload.reach_m);
  fmt::print("gravity pulls along ({:g}, {:g}, {:g}) m/s².\n\n", robot.gravity.x(),
             robot.gravity.y(), robot.gravity.z());
  fmt::print("{:<28}{:>12}{:>12}{:>12}{:>12}{:>8}\n", "joint", "gravity", "limit", "drive", "urdf",
             "used");
  for (std::size_t i = 0; i < workload.joints.size(); ++i) {
    const JointWorkload& joint = workload.joints[i];
    fmt::print("{:<28}{:>12.3f}{:>12.3f}{:>12.3f}{:>12.3f}{:>7.0f}%{}\n", robot.arm.joints[i].name,
               joint.gravity_max, joint.torque_limit, joint.drive_range, joint.effort,
               100.0 * joint.gravity_max / joint.available,
               joint.gravity_max > joint.available ? "  NOT ENOUGH" : "");
  }
  fmt::print("(torques in N·m, forces in N; gravity: the largest found over all poses)\n");
}

/// What each payload asks of the joints.
std::vector<Workload> payload_workloads(const config::Robot& robot, int tool) {
  std::vector<Workload> workloads;
  for (std::size_t i = 0; i < robot.payloads.size(); ++i) {
    workloads.push_back(find_workload(robot, config::make_mechanism(robot, i), tool));
  }
  return workloads;
}

bool is_enough(const Workload& workload) {
  return std::all_of(workload.joints.begin(), workload.joints.end(),
                     [](const auto& joint) { return joint.gravity_max <= joint.available; });
}

ordered_json payloads_json(const config::Robot& robot, const std::vector<Workload>& workloads) {
  ordered_json list = ordered_json::array();
  for (std::size_t i = 0; i < workloads.size(); ++i) {
    ordered_json worst = ordered_json::array();
    for (const JointWorkload& joint : workloads[i].joints) worst.push_back(joint.gravity_max);
    list.push_back({{"name", robot.payloads[i].name},
                    {"link", robot.payloads[i].link},
                    {"mass_kg", robot.payloads[i].inertia.mass_kg},
                    {"gravity_max", std::move(worst)},
                    {"enough", is_enough(workloads[i])}});
  }
  return list;
}

void print_payloads(const config::Robot& robot, const std::vector<Workload>& workloads) {
  for (std::size_t i = 0; i < workloads.size(); ++i) {
    const auto used = [](const JointWorkload& joint) {
      return joint.gravity_max / joint.available;
    };
    const std::vector<JointWorkload>& joints = workloads[i].joints;
    const auto worst =
        std::max_element(joints.begin(), joints.end(),
                         [&](const auto& a, const auto& b) { return used(a) < used(b); });
    if (worst == joints.end()) continue;
    fmt::print("payload {} ({:g} kg at {}): most asked of {}, {:.3f} of {:.3f}, {:.0f}%{}\n",
               robot.payloads[i].name, robot.payloads[i].inertia.mass_kg, robot.payloads[i].link,
               robot.arm.joints[static_cast<std::size_t>(worst - joints.begin())].name,
               worst->gravity_max, worst->available, 100.0 * used(*worst),
               is_enough(workloads[i]) ? "" : "  NOT ENOUGH");
  }
}

int run_check(const CheckArguments& arguments) {
  config::LoadResult result = config::load_robot(
      arguments.robot.file, {arguments.robot.strict, arguments.robot.buses, {}, {}});
  for (const config::Message& message : result.messages) {
    fmt::print(stderr, "{}\n", config::to_string(message));
  }
  if (!result.ok) {
    if (arguments.json) {
      const ordered_json answer{{"ok", false}, {"messages", to_json(result.messages)}};
      fmt::print("{}\n", answer.dump(2));
    }
    return kExitRefused;
  }
  const config::Robot& robot = result.robot;
  const control::Mechanism mechanism(robot.tree, robot.gravity);
  const int tool =
      mechanism.find_link(robot.tool_link).value_or(static_cast<int>(mechanism.links().size()) - 1);
  const Workload workload = find_workload(robot, mechanism, tool);
  const config::BudgetReport budget = config::bus_budget(robot);

  if (!arguments.plot.empty()) draw_timelines(robot, budget, arguments.plot);
  const std::vector<Workload> carried = payload_workloads(robot, tool);
  const bool enough = is_enough(workload) && (!robot.payload || is_enough(carried[*robot.payload]));
  const bool ok = enough || !arguments.robot.strict;
  if (arguments.json) {
    ordered_json answer{{"ok", ok}, {"messages", to_json(result.messages)}};
    answer.update(report_json(robot, mechanism, budget, workload));
    answer["payloads"] = payloads_json(robot, carried);
    fmt::print("{}\n", answer.dump(2));
  } else {
    fmt::print("{}: robot {}, {} joints on {} bus{}, {:g} Hz, {} warning{}\n", arguments.robot.file,
               robot.name, robot.arm.joints.size(), robot.arm.buses.size(),
               robot.arm.buses.size() == 1 ? "" : "es", 1e9 / static_cast<double>(robot.period_ns),
               result.messages.size(), result.messages.size() == 1 ? "" : "s");
    print_buses(robot, budget);
    print_timelines(robot, budget);
    print_model(robot, mechanism, workload);
    print_payloads(robot, carried);
  }
  if (!enough) {
    fmt::print(stderr,
               "{}: {}: a joint cannot hold the arm in every pose its limits allow (NOT ENOUGH)\n",
               arguments.robot.file, arguments.robot.strict ? "error" : "warning");
  }
  return ok ? kExitOk : kExitRefused;
}

}  // namespace

void add_check(CLI::App& app, Run& run) {
  auto arguments = std::make_shared<CheckArguments>();
  CLI::App* command = app.add_subcommand(
      "check",
      "Is the robot's file right? A cycle on the wire, masses, reach, worst gravity torques");
  add_robot(*command, arguments->robot);
  command->add_flag("--strict", arguments->robot.strict,
                    "warnings of the model, and joints too weak to hold the arm, are errors");
  command->add_flag("--json", arguments->json, "the report as one JSON object");
  command->add_option("--plot", arguments->plot,
                      "draw a cycle on the wire there (PNG, SVG or PDF); needs python3-matplotlib");
  command->footer(footer(kExamples));
  command->callback([arguments, &run] { run = [arguments] { return run_check(*arguments); }; });
}

}  // namespace geodesic::tools
