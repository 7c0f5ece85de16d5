// `geodesic tune`: changes what the running daemon runs on, takes it back, and puts it into the
// file.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "config/write_back.hpp"
#include "tools/geodesic/command.hpp"
#include "tools/geodesic/daemon_link.hpp"

namespace geodesic::tools {
namespace {

using nlohmann::json;

struct TuneArguments {
  DaemonArguments daemon;
  std::vector<std::string> values;
  bool undo = false;
  bool list = false;
  bool write = false;
};

constexpr const char* kExamples =
    "  geodesic tune robot.toml joint.elbow.hold_stiffness=30 joint.elbow.hold_damping=1.2\n"
    "  geodesic tune robot.toml payload=gripper_box\n"
    "  geodesic tune robot.toml --undo\n"
    "  geodesic tune robot.toml --list | grep elbow\n"
    "  geodesic tune robot.toml --write          put what is tuned into robot.toml";

/// KEY=VALUE arguments as {KEY: VALUE}.
json values_of(const std::vector<std::string>& arguments) {
  json values = json::object();
  for (const std::string& argument : arguments) {
    const std::size_t equals = argument.find('=');
    if (equals == std::string::npos || equals == 0) {
      throw BadInput("found \"" + argument +
                     "\", expected KEY=VALUE, for example control.velocity_filter_hz=80");
    }
    const std::string key = argument.substr(0, equals);
    if (values.contains(key)) throw BadInput(key + " is given twice");
    values[key] = argument.substr(equals + 1);
  }
  return values;
}

void print(const json& answer, bool as_json) {
  if (as_json) {
    fmt::print("{}\n", answer.dump());
    return;
  }
  for (const json& change : answer.at("changes")) {
    fmt::print("{}\n", change.at("text").get<std::string>());
  }
  for (const json& message : answer.at("messages")) {
    fmt::print(stderr, "geodesic: warning: {}\n", message.get<std::string>());
  }
  const auto changed = answer.at("changed").get<std::size_t>();
  const std::size_t shown = answer.at("changes").size();
  if (changed == 0) fmt::print("nothing is different\n");
  if (changed > shown) fmt::print("... and {} more\n", changed - shown);
}

void print_list(const json& answer, bool as_json) {
  if (as_json) {
    fmt::print("{}\n", answer.dump());
    return;
  }
  std::size_t width = 6;
  for (const json& one : answer.at("options")) {
    width = std::max(width, one.at("option").get_ref<const std::string&>().size());
  }
  fmt::print("{:<{}}  {:<16}  {:<12}  {}\n", "option", width, "value", "unit", "range");
  for (const json& one : answer.at("options")) {
    fmt::print("{:<{}}  {:<16}  {:<12}  {}\n", one.at("option").get<std::string>(), width,
               one.at("value").get<std::string>(), one.value("unit", std::string()),
               one.value("range", std::string()));
  }
}

int write(ControlClient& client, bool as_json) {
  const json answer = ask(client, {{"cmd", "tune"}, {"tuned", true}});
  const std::filesystem::path file = answer.at("file").get<std::string>();
  std::vector<config::Override> values;
  for (const json& one : answer.at("tuned")) {
    values.push_back({one.at("option").get<std::string>(), one.at("value").get<std::string>()});
  }
  const config::WriteResult result = config::write_back(file, values);
  if (as_json) {
    nlohmann::ordered_json said{{"ok", result.ok}, {"file", file.string()}};
    said["changes"] = nlohmann::ordered_json::array();
    for (const config::Change& change : result.changes) {
      said["changes"].push_back(config::to_string(change));
    }
    said["messages"] = result.problems;
    fmt::print("{}\n", said.dump());
    return result.ok ? kExitOk : kExitRefused;
  }
  for (const std::string& problem : result.problems) {
    fmt::print(stderr, "geodesic: error: not written: {}\n", problem);
  }
  if (!result.ok) return kExitRefused;
  for (const config::Change& change : result.changes) {
    fmt::print("{}\n", config::to_string(change));
  }
  fmt::print("{}: {}\n", file.string(),
             result.changes.empty() ? "nothing is tuned that it does not say" : "written");
  return kExitOk;
}

int run_tune(TuneArguments arguments) {
  // The robot may be left out if only one daemon runs: then what stands first is a value.
  std::error_code ignored;
  std::string& first = arguments.daemon.robot;
  if (first.find('=') != std::string::npos && !std::filesystem::exists(first, ignored)) {
    arguments.values.insert(arguments.values.begin(), first);
    first.clear();
  }
  const int actions = (arguments.values.empty() ? 0 : 1) + (arguments.undo ? 1 : 0) +
                      (arguments.list ? 1 : 0) + (arguments.write ? 1 : 0);
  const bool set_and_write = actions == 2 && !arguments.values.empty() && arguments.write;
  if (actions != 1 && !set_and_write) {
    throw BadInput("say what to do: KEY=VALUE ... (and --write), --undo, --list, or --write");
  }
  ControlClient client(socket_of(arguments.daemon));
  const bool as_json = arguments.daemon.json;
  if (arguments.list) {
    print_list(ask(client, {{"cmd", "tune"}, {"list", true}}), as_json);
    return kExitOk;
  }
  if (arguments.undo) {
    print(ask(client, {{"cmd", "tune"}, {"undo", true}}), as_json);
    return kExitOk;
  }
  if (!arguments.values.empty()) {
    const json request{{"cmd", "tune"}, {"set", values_of(arguments.values)}};
    if (request.dump().size() >= ControlServer::kMaxRequest) {
      throw BadInput(fmt::format("a request may have {} bytes: set fewer values at a time",
                                 ControlServer::kMaxRequest));
    }
    print(ask(client, request), as_json);
  }
  return arguments.write ? write(client, as_json) : kExitOk;
}

}  // namespace

void add_tune(CLI::App& app, Run& run) {
  auto arguments = std::make_shared<TuneArguments>();
  CLI::App* command = app.add_subcommand(
      "tune", "Change gains, limits, friction, payload ... of the running daemon, without a jolt");
  add_daemon(*command, arguments->daemon);
  command->add_option("KEY=VALUE", arguments->values,
                      "what to set; all of it or, if one is refused, nothing");
  command->add_flag("--undo", arguments->undo,
                    "take the last change by `geodesic tune` back; again: the one before");
  command->add_flag("--list", arguments->list, "what can be tuned: present value, unit, range");
  command->add_flag("--write", arguments->write,
                    "put everything tuned into the robot's file; comments and layout stay");
  command->footer(
      "\nA tuned value stands in front of the file's until it is undone, or until the file is "
      "saved\n"
      "with another value for that very option. config/OPTIONS.md says of each option whether a\n"
      "running daemon takes it; the others are refused by name." +
      footer(kExamples));
  command->callback([arguments, &run] { run = [arguments] { return run_tune(*arguments); }; });
}

}  // namespace geodesic::tools
