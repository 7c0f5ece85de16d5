// `geodesic decode`: candump lines to joints and SI units. What bytes mean is the drive families'.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "config/findings.hpp"
#include "tools/geodesic/candump.hpp"
#include "tools/geodesic/command.hpp"
#include "tools/geodesic/frame_meaning.hpp"
#include "tools/geodesic/scan_proposal.hpp"

namespace geodesic::tools {
namespace {

struct DecodeArguments {
  RobotArguments robot;
  std::string file;
  std::string family;
  std::uint32_t id = 0;
  std::uint32_t reply_id = 0;
  std::vector<std::string> options;
  bool json = false;
};

constexpr const char* kExamples =
    "  candump -L can0 | geodesic decode robot.toml              live\n"
    "  geodesic decode robot.toml candump-2026-11-22.log\n"
    "  candump -L can0 | geodesic decode --family moteus --id 3   no robot file yet\n"
    "  geodesic decode --family damiao --id 1 --reply-id 0x11 --set torque_range_nm=28 log.txt\n"
    "  geodesic decode robot.toml log.txt --bus vcan0 --json     recorded on vcan0";

void print_text(const CandumpLine& line, const FrameMeaning& meaning) {
  std::string text = line.time.empty() ? "" : "(" + line.time + ") ";
  text +=
      fmt::format("{} {:0{}X} {}: {}", line.interface, line.frame.id, line.frame.extended ? 8 : 3,
                  meaning.joint.empty() ? "-" : meaning.joint, meaning.kind);
  for (const drivers::DecodedField& field : meaning.fields) {
    text += fmt::format("  {} {}{}{}", field.name, field.value, field.unit.empty() ? "" : " ",
                        field.unit);
  }
  fmt::print("{}\n", text);
}

void print_json(const CandumpLine& line, const FrameMeaning& meaning) {
  nlohmann::ordered_json fields = nlohmann::ordered_json::array();
  for (const drivers::DecodedField& field : meaning.fields) {
    fields.push_back({{"name", field.name}, {"value", field.value}, {"unit", field.unit}});
  }
  const nlohmann::ordered_json object{
      {"time", line.time},          {"interface", line.interface},
      {"id", line.frame.id},        {"extended", line.frame.extended},
      {"fd", line.frame.fd},        {"remote", line.frame.remote},
      {"joint", meaning.joint},     {"kind", meaning.kind},
      {"fields", std::move(fields)}};
  fmt::print("{}\n", object.dump());
}

/// A drive by itself: what the command line says of it, and the rest as is usual.
config::Robot lone_drive(const DecodeArguments& arguments) {
  const drivers::Family* family = drivers::find_family(arguments.family);
  if (family == nullptr) {
    std::vector<std::string> known;
    for (const drivers::Family& one : drivers::families()) known.emplace_back(one.name);
    throw BadInput(fmt::format(
        "--family: there is no family {}{}; families: {}", config::quote(arguments.family),
        config::did_you_mean(arguments.family, known), config::list_names(known)));
  }
  // The scanner's answer and these words are the same thing: keys of [joint.drive].
  Sighting drive{"", arguments.family, false, {}};
  drive.drive.id = arguments.id;
  drive.drive.reply_id = arguments.reply_id;
  for (const std::string& option : arguments.options) {
    const std::size_t equals = option.find('=');
    if (equals == std::string::npos) {
      throw BadInput(fmt::format("--set {}: expected KEY=VALUE, with a key of [joint.drive]",
                                 config::quote(option)));
    }
    const std::string key = option.substr(0, equals);
    std::vector<std::string> known{"position_range_rad", "velocity_range_rad_s", "torque_range_nm"};
    for (const drivers::DriveSetting& one : family->settings) known.emplace_back(one.key);
    if (std::find(known.begin(), known.end(), key) == known.end()) {
      throw BadInput(fmt::format("--set: a {} drive has no {}{}; it has {}", family->name,
                                 config::quote(key), config::did_you_mean(key, known),
                                 config::list_names(known)));
    }
    drive.drive.options.emplace_back(key, option.substr(equals + 1));
  }
  config::Robot robot;
  drivers::JointOptions joint;
  joint.name = fmt::format("0x{:X}", arguments.id);
  joint.drive = options_of(drive);
  // Nobody says which bus the frames are of; some families speak on CAN FD only.
  std::vector<std::string> wrong = family->check(joint.drive);
  if (!wrong.empty()) {
    joint.drive.fd = true;
    const std::vector<std::string> on_fd = family->check(joint.drive);
    if (on_fd.size() < wrong.size()) wrong = on_fd;
  }
  if (!wrong.empty()) throw BadInput(wrong.front() + " (say it by --id, --reply-id or --set)");
  robot.arm.joints.push_back(joint);
  robot.arm.buses.emplace_back();
  return robot;
}

int run_decode(DecodeArguments arguments) {
  const bool lone = !arguments.family.empty();
  if (lone && arguments.file.empty()) arguments.file = std::exchange(arguments.robot.file, {});
  if (lone != arguments.robot.file.empty()) {
    throw BadInput(lone ? "ROBOT.toml or --family, not both"
                        : "whose frames are they? name ROBOT.toml, or --family and --id");
  }
  const config::Robot robot = lone ? lone_drive(arguments) : load(arguments.robot);
  std::ifstream opened;
  const bool live = arguments.file.empty() || arguments.file == "-";
  if (!live) {
    opened.open(arguments.file);
    if (!opened) {
      throw BadInput("cannot read " + arguments.file + ": " + std::strerror(errno));
    }
  }
  std::istream& in = live ? std::cin : opened;
  const std::string name = live ? "standard input" : arguments.file;

  std::size_t number = 0;
  std::size_t bad = 0;
  std::string text;
  std::string why;
  while (std::getline(in, text)) {
    ++number;
    const std::optional<CandumpLine> line = parse_candump(text, why);
    if (!line) {
      if (why.empty()) continue;
      ++bad;
      fmt::print(stderr, "{}:{}: error: {}\n", name, number, why);
      continue;
    }
    const FrameMeaning meaning = meaning_of(*line, robot);
    if (arguments.json) {
      print_json(*line, meaning);
    } else {
      print_text(*line, meaning);
    }
    if (live) std::fflush(stdout);
  }
  if (bad > 0) fmt::print(stderr, "{} of {} lines could not be read\n", bad, number);
  return bad > 0 ? kExitRefused : kExitOk;
}

}  // namespace

void add_decode(CLI::App& app, Run& run) {
  auto arguments = std::make_shared<DecodeArguments>();
  CLI::App* command = app.add_subcommand(
      "decode", "What the frames of a candump mean, in SI units, with the joint's name");
  add_robot(*command, arguments->robot);
  command->get_option("ROBOT.toml")->required(false);
  command->add_option("--family", arguments->family,
                      "without a robot file: frames of one drive of this family");
  command->add_option("--id", arguments->id, "that drive's id, as in [joint.drive]");
  command->add_option("--reply-id", arguments->reply_id, "its reply_id, where its family has one");
  command
      ->add_option("--set", arguments->options,
                   "KEY=VALUE of [joint.drive], such as its scaling; repeatable")
      ->type_size(1)
      ->allow_extra_args(false);
  command->add_option("FILE", arguments->file, "lines of `candump -L` (default: standard input)");
  command->add_flag("--json", arguments->json, "one JSON object a line");
  command->footer(
      "\nFigures are the drive's own (before the joint's direction, ratio and offset). Where the "
      "log\n"
      "names another interface than the robot's file, say so by --bus; with one bus it does not "
      "matter.\nA frame that says the same to several drives names them all." +
      footer(kExamples));
  command->callback([arguments, &run] { run = [arguments] { return run_decode(*arguments); }; });
}

}  // namespace geodesic::tools
