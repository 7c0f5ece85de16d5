// The visitor that lists options; see settings.hpp.
#include "config/settings.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "config/checks.hpp"

namespace geodesic::config {
namespace {

class Lister final : public OptionVisitor {
 public:
  Lister(std::vector<std::string> steps, std::vector<Setting>& list)
      : steps_(std::move(steps)), list_(list) {}

  void number(const Spec& spec, Given<double>& value) override {
    add(spec, value, fmt::format("{}", value.value));
  }
  void integer(const Spec& spec, Given<std::int64_t>& value) override {
    add(spec, value, fmt::format("{}", value.value));
  }
  void flag(const Spec& spec, Given<bool>& value) override {
    add(spec, value, value.value ? "true" : "false");
  }
  void text(const Spec& spec, Given<std::string>& value) override {
    if (awaits_name_ && spec.key == "name") {
      steps_.push_back(value.value);
      Setting element = described(spec, {});
      element.steps = steps_;
      element.path = fmt::format("{}", fmt::join(steps_, "."));
      element.value = "there";
      element.live = element_live_;
      element.element = true;
      element.place = value.place;
      list_.push_back(std::move(element));
      awaits_name_ = false;
      return;
    }
    add(spec, value, value.value.empty() ? std::string() : toml_string(value.value));
  }
  void integers(const Spec& spec, Given<std::vector<std::int64_t>>& value) override {
    add(spec, value, fmt::format("[{}]", fmt::join(value.value, ", ")));
  }
  void vector(const Spec& spec, Given<std::array<double, 3>>& value) override {
    add(spec, value, fmt::format("[{}]", fmt::join(value.value, ", ")));
  }
  void by_name(const Spec& spec, std::vector<NamedNumber>& values) override {
    std::vector<std::string> parts;
    parts.reserve(values.size());
    for (const NamedNumber& v : values) parts.push_back(fmt::format("{} = {}", v.name, v.value));
    std::sort(parts.begin(), parts.end());
    Setting setting = described(spec, spec.key);
    setting.value = parts.empty() ? "{}" : fmt::format("{{ {} }}", fmt::join(parts, ", "));
    if (!values.empty()) setting.place = values.front().name_place;
    list_.push_back(std::move(setting));
  }
  void table(const Spec& spec, const Describe& describe) override {
    std::vector<std::string> steps = steps_;
    steps.emplace_back(spec.key);
    Lister inner(std::move(steps), list_);
    describe(inner);
  }
  // What others fall back to is seen where they do.
  void partial_table(const Spec& /*spec*/, const Describe& /*describe*/) override {}
  void tables(const Spec& spec, std::size_t present, const DescribeOne& describe) override {
    for (std::size_t i = 0; i < present; ++i) {
      std::vector<std::string> steps = steps_;
      steps.emplace_back(spec.key);
      Lister inner(std::move(steps), list_);
      inner.awaits_name_ = true;
      inner.element_live_ = spec.live;
      describe(inner, i);
    }
  }
  Place here() const override { return {}; }

 private:
  Setting described(const Spec& spec, std::string_view key) const {
    Setting setting;
    setting.steps = steps_;
    if (!key.empty()) setting.steps.emplace_back(key);
    setting.path = fmt::format("{}", fmt::join(setting.steps, "."));
    setting.unit = spec.unit;
    setting.range = to_string(spec.range);
    for (std::size_t i = 0; i < spec.choices.size(); ++i) {
      setting.range += (i == 0 ? "" : ", ") + std::string(spec.choices[i]);
    }
    setting.doc = spec.doc;
    setting.fallback = spec.default_text;
    setting.live = spec.live;
    return setting;
  }

  template <class T>
  void add(const Spec& spec, const Given<T>& value, std::string text) {
    Setting setting = described(spec, spec.key);
    const bool constant = spec.default_text.empty() && !spec.required;
    if (value.given || constant) setting.value = std::move(text);
    if (value.given) setting.place = value.place;
    list_.push_back(std::move(setting));
  }

  std::vector<std::string> steps_;
  std::vector<Setting>& list_;
  bool awaits_name_ = false;
  Live element_live_ = Live::kUnsaid;
};

/// "rad or m" is one of them at a joint.
void choose_units(std::vector<Setting>& settings, const control::TreeDescription& tree) {
  constexpr std::string_view kOr = " or ";
  for (Setting& setting : settings) {
    const std::size_t at = setting.unit.find(kOr);
    if (at == std::string::npos || setting.steps.size() < 2 || setting.steps[0] != "joint") {
      continue;
    }
    const control::JointDescription* joint = find_joint(tree, setting.steps[1]);
    if (joint == nullptr) continue;
    const bool prismatic = joint->kind == control::JointKind::kPrismatic;
    setting.unit = prismatic ? setting.unit.substr(at + kOr.size()) : setting.unit.substr(0, at);
  }
}

}  // namespace

std::vector<Setting> settings_of(const RobotFile& file, const control::TreeDescription& tree) {
  std::vector<Setting> settings;
  Lister lister({}, settings);
  RobotFile copy = file;  // a visitor might write
  describe(lister, copy);
  choose_units(settings, tree);
  return settings;
}

const Setting* find_setting(std::span<const Setting> settings, std::string_view path) {
  const auto found = std::find_if(settings.begin(), settings.end(),
                                  [&](const Setting& s) { return s.path == path; });
  return found == settings.end() ? nullptr : &*found;
}

const Setting* find_by_key(std::span<const Setting> settings, std::string_view key,
                           std::string& problem) {
  for (const std::string& path : {std::string(key), "robot." + std::string(key)}) {
    const Setting* found = find_setting(settings, path);
    if (found != nullptr && !found->element) return found;
  }
  std::vector<std::string> known;
  for (const Setting& setting : settings) {
    if (!setting.element) known.push_back(setting.path);
  }
  problem = fmt::format("there is no option {}{}", quote(key), did_you_mean(key, known));
  return nullptr;
}

std::vector<TomlOverride> resolve(std::span<const Override> overrides,
                                  const std::filesystem::path& file, std::string_view text,
                                  Findings& findings) {
  std::vector<TomlOverride> resolved;
  if (overrides.empty()) return resolved;
  RobotFile plain;
  Findings later;  // whatever is wrong with the file is found again when it is read for good
  if (!read_toml(
          file, text, [&](OptionVisitor& o) { describe(o, plain); }, later)) {
    return resolved;
  }
  const std::vector<Setting> settings = settings_of(plain, {});
  for (const Override& wanted : overrides) {
    const std::string label = wanted.path + "=" + wanted.value;
    std::string problem;
    if (const Setting* setting = find_by_key(settings, wanted.path, problem)) {
      resolved.push_back({setting->steps, wanted.value, label});
    } else {
      findings.error({label, 0, 0}, problem);
    }
  }
  return resolved;
}

}  // namespace geodesic::config
