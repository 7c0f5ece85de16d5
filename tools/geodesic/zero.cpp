// `geodesic zero`: makes where a joint's drive stands its zero, with people. What is said to the
// drive is its family's; the record is zero_record's.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <memory>

#include "drivers/families.hpp"
#include "tools/geodesic/bench_bus.hpp"
#include "tools/geodesic/command.hpp"
#include "tools/geodesic/joint_choice.hpp"
#include "tools/geodesic/zero_record.hpp"
#include "tools/sim/stop_signals.hpp"

namespace geodesic::tools {
namespace {

struct ZeroArguments {
  RobotArguments robot;
  std::string joint;
  bool yes = false;
  bool json = false;
};

constexpr const char* kExamples =
    "  geodesic zero robot.toml elbow            asks before it writes\n"
    "  geodesic zero robot.toml elbow --yes --json";

std::string angle(double value_rad) {
  return std::isfinite(value_rad) ? fmt::format("{:+.4f} rad", value_rad) : "not told";
}

/// What is about to happen, for whoever stands at the arm.
void explain(std::FILE* out, const config::Robot& robot, std::size_t index) {
  const drivers::JointOptions& joint = robot.arm.joints[index];
  fmt::print(
      out,
      "joint {}: drive 0x{:X} ({}) on {}\n"
      "  1. Nothing may command the bus. Support the joint: its drive stays without "
      "torque.\n"
      "  2. Bring the joint to its mark: where the robot file says {:+.4f} {} (its "
      "`offset`).\n"
      "  3. The drive then counts 0 there and keeps that over power-off. It is refused if "
      "the\n"
      "     drive is enabled, moves or has an error; afterwards the position is read back.\n",
      joint.name, joint.drive.id, joint.drive.family, robot.arm.buses[joint.bus].interface,
      joint.offset, unit_of(robot, index));
}

bool agreed(std::FILE* out) {
  fmt::print(out, "The joint stands at its mark: write its zero? Type yes: ");
  std::fflush(out);
  std::string answer;
  std::getline(std::cin, answer);
  return answer == "yes";
}

int run_zero(const ZeroArguments& arguments) {
  const config::Robot robot = load(arguments.robot);
  const std::size_t index = choose_joint(robot, arguments.joint);
  const drivers::JointOptions& joint = robot.arm.joints[index];
  const drivers::BusOptions& bus_options = robot.arm.buses[joint.bus];
  const drivers::Family* family = drivers::find_family(joint.drive.family);
  std::unique_ptr<drivers::Zeroing> zeroing;
  if (family != nullptr && family->make_zeroing != nullptr) {
    drivers::DriveOptions options = joint.drive;
    options.leader = true;
    zeroing = family->make_zeroing(options);
  }
  if (!zeroing) {
    throw BadInput(fmt::format("a {} drive cannot be zeroed over the bus: use its vendor's tool",
                               joint.drive.family));
  }
  const std::filesystem::path file = zero_record_file(robot.file);
  prepare_record(file);
  BenchBus bus(device_of(bus_options.interface), bus_options.fd);

  std::FILE* const out = arguments.json ? stderr : stdout;
  explain(out, robot, index);
  if (!arguments.yes && !agreed(out)) throw BadInput("not agreed to: nothing was written");

  const StopSignals signals;
  const DialogueEnd end = bus.hold(*zeroing, signals.requested(), signals.waiting_mask());
  ZeroRecord record{utc_now(),
                    who_am_i(),
                    joint.name,
                    bus_options.interface,
                    joint.drive.family,
                    joint.drive.id,
                    zeroing->done(),
                    zeroing->before_rad(),
                    zeroing->after_rad(),
                    zeroing->report()};
  if (end == DialogueEnd::kDeaf) record.report = deaf_text(bus_options.interface);
  if (end == DialogueEnd::kStopped) {
    record.report = "stopped halfway: the zero may be the old one or the new; zero it again";
  }
  if (end == DialogueEnd::kEndless) record.report = "the drive's dialogue did not end";
  append_record(file, record);
  if (arguments.json) fmt::print("{}", to_json_line(record));
  if (!record.done) throw BadInput(fmt::format("joint {}: {}", joint.name, record.report));
  fmt::print(out, "done: {}; before {}, read back {}; recorded in {}\n", record.report,
             angle(record.before_rad), angle(record.after_rad), file.string());
  return kExitOk;
}

}  // namespace

void add_zero(CLI::App& app, Run& run) {
  auto arguments = std::make_shared<ZeroArguments>();
  CLI::App* command =
      app.add_subcommand("zero", "Make where a joint stands its drive's zero, and read it back");
  add_robot(*command, arguments->robot);
  command->add_option("JOINT", arguments->joint, "the joint's name in the robot file")->required();
  command->add_flag("--yes", arguments->yes, "do not ask before the zero is written");
  command->add_flag("--json", arguments->json, "print the record's line instead of sentences");
  command->footer(
      "\nEvery attempt is appended to ROBOT.zeros.jsonl beside the robot file: when, who, joint, "
      "drive,\nposition before and after. Refused while a daemon commands the bus, and by drives "
      "that are\nenabled, move or have an error. The robot file is not changed: at the new zero "
      "the joint counts\nwhat it says as `offset`." +
      footer(kExamples));
  command->callback([arguments, &run] { run = [arguments] { return run_zero(*arguments); }; });
}

}  // namespace geodesic::tools
