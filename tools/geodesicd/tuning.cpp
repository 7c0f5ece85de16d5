// The service thread's side of tuning.
#include "tools/geodesicd/tuning.hpp"

#include <fmt/format.h>

#include <ctime>
#include <thread>
#include <utility>

#include "config/findings.hpp"
#include "config/options/options.hpp"

namespace geodesic::tools {

using nlohmann::json;
using nlohmann::ordered_json;

namespace {

constexpr std::chrono::milliseconds kWaitForVerdict{100};
constexpr std::chrono::microseconds kNap{100};
constexpr std::size_t kMostShown = 64;

ordered_json refusal(const std::string& error) {
  return {{"ok", false}, {"error", error}};
}

ordered_json to_json(const std::vector<config::Change>& changes) {
  ordered_json list = ordered_json::array();
  for (const config::Change& change : changes) {
    if (list.size() == kMostShown) break;
    list.push_back({{"option", change.path},
                    {"from", change.from},
                    {"to", change.to},
                    {"unit", change.unit},
                    {"text", config::to_string(change)}});
  }
  return list;
}

ordered_json to_json(const TuneOutcome& outcome) {
  ordered_json messages = ordered_json::array();
  for (const auto& texts : {outcome.problems, outcome.notes}) {
    for (const std::string& text : texts) {
      if (messages.size() < kMostShown) messages.push_back(text);
    }
  }
  return {{"ok", outcome.ok},
          {"changes", to_json(outcome.changes)},
          {"changed", outcome.changes.size()},
          {"messages", std::move(messages)}};
}

std::string joined(const std::vector<std::string>& texts) {
  std::string all;
  for (std::size_t i = 0; i < texts.size() && i < kMostShown; ++i) {
    all += (i == 0 ? "" : "\n") + texts[i];
  }
  return all;
}

std::string time_of_day() {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  gmtime_r(&now, &parts);
  return fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}Z", parts.tm_year + 1900, parts.tm_mon + 1,
                     parts.tm_mday, parts.tm_hour, parts.tm_min, parts.tm_sec);
}

std::vector<std::filesystem::path> files_of(const CommandLine& line,
                                            const config::LoadResult& start) {
  std::vector<std::filesystem::path> files{line.robot};
  if (!start.robot.urdf.empty()) files.push_back(start.robot.urdf);
  return files;
}

}  // namespace

Tuning::Tuning(const CommandLine& line, const config::LoadResult& start, SetupExchange& exchange,
               Log& log, const compile::VerifiedModel* compiled)
    : line_(line),
      exchange_(exchange),
      log_(log),
      tuner_(
          line, start,
          [this](std::unique_ptr<const control::Setup> setup) {
            return hand_over(std::move(setup));
          },
          compiled),
      watch_(files_of(line, start)) {}

const char* Tuning::to_string(By by) noexcept {
  switch (by) {
    case By::kFile:
      return "file";
    case By::kSignal:
      return "signal";
    case By::kOperator:
      return "tune";
    case By::kUndo:
      break;
  }
  return "undo";
}

Tuner::Verdict Tuning::hand_over(std::unique_ptr<const control::Setup> setup) {
  collect();
  if (exchange_.busy()) return Tuner::Verdict::kBusy;
  exchange_.offer(std::move(setup));
  // The next cycle takes it: that is worth waiting for, so that "ok" means that it counts.
  const Clock::time_point end = Clock::now() + kWaitForVerdict;
  while (Clock::now() < end) {
    switch (exchange_.collect()) {
      case SetupExchange::Verdict::kTaken:
        return Tuner::Verdict::kTaken;
      case SetupExchange::Verdict::kRefused:
        return Tuner::Verdict::kRefused;
      case SetupExchange::Verdict::kNone:
        std::this_thread::sleep_for(kNap);
    }
  }
  return Tuner::Verdict::kUnknown;
}

/// The real-time thread's late word, where there was no waiting for it.
void Tuning::collect() {
  switch (exchange_.collect()) {
    case SetupExchange::Verdict::kTaken:
      tuner_.taken();
      break;
    case SetupExchange::Verdict::kRefused:
      tuner_.refused();
      log_.error("the last change was taken back: the arm has moved beyond the new limits");
      break;
    case SetupExchange::Verdict::kNone:
      break;
  }
}

