// Pushes, forces and faults as the command line spells them; see the header.
#include "tools/sim/script.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <utility>

namespace geodesic::tools {
namespace {

std::optional<double> to_number(std::string_view text) {
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) {
    return std::nullopt;
  }
  return value;
}

[[noreturn]] void refuse(std::string_view text, std::string_view why, std::string_view expected) {
  throw std::invalid_argument(fmt::format("'{}': {}; expected {}", text, why, expected));
}

double number(std::string_view part, std::string_view whole, std::string_view what,
              std::string_view expected) {
  const std::optional<double> value = to_number(part);
  if (!value) refuse(whole, fmt::format("'{}' is no {}", part, what), expected);
  return *value;
}

// WHO:WHAT@WHEN, cut at the last '@' and the first ':' (joint names hold neither).
struct Parts {
  std::string_view who;
  std::string_view what;
  std::string_view when;
};
Parts cut(std::string_view text, std::string_view expected) {
  const std::size_t at = text.rfind('@');
  if (at == std::string_view::npos) refuse(text, "there is no '@'", expected);
  const std::size_t colon = text.substr(0, at).find(':');
  if (colon == std::string_view::npos) refuse(text, "there is no ':'", expected);
  return {text.substr(0, colon), text.substr(colon + 1, at - colon - 1), text.substr(at + 1)};
}

struct Span {
  double start_s = 0.0;
  double duration_s = 0.0;
};
Span span_of(std::string_view when, std::string_view whole, std::string_view expected) {
  const std::size_t plus = when.find('+', 1);
  if (plus == std::string_view::npos) refuse(whole, "there is no '+DURATION'", expected);
  const Span span{number(when.substr(0, plus), whole, "time", expected),
                  number(when.substr(plus + 1), whole, "duration", expected)};
  if (span.start_s < 0.0) refuse(whole, "it begins before the release", expected);
  if (span.duration_s <= 0.0) refuse(whole, "it takes no time", expected);
  return span;
}

std::size_t find_joint(std::string_view who, std::string_view whole, const config::Robot& robot) {
  const auto& joints = robot.arm.joints;
  std::string names;
  for (std::size_t i = 0; i < joints.size(); ++i) {
    if (joints[i].name == who) return i;
    names += (i == 0 ? "" : ", ") + joints[i].name;
  }
  const std::optional<double> index = to_number(who);
  if (index && *index >= 1.0 && *index <= static_cast<double>(joints.size()) &&
      *index == std::floor(*index)) {
    return static_cast<std::size_t>(*index) - 1;
  }
  refuse(whole, fmt::format("the robot has no joint '{}'", who),
         fmt::format("one of {} or a number from 1 to {}", names, joints.size()));
}

std::uint8_t error_code(std::string_view text, std::string_view whole, std::string_view expected) {
  int base = 10;
  if (text.starts_with("0x")) {
    text.remove_prefix(2);
    base = 16;
  }
  unsigned value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, base);
  if (error != std::errc() || end != text.data() + text.size() || value > 255) {
    refuse(whole, fmt::format("'{}' is no error code", text), expected);
  }
  return static_cast<std::uint8_t>(value);
}

enum class Takes : std::uint8_t { kNone, kMaybe, kNeeded };

struct KindFacts {
  const char* name;
  Takes takes;
  std::string_view unit;
  double value;  // without one
};

constexpr std::string_view kSeconds = "time";

// In the order of FaultKind.
constexpr std::array<KindFacts, 9> kKinds{{
    {"silent", Takes::kMaybe, kSeconds, 0.0},
    {"error", Takes::kNeeded, "code", 0.0},
    {"power-cycle", Takes::kNone, "", 0.0},
    {"temperature", Takes::kNeeded, "temperature", 0.0},
    {"encoder-jump", Takes::kMaybe, "angle", 1.0},
    {"encoder-stuck", Takes::kNone, "", 0.0},
    {"double", Takes::kMaybe, "angle", 0.5},
    {"babble", Takes::kMaybe, kSeconds, 0.0},
    {"hold-bus", Takes::kNeeded, kSeconds, 0.0},
}};

}  // namespace

