// Taking over, refusing, going back; see tuner.hpp.
#include "tools/geodesicd/tuner.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "config/options/toml_reader.hpp"
#include "config/settings.hpp"
#include "config/setup.hpp"

namespace geodesic::tools {

using config::Change;
using config::Live;
using config::LoadResult;
using config::Message;
using config::Override;

namespace {

constexpr std::size_t kMostUndo = 1000;

const Override* find(const std::vector<Override>& tuned, const std::string& path) {
  const auto found =
      std::find_if(tuned.begin(), tuned.end(), [&](const Override& o) { return o.path == path; });
  return found == tuned.end() ? nullptr : &*found;
}

void put(std::vector<Override>& tuned, const std::string& path, const std::string& value) {
  const auto found =
      std::find_if(tuned.begin(), tuned.end(), [&](const Override& o) { return o.path == path; });
  if (value.empty()) {
    if (found != tuned.end()) tuned.erase(found);
  } else if (found != tuned.end()) {
    found->value = value;
  } else {
    tuned.push_back({path, value});
  }
}

std::vector<std::string> errors_of(const LoadResult& loaded) {
  std::vector<std::string> texts;
  for (const Message& message : loaded.messages) {
    if (message.severity == Message::Severity::kError) texts.push_back(to_string(message));
  }
  return texts;
}

/// Warnings that `before` did not have.
std::vector<std::string> new_warnings(const LoadResult& before, const LoadResult& now) {
  std::vector<std::string> texts;
  for (const Message& message : now.messages) {
    const bool known = std::any_of(before.messages.begin(), before.messages.end(),
                                   [&](const Message& m) { return m.text == message.text; });
    if (message.severity == Message::Severity::kWarning && !known) {
      texts.push_back(to_string(message));
    }
  }
  return texts;
}

std::string refusal_of(const Change& change) {
  std::string text = fmt::format("{} needs a restart", to_string(change));
  if (change.path == "control.law") {
    text += "; `geodesic law NAME` switches the law of the running daemon";
  }
  if (change.place.line > 0) {
    text = fmt::format("{}:{}:{}: {}", change.place.file.string(), change.place.line,
                       std::max(change.place.column, 1), text);
  }
  return text;
}

TuneOutcome refused_for(std::vector<std::string> problems) {
  return {false, {}, std::move(problems), {}};
}

}  // namespace

std::vector<std::string> excluded_now(const config::Robot& from, const config::Robot& to,
                                      const Record& now) {
  std::vector<std::string> texts;
  for (std::size_t i = 0; i < to.controller.joints.size(); ++i) {
    const control::JointTuning& a = from.controller.joints[i];
    const control::JointTuning& b = to.controller.joints[i];
    const JointRecord& is = now.joint[i];
    if (is.age_us == JointRecord::kNever) continue;
    const control::JointDescription* joint = nullptr;
    for (const control::JointDescription& one : to.tree.joints) {
      if (one.name == b.name) joint = &one;
    }
    const bool slides = joint != nullptr && joint->kind == control::JointKind::kPrismatic;
    const auto excludes = [&](const char* option, double was, double limit, const char* relation,
                              double found, const char* unit) {
      if (was == limit) return;
      texts.push_back(
          fmt::format("joint.{}.{}: {} -> {} {} excludes the arm as it is: this joint {} {:.6g} "
                      "{}; move it, or "
                      "choose another limit",
                      b.name, option, was, limit, unit, relation, found, unit));
    };
    const char* position = slides ? "m" : "rad";
    if (is.position < b.position_lower) {
      excludes("position_lower", a.position_lower, b.position_lower, "is at", is.position,
               position);
    }
    if (is.position > b.position_upper) {
      excludes("position_upper", a.position_upper, b.position_upper, "is at", is.position,
               position);
    }
    if (std::abs(is.velocity) > b.velocity_limit) {
      excludes("velocity_limit", a.velocity_limit, b.velocity_limit, "moves at",
               std::abs(is.velocity), slides ? "m/s" : "rad/s");
    }
    if (now.authority > 0.0F && std::abs(static_cast<double>(is.model)) > b.torque_limit) {
      excludes("torque_limit", a.torque_limit, b.torque_limit, "is held up by",
               std::abs(static_cast<double>(is.model)), slides ? "N" : "N·m");
    }
    if (static_cast<double>(is.temperature_c) > b.temperature_limit_c) {
      excludes("temperature_limit_c", a.temperature_limit_c, b.temperature_limit_c,
               "has a drive of", static_cast<double>(is.temperature_c), "°C");
    }
  }
  return texts;
}

Tuner::Tuner(CommandLine line, LoadResult start, HandOver hand_over,
             const compile::VerifiedModel* compiled)
    : line_(std::move(line)), hand_over_(std::move(hand_over)), compiled_(compiled) {
  now_.file = std::move(start);
  now_.loaded = now_.file;
  apply(line_, now_.loaded.robot);
}

LoadResult Tuner::load(const std::optional<config::RobotText>& text,
                       const std::vector<Override>& tuned) const {
  config::LoadOptions options;
  options.strict = line_.strict;
  options.bus_override = line_.buses;
  options.overrides = tuned;
  options.text = text;
  return config::load_robot(line_.robot, options);
}

TuneOutcome Tuner::reload(const Record& now) {
  State next = now_;
  next.file = load(std::nullopt, {});
  if (!next.file.ok) return refused_for(errors_of(next.file));
  TuneOutcome outcome;
  std::vector<std::string> notes;
  for (const Change& change : difference(now_.file.robot, next.file.robot)) {
    const Override* own = find(next.tuned, change.path);
    if (own != nullptr) {
      notes.push_back(fmt::format("{}: the file's {} takes the place of the tuned {}", change.path,
                                  change.to, own->value));
      put(next.tuned, change.path, "");
    }
    for (std::vector<Step>& steps : next.undo) {
      std::erase_if(steps, [&](const Step& step) { return step.path == change.path; });
    }
  }
  std::erase_if(next.undo, [](const std::vector<Step>& steps) { return steps.empty(); });
  outcome = take(std::move(next), now);
  if (outcome.ok) outcome.notes.insert(outcome.notes.begin(), notes.begin(), notes.end());
  return outcome;
}

TuneOutcome Tuner::set(const std::vector<Override>& asked, const Record& now) {
  State next = now_;
  std::vector<Step> steps;
  std::vector<std::string> problems;
  for (const Override& wanted : asked) {
    std::string problem;
    const config::Setting* setting =
        config::find_by_key(now_.loaded.robot.settings, wanted.path, problem);
    const std::optional<std::string> value = config::as_toml_value(wanted.value);
    if (setting == nullptr) {
      problems.push_back(problem);
    } else if (!value) {
      problems.push_back(
          fmt::format("{}: {} is no value; write a number, true, false, a name, or "
                      "numbers in brackets like [0, 0, -9.81]",
                      wanted.path, config::quote(wanted.value)));
    } else if (setting->live != Live::kYes) {
      const bool elsewhere = setting->live == Live::kElsewhere;
      problems.push_back(fmt::format("{} {}", setting->path,
                                     elsewhere
                                         ? "is the simulated arm's: change it in the file and "
                                           "start `geodesic sim` anew"
                                         : "needs a restart: change it in the file"));
    } else {
      const Override* own = find(next.tuned, setting->path);
      steps.push_back({setting->path, own != nullptr ? own->value : ""});
      const config::Setting* written =
          config::find_setting(now_.file.robot.settings, setting->path);
      // What the file says anyway is not tuned.
      const bool back = written != nullptr && !written->value.empty() && written->value == *value;
      put(next.tuned, setting->path, back ? "" : *value);
    }
  }
  if (asked.empty()) problems.emplace_back("nothing to set: write KEY=VALUE");
  if (!problems.empty()) return refused_for(std::move(problems));
  std::reverse(steps.begin(), steps.end());  // a key that was named twice goes back to its first
  next.undo.push_back(std::move(steps));
  if (next.undo.size() > kMostUndo) next.undo.erase(next.undo.begin());
  return take(std::move(next), now);
}

TuneOutcome Tuner::undo(const Record& now) {
  if (now_.undo.empty()) return refused_for({"nothing has been tuned that could be taken back"});
  State next = now_;
  for (const Step& step : next.undo.back()) put(next.tuned, step.path, step.before);
  next.undo.pop_back();
  return take(std::move(next), now);
}

/// With the compiled functions if they are this mechanism's; a note where that changes.
std::unique_ptr<const control::Setup> Tuner::make_setup(const config::Robot& robot,
                                                        const control::Setup& before,
                                                        std::vector<std::string>& notes) const {
  auto setup = std::make_unique<control::Setup>(config::make_setup(robot));
  if (compiled_ == nullptr) return setup;
  setup->compiled = compiled_->functions_for(setup->mechanism);
  const bool had = compiled_->functions_for(before.mechanism) != nullptr;
  if (had && setup->compiled == nullptr) {
    notes.push_back(fmt::format(
        "the compiled model {} is not this mechanism's: the model read from the file takes over "
        "until the change is taken back; `geodesic compile` and a restart make one that is",
        robot.compiled.string()));
  } else if (!had && setup->compiled != nullptr) {
    notes.push_back(fmt::format("the compiled model {} counts again", robot.compiled.string()));
  }
  return setup;
}

TuneOutcome Tuner::take(State next, const Record& now) {
  if (before_) {
    return refused_for({"the real-time thread has not taken the last change yet; try again"});
  }
  next.loaded = next.tuned.empty() ? next.file : load(next.file.text, next.tuned);
  if (!next.loaded.ok) return refused_for(errors_of(next.loaded));
  config::Robot& robot = next.loaded.robot;
  if (const auto problem = apply(line_, robot)) return refused_for({*problem});

  TuneOutcome outcome;
  for (const Change& change : difference(now_.loaded.robot, robot)) {
    if (change.live == Live::kYes) outcome.changes.push_back(change);
    if (change.live == Live::kNo) outcome.problems.push_back(refusal_of(change));
  }
  if (!outcome.problems.empty()) return refused_for(std::move(outcome.problems));
  outcome.notes = new_warnings(now_.loaded, next.loaded);
  outcome.problems = excluded_now(now_.loaded.robot, robot, now);
  std::unique_ptr<const control::Setup> setup;
  if (outcome.problems.empty() && !outcome.changes.empty()) {
    try {
      const control::Setup before = config::make_setup(now_.loaded.robot);
      setup = make_setup(robot, before, outcome.notes);
      outcome.problems = control::unexchangeable(before, *setup);
    } catch (const std::invalid_argument& wrong) {
      outcome.problems.emplace_back(wrong.what());
    }
  }
  if (!outcome.problems.empty()) return refused_for(std::move(outcome.problems));
  const Verdict verdict = setup ? hand_over_(std::move(setup)) : Verdict::kTaken;
  if (verdict == Verdict::kBusy) {
    return refused_for({"the real-time thread has not taken the last change yet; try again"});
  }
  if (verdict == Verdict::kRefused) {
    return refused_for({"the arm has just moved beyond the new limits: nothing was changed"});
  }
  if (verdict == Verdict::kUnknown) before_ = std::make_unique<State>(std::move(now_));
  now_ = std::move(next);
  outcome.ok = true;
  return outcome;
}

void Tuner::refused() {
  if (!before_) return;
  now_ = std::move(*before_);
  before_.reset();
}

}  // namespace geodesic::tools