void Tuning::round(Clock::time_point now, const Record& last, double at_s) {
  last_ = last;
  at_s_ = at_s;
  collect();
  const bool saved = watch_.changed(now);
  if (watch_.problem() != watch_problem_told_) {
    watch_problem_told_ = watch_.problem();
    if (watch_problem_told_.empty()) {
      log_.info("the robot's files are watched again");
    } else {
      log_.warning(
          fmt::format("the robot's files cannot be watched ({}): looking once a second; the "
                      "arm goes on as it is",
                      watch_problem_told_));
    }
  }
  const bool asked = reload_asked_.exchange(false, std::memory_order_relaxed);
  if (saved || asked) note(asked ? By::kSignal : By::kFile, tuner_.reload(last_));
}

void Tuning::note(By by, const TuneOutcome& outcome) {
  const char* name = to_string(by);
  for (const config::Change& change : outcome.changes) {
    log_.write(Severity::kInfo, fmt::format("{}: {}", name, config::to_string(change)),
               {{"event", "tuned"},
                {"by", name},
                {"option", change.path},
                {"from", change.from},
                {"to", change.to},
                {"unit", change.unit}});
  }
  for (const std::string& problem : outcome.problems) {
    log_.write(Severity::kError,
               fmt::format("{}: refused, the arm goes on as it is: {}", name, problem),
               {{"event", "tuning_refused"}, {"by", name}});
  }
  for (const std::string& text : outcome.notes) log_.warning(fmt::format("{}: {}", name, text));
  if (outcome.ok && outcome.changes.empty()) {
    log_.info(fmt::format("{}: read; nothing that counts here is different", name));
  }
  last_attempt_ = {{"time", time_of_day()}, {"at_s", at_s_}, {"by", name}};
  last_attempt_.update(to_json(outcome));
}

ordered_json Tuning::answer_set(const json& values) {
  std::vector<config::Override> asked;
  for (const auto& [key, value] : values.items()) {
    if (value.is_string()) {
      asked.push_back({key, value.get<std::string>()});
    } else if (value.is_number() || value.is_boolean() || value.is_array()) {
      asked.push_back({key, value.dump()});
    } else {
      return refusal("\"set\": " + config::quote(key) +
                     " needs a number, a text, true, false or an array");
    }
  }
  const TuneOutcome outcome = tuner_.set(asked, last_);
  note(By::kOperator, outcome);
  ordered_json result = to_json(outcome);
  if (!outcome.ok) result["error"] = joined(outcome.problems);
  return result;
}

ordered_json Tuning::list() const {
  ordered_json options = ordered_json::array();
  for (const config::Setting& setting : tuner_.robot().settings) {
    if (setting.live != config::Live::kYes || setting.element) continue;
    ordered_json one{
        {"option", setting.path},
        {"value", setting.value.empty() ? "(" + setting.fallback + ")" : setting.value}};
    if (!setting.unit.empty()) one["unit"] = setting.unit;
    if (!setting.range.empty()) one["range"] = setting.range;
    options.push_back(std::move(one));
  }
  return {{"ok", true}, {"options", std::move(options)}};
}

ordered_json Tuning::tuned() const {
  ordered_json values = ordered_json::array();
  for (const config::Override& one : tuner_.tuned()) {
    values.push_back({{"option", one.path}, {"value", one.value}});
  }
  return values;
}

ordered_json Tuning::answer(const json& request) {
  const auto asks = [&request](const char* what) {
    const auto found = request.find(what);
    return found != request.end() && found->is_boolean() && found->get<bool>();
  };
  if (const auto values = request.find("set"); values != request.end()) {
    if (!values->is_object()) {
      return refusal("\"set\" is an object of options and values, like {\"payload\":\"box\"}");
    }
    return answer_set(*values);
  }
  if (asks("undo")) {
    const TuneOutcome outcome = tuner_.undo(last_);
    note(By::kUndo, outcome);
    ordered_json result = to_json(outcome);
    if (!outcome.ok) result["error"] = joined(outcome.problems);
    return result;
  }
  if (asks("list")) return list();
  if (asks("tuned")) {
    std::error_code ignored;
    return {{"ok", true},
            {"file", std::filesystem::absolute(line_.robot, ignored).string()},
            {"tuned", tuned()}};
  }
  return refusal(
      "\"tune\" needs one of \"set\":{OPTION:VALUE}, \"undo\":true, \"list\":true, \"tuned\":true");
}

ordered_json Tuning::status() const {
  const config::Robot& robot = tuner_.robot();
  return {{"payload", robot.payload ? robot.payloads[*robot.payload].name : "none"},
          {"tuned", tuned()},
          {"undoable", tuner_.undoable()},
          {"last", last_attempt_}};
}

}  // namespace geodesic::tools
