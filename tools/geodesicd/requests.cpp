// Answers to operators.
#include "tools/geodesicd/requests.hpp"

#include <array>
#include <nlohmann/json.hpp>
#include <optional>

#include "config/findings.hpp"

namespace geodesic::tools {

using control::Request;
using nlohmann::json;
using nlohmann::ordered_json;

namespace {

ordered_json refusal(const std::string& error) {
  return {{"ok", false}, {"error", error}};
}

ordered_json hand_over(const Request& request, const RequestActions& actions,
                       ordered_json accepted) {
  if (!actions.hand_over(request)) {
    return refusal("the real-time thread has not taken the last requests yet; try again");
  }
  return accepted;
}

ordered_json ask_law(const json& request, const RequestActions& actions) {
  static const std::array<std::string, 4> kLaws{"float", "hold", "damp", "zero"};
  const auto found = request.find("law");
  if (found == request.end() || !found->is_string()) {
    return refusal("\"law\" needs the name of a law: {\"cmd\":\"law\",\"law\":\"float\"}");
  }
  const auto& name = found->get_ref<const std::string&>();
  const std::optional<control::LawKind> law = control::law_from_string(name);
  if (!law) {
    return refusal("there is no law " + config::quote(name) + config::did_you_mean(name, kLaws) +
                   "; laws: " + config::list_names(kLaws));
  }
  if (*law == control::LawKind::kZero && !actions.allow_zero_law) {
    return refusal(
        "the law zero lets the arm fall: it is for simulated arms, and geodesicd must have been "
        "started with --allow-zero-law");
  }
  if (actions.ending()) {
    return refusal("the daemon is about to end");
  }
  return hand_over({Request::Kind::kLaw, *law}, actions, {{"ok", true}, {"law", name}});
}

ordered_json ask_stop(const json& request, const RequestActions& actions) {
  const auto found = request.find("exit");
  if (found != request.end() && !found->is_boolean()) {
    return refusal("\"exit\" is true or false");
  }
  const bool exit = found != request.end() && found->get<bool>();
  if (exit) {
    actions.exit();
    return {{"ok", true}, {"exit", true}};
  }
  return hand_over({Request::Kind::kStop, {}}, actions, {{"ok", true}, {"exit", false}});
}

ordered_json answer(std::string_view line, const RequestActions& actions) {
  static const std::array<std::string, 4> kCommands{"status", "law", "stop", "tune"};
  const json request = json::parse(line, nullptr, false);
  if (!request.is_object()) {
    return refusal("a request is one JSON object a line, like {\"cmd\":\"status\"}; this is " +
                   config::quote(line.substr(0, 80)));
  }
  const auto command = request.find("cmd");
  if (command == request.end() || !command->is_string()) {
    return refusal("\"cmd\" is missing; commands: " + config::list_names(kCommands));
  }
  const auto& name = command->get_ref<const std::string&>();
  if (name == "status") {
    return actions.status();
  }
  if (name == "law") {
    return ask_law(request, actions);
  }
  if (name == "stop") {
    return ask_stop(request, actions);
  }
  if (name == "tune" && actions.tune) {
    return actions.tune(request);
  }
  return refusal("there is no command " + config::quote(name) +
                 config::did_you_mean(name, kCommands) +
                 "; commands: " + config::list_names(kCommands));
}

}  // namespace

std::string answer_request(std::string_view line, const RequestActions& actions) {
  return answer(line, actions).dump(-1, ' ', false, json::error_handler_t::replace);
}

}  // namespace geodesic::tools
