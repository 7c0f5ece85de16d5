// `geodesic decode`: candump lines to joints and SI units. What bytes mean is the drive families'.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "tools/geodesic/candump.hpp"
#include "tools/geodesic/command.hpp"
#include "tools/geodesic/frame_meaning.hpp"

namespace geodesic::tools {
namespace {

struct DecodeArguments {
  RobotArguments robot;
  std::string file;
  bool json = false;
};

constexpr const char* kExamples =
    "  candump -L can0 | geodesic decode robot.toml              live\n"
    "  geodesic decode robot.toml candump-2026-11-22.log\n"
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
  const nlohmann::ordered_json object{{"time", line.time},    {"interface", line.interface},
                                      {"id", line.frame.id},  {"extended", line.frame.extended},
                                      {"fd", line.frame.fd},  {"joint", meaning.joint},
                                      {"kind", meaning.kind}, {"fields", std::move(fields)}};
  fmt::print("{}\n", object.dump());
}

int run_decode(const DecodeArguments& arguments) {
  const config::Robot robot = load(arguments.robot);
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
  command->add_option("FILE", arguments->file, "lines of `candump -L` (default: standard input)");
  command->add_flag("--json", arguments->json, "one JSON object a line");
  command->footer(
      "\nFigures are the drive's own (before the joint's direction, ratio and offset). Where the "
      "log\n"
      "names another interface than the robot's file, say so by --bus; with one bus it does not "
      "matter." +
      footer(kExamples));
  command->callback([arguments, &run] { run = [arguments] { return run_decode(*arguments); }; });
}

}  // namespace geodesic::tools
