// `geodesic doctor`: what keeps this machine, its buses and its drives from working on time. What
// is looked at is in doctor_looks; here is who is asked for what, and how it is shown.
#include <fmt/format.h>
#include <poll.h>
#include <sys/xattr.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "drivers/bus/unix_address.hpp"
#include "tools/geodesic/command.hpp"
#include "tools/geodesic/doctor_looks.hpp"
#include "tools/sim/stop_signals.hpp"

namespace geodesic::tools {
namespace {

using nlohmann::ordered_json;

struct DoctorArguments {
  RobotArguments robot;
  std::string root = "/";
  int exchanges = 200;
  bool no_drives = false;
  bool json = false;
};

constexpr const char* kExamples =
    "  geodesic doctor                           the machine and its CAN interfaces\n"
    "  geodesic doctor robot.toml                and the robot's buses and drives\n"
    "  geodesic doctor robot.toml --no-drives --json";

/// geodesicd as it lies beside this program.
void find_daemon(Wishes& wishes) {
  std::error_code none;
  const std::filesystem::path self = std::filesystem::read_symlink("/proc/self/exe", none);
  const std::filesystem::path daemon = self.parent_path() / "geodesicd";
  if (none || !std::filesystem::exists(daemon, none)) return;
  wishes.program = daemon.string();
  wishes.file_capabilities = ::getxattr(daemon.c_str(), "security.capability", nullptr, 0) > 0;
}

void look_at_buses(const SystemTree& system, bool live,
                   const std::vector<drivers::BusOptions>& buses, const Wishes& wishes,
                   Findings& findings) {
  drivers::KernelLinkPort port;
  for (const drivers::BusOptions& bus : buses) {
    if (drivers::is_socket_bus(bus.interface)) {
      look_at_socket_bus(bus, findings);
    } else if (live) {
      look_at_bus(system, port, bus, wishes, findings);
    }
  }
}

/// Without a robot file: every CAN interface, as it is set up.
std::vector<drivers::BusOptions> interfaces_as_they_are() {
  std::vector<drivers::BusOptions> buses;
  for (const drivers::CanLink& link : drivers::KernelLinkPort().all()) {
    drivers::BusOptions options;
    options.name = link.name;
    options.interface = link.name;
    options.fd = link.fd;
    options.bit_rate = link.nominal.bit_rate.value_or(options.bit_rate);
    options.data_bit_rate = link.data.bit_rate.value_or(options.data_bit_rate);
    buses.push_back(options);
  }
  return buses;
}

std::size_t count(const Findings& findings, Grade grade) {
  return static_cast<std::size_t>(
      std::count_if(findings.begin(), findings.end(),
                    [grade](const Finding& finding) { return finding.grade == grade; }));
}

void print_text(const Findings& findings) {
  std::string area;
  for (const Finding& finding : findings) {
    if (finding.area != area) fmt::print("{}\n", finding.area);
    area = finding.area;
    fmt::print("  {:<5}{:<15}{}\n", to_string(finding.grade), finding.what, finding.text);
    if (!finding.fix.empty()) fmt::print("       {:<15}{}\n", "fix:", finding.fix);
  }
  fmt::print("{} OK, {} WARN, {} BAD\n", count(findings, Grade::kOk), count(findings, Grade::kWarn),
             count(findings, Grade::kBad));
}

void print_json(const Findings& findings) {
  ordered_json list = ordered_json::array();
  for (const Finding& finding : findings) {
    list.push_back({{"grade", to_string(finding.grade)},
                    {"area", finding.area},
                    {"what", finding.what},
                    {"text", finding.text},
                    {"fix", finding.fix}});
  }
  const ordered_json object{{"ok", count(findings, Grade::kBad) == 0},
                            {"warnings", count(findings, Grade::kWarn)},
                            {"bad", count(findings, Grade::kBad)},
                            {"findings", std::move(list)}};
  fmt::print("{}\n", object.dump(2, ' ', false, ordered_json::error_handler_t::replace));
}

int run_doctor(const DoctorArguments& arguments) {
  std::optional<config::Robot> robot;
  if (!arguments.robot.file.empty()) robot = load(arguments.robot);
  const bool live = arguments.root == "/";
  const SystemTree system(arguments.root);
  if (!live && !system.exists("/")) {
    throw BadInput(fmt::format("--root {}: there is no such folder", arguments.root));
  }
  Wishes wishes;
  if (live) find_daemon(wishes);
  std::vector<drivers::BusOptions> buses;
  if (robot) {
    wishes.priority = robot->realtime.priority;
    wishes.cpus = robot->realtime.cpus;
    buses = robot->arm.buses;
    wishes.bring_up =
        std::any_of(buses.begin(), buses.end(), [](const auto& bus) { return bus.bring_up; });
  } else if (live) {
    buses = interfaces_as_they_are();
  }
  Findings findings;
  look_at_kernel(system, findings);
  look_at_processors(system, wishes, findings);
  look_at_rights(system, wishes, findings);
  look_at_buses(system, live, buses, wishes, findings);
  bool stopped = false;
  if (robot && live && !arguments.no_drives) {
    const StopSignals signals;
    const auto stop = [&] {
      // Signals are let through only where somebody waits for them: for a moment, here.
      const timespec none{0, 0};
      ::ppoll(nullptr, 0, &none, &signals.waiting_mask());
      return signals.requested().load();
    };
    for (std::size_t i = 0; i < robot->arm.joints.size() && !stop(); ++i) {
      look_at_drive(robot->arm, i, robot->period_ns, arguments.exchanges, stop, findings);
    }
    stopped = signals.requested().load();
  }
  if (arguments.json) {
    print_json(findings);
  } else {
    print_text(findings);
  }
  if (stopped) throw BadInput("stopped before the end: not every drive was asked");
  return count(findings, Grade::kBad) == 0 ? kExitOk : kExitRefused;
}

}  // namespace

const char* to_string(Grade grade) {
  switch (grade) {
    case Grade::kOk:
      return "OK";
    case Grade::kWarn:
      return "WARN";
    case Grade::kBad:
      return "BAD";
  }
  return "?";
}

void add_doctor(CLI::App& app, Run& run) {
  auto arguments = std::make_shared<DoctorArguments>();
  CLI::App* command = app.add_subcommand(
      "doctor", "What keeps this machine, its buses and drives from working on time");
  add_robot(*command, arguments->robot);
  command->get_option("ROBOT.toml")->required(false);
  command->add_option("--root", arguments->root,
                      "read /proc, /sys and /dev under this folder, such as a copy of another "
                      "machine's; no bus is touched then");
  command->add_option("--exchanges", arguments->exchanges, "questions to each drive (default 200)")
      ->check(CLI::Range(1, 100000));
  command->add_flag("--no-drives", arguments->no_drives, "do not ask the robot's drives");
  command->add_flag("--json", arguments->json, "all findings as one JSON object");
  command->footer(
      "\nEvery finding is OK, WARN (works, but not always on time) or BAD (does not work), with "
      "the "
      "command\nthat mends it. Exit status 1 if anything is BAD. Drives are asked one after the "
      "other as the daemon\ndoes before it enables anything: they are checked against the robot "
      "file, get its watchdog time,\nand one that somebody left enabled is disabled. A bus that a "
      "daemon commands is left alone." +
      footer(kExamples));
  command->callback([arguments, &run] { run = [arguments] { return run_doctor(*arguments); }; });
}

}  // namespace geodesic::tools
