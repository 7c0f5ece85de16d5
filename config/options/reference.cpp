// The visitor that writes the reference; see reference.hpp.
#include "config/options/reference.hpp"

#include <fmt/format.h>

#include "config/joint_options.hpp"
#include "config/options/options.hpp"
#include "config/robot_file.hpp"
#include "drivers/families.hpp"

namespace geodesic::config {

std::string to_string(const Range& range) {
  const bool below = range.lower > -std::numeric_limits<double>::infinity();
  const bool above = range.upper < std::numeric_limits<double>::infinity();
  if (below && above) {
    return fmt::format("{}{} to {}", range.lower_open ? "more than " : "", range.lower,
                       range.upper);
  }
  if (below) return fmt::format("{} {}", range.lower_open ? "more than" : "at least", range.lower);
  if (above) return fmt::format("at most {}", range.upper);
  return {};
}

std::string_view to_string(Live live) {
  switch (live) {
    case Live::kYes:
      return "yes";
    case Live::kNo:
      return "restart";
    case Live::kElsewhere:
      return "simulator";
    case Live::kUnsaid:
      break;
  }
  return "?";
}

namespace {

class Reference final : public OptionVisitor {
 public:
  explicit Reference(std::string heading) : heading_(std::move(heading)) {}

  void number(const Spec& spec, Given<double>& value) override {
    row(spec, "number", fmt::format("{}", value.value));
  }
  void integer(const Spec& spec, Given<std::int64_t>& value) override {
    row(spec, "integer", fmt::format("{}", value.value));
  }
  void flag(const Spec& spec, Given<bool>& value) override {
    row(spec, "true or false", value.value ? "true" : "false");
  }
  void text(const Spec& spec, Given<std::string>& value) override {
    std::string type = "string";
    for (std::size_t i = 0; i < spec.choices.size(); ++i) {
      type += fmt::format("{}`{}`", i == 0 ? ": " : ", ", spec.choices[i]);
    }
    row(spec, type, value.value.empty() ? "none" : fmt::format("`{}`", value.value));
  }
  void integers(const Spec& spec, Given<std::vector<std::int64_t>>& value) override {
    row(spec, "integers", fmt::format("[{}]", fmt::join(value.value, ", ")));
  }
  void vector(const Spec& spec, Given<std::array<double, 3>>& value) override {
    row(spec, "three numbers", fmt::format("[{}]", fmt::join(value.value, ", ")));
  }
  void by_name(const Spec& spec, std::vector<NamedNumber>& /*values*/) override {
    row(spec, "table: name = number", "none");
  }
  void table(const Spec& spec, const Describe& describe) override {
    nested(spec, heading_.empty() ? fmt::format("[{}]", spec.key) : joined(spec), describe);
  }
  void partial_table(const Spec& spec, const Describe& describe) override { table(spec, describe); }
  void tables(const Spec& spec, std::size_t present, const DescribeOne& describe) override {
    nested(spec, fmt::format("[[{}]]", spec.key),
           [&](OptionVisitor& inner) { describe(inner, present); });
  }
  Place here() const override { return {}; }

  std::string markdown() const { return rows_ + inner_; }

 private:
  std::string joined(const Spec& spec) const {
    const std::size_t inside = heading_.find(']');
    return fmt::format("{}.{}{}", heading_.substr(0, inside), spec.key, heading_.substr(inside));
  }

  void row(const Spec& spec, std::string_view type, std::string_view constant) {
    if (rows_.empty()) {
      rows_ =
          "| option | type | unit | range | default | live | meaning |\n"
          "|---|---|---|---|---|---|---|\n";
    }
    std::string fallback(spec.default_text.empty() ? constant : spec.default_text);
    if (spec.required) fallback = "**required**";
    rows_ += fmt::format("| `{}` | {} | {} | {} | {} | {} | {} |\n", spec.key, type, spec.unit,
                         to_string(spec.range), fallback, to_string(spec.live), spec.doc);
  }

  void nested(const Spec& spec, const std::string& heading, const Describe& describe) {
    inner_ +=
        fmt::format("\n## `{}`\n\n{}{}\n", heading, spec.doc, spec.required ? " Required." : "");
    if (!spec.like.empty()) {
      inner_ += fmt::format("\nOptions: those of `{}`, except `name`.\n", spec.like);
      return;
    }
    Reference inner(heading);
    describe(inner);
    const std::string body = inner.markdown();
    if (!body.empty()) inner_ += (body.front() == '\n' ? "" : "\n") + body;
  }

  std::string heading_;
  std::string rows_;
  std::string inner_;
};

/// What one family alone adds to a drive.
std::string settings_of(const drivers::Family& family) {
  if (family.settings.empty()) return {};
  Reference reference("");
  DriveEntry entry;
  entry.family.value = family.name;
  describe_drive_settings(reference, entry);
  return fmt::format("\n## `[joint.drive]` with `family = \"{}\"`\n\n{}. Beside the above:\n\n{}",
                     family.name, family.summary, reference.markdown());
}

}  // namespace

std::string option_reference_markdown() {
  Reference reference("");
  RobotFile defaults;
  describe(reference, defaults);
  std::string families;
  for (const drivers::Family& family : drivers::families()) families += settings_of(family);
  return "# Options of a robot file\n\n"
         "One TOML file describes one robot. This reference is written by the declarations that "
         "read\n"
         "the file. A unit such as \"N·m or N\" counts the first way at a revolute joint, the "
         "second way\n"
         "at a prismatic one. An option that is not listed here is an error. Relative paths begin "
         "at the\n"
         "robot file.\n\n"
         "Live: `yes` moves over to a running daemon when the file is saved, on SIGHUP, or by\n"
         "`geodesic tune`, without a step in torque; `restart` is refused by name while it runs;\n"
         "`simulator` concerns the simulated arm only, when it starts.\n" +
         reference.markdown() + families;
}

}  // namespace geodesic::config
