// What every subcommand of `geodesic` shares; see the header.
#include "tools/geodesic/command.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "tools/geodesicd/output_file.hpp"

namespace geodesic::tools {

void add_robot(CLI::App& command, RobotArguments& arguments) {
  command.add_option("ROBOT.toml", arguments.file, "the robot's file")->required();
  command
      .add_option("--bus", arguments.buses,
                  "use this interface instead of the file's (can0, vcan0, unix:PATH); once for all "
                  "buses, or once for each in the file's order")
      ->type_size(1)
      ->allow_extra_args(false);
}

config::Robot load(const RobotArguments& arguments) {
  config::LoadResult result =
      config::load_robot(arguments.file, {arguments.strict, arguments.buses, {}, {}});
  for (const config::Message& message : result.messages) {
    fmt::print(stderr, "{}\n", config::to_string(message));
  }
  if (!result.ok) throw BadInput("");
  return std::move(result.robot);
}

nlohmann::ordered_json to_json(const std::vector<config::Message>& messages) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const config::Message& message : messages) {
    const bool error = message.severity == config::Message::Severity::kError;
    list.push_back({{"severity", error ? "error" : "warning"},
                    {"file", message.place.file.string()},
                    {"line", message.place.line},
                    {"column", message.place.column},
                    {"text", message.text}});
  }
  return list;
}

std::string footer(const std::string& examples) {
  return "\nExit status: 0 ok, 1 bad input or refused, 2 wrong call, 3 ended in a fault.\n\n"
         "Examples:\n" +
         examples;
}

void write_file(const std::string& file, const std::string& text) {
  if (const auto problem = write_output(file, text)) throw BadInput(*problem);
}

}  // namespace geodesic::tools