std::vector<double> parse_numbers(std::string_view text, std::string_view what) {
  std::vector<double> numbers;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    numbers.push_back(number(text.substr(begin, end - begin), text, "number", what));
    begin = end + 1;
  }
  return numbers;
}

Push parse_push(std::string_view text, const config::Robot& robot) {
  constexpr std::string_view kExpected = "JOINT:TORQUE@T+D, for example joint2:3.5@1+0.2";
  const Parts parts = cut(text, kExpected);
  const Span span = span_of(parts.when, text, kExpected);
  return {find_joint(parts.who, text, robot), number(parts.what, text, "torque", kExpected),
          span.start_s, span.duration_s};
}

LinkForce parse_force(std::string_view text, const config::Robot& robot) {
  constexpr std::string_view kExpected = "LINK:FX,FY,FZ@T+D, for example hand:0,0,10@1+0.2";
  const Parts parts = cut(text, kExpected);
  const Span span = span_of(parts.when, text, kExpected);
  const std::vector<double> force = parse_numbers(parts.what, kExpected);
  if (force.size() != 3) refuse(text, "a force has three components", kExpected);
  std::string names;
  for (const auto& link : robot.tree.links) {
    if (link.name == parts.who) {
      return {link.name, {force[0], force[1], force[2]}, span.start_s, span.duration_s};
    }
    names += (names.empty() ? "" : ", ") + link.name;
  }
  refuse(text, fmt::format("the robot has no link '{}'", parts.who), "one of " + names);
}

const char* to_string(FaultKind kind) noexcept {
  return kKinds[static_cast<std::size_t>(kind)].name;
}

ScriptedFault parse_fault(std::string_view text, const config::Robot& robot) {
  constexpr std::string_view kExpected =
      "JOINT:KIND@T, JOINT:KIND@start+T or JOINT:KIND@enabled+T with KIND silent[=SECONDS], "
      "error=CODE, power-cycle, "
      "temperature=CELSIUS, encoder-jump[=RAD], encoder-stuck, double[=RAD], babble[=SECONDS] or "
      "hold-bus=SECONDS, for example joint2:error=0xB@3";
  constexpr std::array<std::pair<std::string_view, FaultBase>, 2> kBases{
      {{"start", FaultBase::kStart}, {"enabled", FaultBase::kEnabled}}};
  const Parts parts = cut(text, kExpected);
  ScriptedFault fault;
  fault.joint = find_joint(parts.who, text, robot);
  std::string_view when = parts.when;
  for (const auto& [word, base] : kBases) {
    if (!when.starts_with(word)) continue;
    fault.base = base;
    when.remove_prefix(word.size());
  }
  if (!when.empty() || fault.base == FaultBase::kRelease)
    fault.at_s = number(when, text, "time", kExpected);
  if (fault.at_s < 0.0) refuse(text, "it begins before its time", kExpected);

  const std::size_t equals = parts.what.find('=');
  const std::string_view name = parts.what.substr(0, equals);
  const auto* kind = std::find_if(kKinds.begin(), kKinds.end(),
                                  [&](const KindFacts& facts) { return facts.name == name; });
  if (kind == kKinds.end()) {
    refuse(text, fmt::format("there is no fault '{}'", name), kExpected);
  }
  fault.kind = static_cast<FaultKind>(kind - kKinds.begin());
  fault.value = kind->value;
  if (equals == std::string_view::npos) {
    if (kind->takes == Takes::kNeeded)
      refuse(text, fmt::format("'{}' needs a value", name), kExpected);
    return fault;
  }
  const std::string_view value = parts.what.substr(equals + 1);
  if (kind->takes == Takes::kNone)
    refuse(text, fmt::format("'{}' takes no value", name), kExpected);
  if (fault.kind == FaultKind::kError) {
    fault.code = error_code(value, text, kExpected);
    return fault;
  }
  fault.value = number(value, text, kind->unit, kExpected);
  if (kind->unit == kSeconds && fault.value <= 0.0) refuse(text, "it takes no time", kExpected);
  return fault;
}

}  // namespace geodesic::tools
