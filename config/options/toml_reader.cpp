// The visitor that reads TOML; see toml_reader.hpp.
#include "config/options/toml_reader.hpp"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

namespace geodesic::config {
namespace {

std::string describe_found(const toml::node& node) {
  if (const auto* text = node.as_string()) return "the string " + quote(text->get());
  if (const auto* number = node.as_integer()) return fmt::format("the integer {}", number->get());
  if (const auto* number = node.as_floating_point()) {
    return fmt::format("the number {}", number->get());
  }
  if (const auto* flag = node.as_boolean()) return flag->get() ? "true" : "false";
  if (node.is_array()) return "an array";
  if (node.is_table()) return "a table";
  return "a date or time";
}

std::string with_unit(std::string text, const Spec& spec) {
  if (!spec.unit.empty()) text += fmt::format(" [{}]", spec.unit);
  if (const std::string range = to_string(spec.range); !range.empty()) text += ", " + range;
  return text;
}

std::vector<std::string> strings(std::span<const std::string_view> views) {
  return {views.begin(), views.end()};
}

class TomlOptions final : public OptionVisitor {
 public:
  TomlOptions(const toml::table& table, std::string label, const Place& here, bool partial,
              Findings& findings)
      : table_(table),
        label_(std::move(label)),
        here_(here),
        partial_(partial),
        findings_(findings) {}

  Place here() const override { return here_; }

  void number(const Spec& spec, Given<double>& value) override {
    const toml::node* node = find(spec, value.given);
    if (node == nullptr) return;
    if (const auto found = checked_number(spec, *node, "a number")) accept(value, *found, *node);
  }

  void integer(const Spec& spec, Given<std::int64_t>& value) override {
    const toml::node* node = find(spec, value.given);
    if (node == nullptr) return;
    if (const auto found = checked_integer(spec, *node)) accept(value, *found, *node);
  }

  void flag(const Spec& spec, Given<bool>& value) override {
    const toml::node* node = find(spec, value.given);
    if (node == nullptr) return;
    const auto* found = node->as_boolean();
    if (found == nullptr) return wrong(spec, *node, "true or false");
    accept(value, found->get(), *node);
  }

  void text(const Spec& spec, Given<std::string>& value) override {
    const toml::node* node = find(spec, value.given);
    if (node == nullptr) return;
    const auto* found = node->as_string();
    if (found == nullptr) return wrong(spec, *node, "a string in quotes");
    if (found->get().empty()) return wrong(spec, *node, "a string that is not empty");
    if (!spec.choices.empty() &&
        std::find(spec.choices.begin(), spec.choices.end(), found->get()) == spec.choices.end()) {
      const std::vector<std::string> choices = strings(spec.choices);
      return wrong(spec, *node, "one of: " + list_names(choices),
                   did_you_mean(found->get(), choices));
    }
    accept(value, found->get(), *node);
  }

  void integers(const Spec& spec, Given<std::vector<std::int64_t>>& value) override {
    const toml::node* node = find(spec, value.given);
    if (node == nullptr) return;
    const toml::array* array = node->as_array();
    if (array == nullptr) return wrong(spec, *node, "an array of integers, like [2, 3]");
    std::vector<std::int64_t> all;
    for (const toml::node& element : *array) {
      const auto found = checked_integer(spec, element);
      if (!found) return;
      all.push_back(*found);
    }
    accept(value, all, *node);
  }

  void vector(const Spec& spec, Given<std::array<double, 3>>& value) override {
    const toml::node* node = find(spec, value.given);
    if (node == nullptr) return;
    const toml::array* array = node->as_array();
    if (array == nullptr || array->size() != 3) {
      const std::string size =
          array == nullptr ? "" : fmt::format(" (it has {} elements)", array->size());
      return wrong(spec, *node, with_unit("an array of three numbers", spec), size);
    }
    std::array<double, 3> all{};
    for (std::size_t i = 0; i < 3; ++i) {
      const auto found = checked_number(spec, *array->get(i), "a number");
      if (!found) return;
      all.at(i) = *found;
    }
    accept(value, all, *node);
  }

  void by_name(const Spec& spec, std::vector<NamedNumber>& values) override {
    const toml::node* node = find(spec, false);
    if (node == nullptr) return;
    const toml::table* table = node->as_table();
    if (table == nullptr) return wrong(spec, *node, "a table, like { joint = 0.5 }");
    for (auto&& [key, element] : *table) {
      const auto found = checked_number(spec, element, "a number");
      if (found) {
        values.push_back(
            {std::string(key.str()), *found, place(key.source()), place(element.source())});
      }
    }
  }

  void table(const Spec& spec, const Describe& describe) override {
    read_table(spec, describe, partial_);
  }

  void partial_table(const Spec& spec, const Describe& describe) override {
    read_table(spec, describe, true);
  }

  void tables(const Spec& spec, std::size_t present, const DescribeOne& describe) override {
    const toml::node* node = find(spec, false);
    if (node == nullptr) return;
    const toml::array* array = node->as_array();
    if (array == nullptr) {
      return wrong(spec, *node, fmt::format("tables, each under a heading [[{}]]", spec.key));
    }
    for (const toml::node& element : *array) {
      const toml::table* table = element.as_table();
      if (table == nullptr) {
        wrong(spec, element, fmt::format("tables, each under a heading [[{}]]", spec.key));
        continue;
      }
      std::string label = fmt::format("[[{}]]", spec.key);
      if (const toml::node* name = table->get("name"); name != nullptr && name->is_string()) {
        label += " " + quote(name->as_string()->get());
      }
      TomlOptions inner(*table, label, place(element.source()), partial_, findings_);
      describe(inner, present++);
      inner.finish();
    }
  }

  /// Reports every key that no option claimed.
  void finish() {
    for (auto&& [key, node] : table_) {
      const std::string name(key.str());
      if (std::find(known_.begin(), known_.end(), name) != known_.end()) continue;
      const std::string where = label_.empty() ? "at the top of the file" : "in " + label_;
      findings_.error(place(key.source()),
                      fmt::format("unknown option {} {}{} Allowed here: {}", quote(name), where,
                                  unknown_end(name), list_names(known_)));
    }
  }

 private:
  std::string unknown_end(const std::string& name) const {
    const std::string hint = did_you_mean(name, known_);
    return hint.empty() ? "." : hint;
  }

  Place place(const toml::source_region& region) const {
    if (region.path && *region.path != here_.file.native()) return {*region.path, 0, 0};
    return {here_.file, static_cast<int>(region.begin.line), static_cast<int>(region.begin.column)};
  }

  const toml::node* find(const Spec& spec, bool already_given) {
    known_.emplace_back(spec.key);
    const toml::node* node = table_.get(spec.key);
    if (node == nullptr && spec.required && !already_given && !partial_) {
      std::string what = spec.default_text.empty() ? "" : fmt::format(" ({})", spec.default_text);
      findings_.error(here_,
                      fmt::format("{}{} is missing{}: {}", label_.empty() ? "" : label_ + ": ",
                                  quote(spec.key), what, with_unit(std::string(spec.doc), spec)));
    }
    return node;
  }

  void wrong(const Spec& spec, const toml::node& node, const std::string& expected,
             const std::string& end = {}) {
    findings_.error(place(node.source()), fmt::format("{}: found {}, expected {}{}", spec.key,
                                                      describe_found(node), expected, end));
  }

  std::optional<double> checked_number(const Spec& spec, const toml::node& node,
                                       const char* expected) {
    const bool numeric = node.is_integer() || node.is_floating_point();
    const double found = numeric ? node.value<double>().value_or(0.0) : 0.0;
    if (numeric && std::isfinite(found) && spec.range.holds(found)) return found;
    std::string end;
    if (numeric && std::isinf(found)) {
      end = "; leave the option out where there is nothing to limit";
    } else if (node.is_string() && is_number(node.as_string()->get())) {
      end = fmt::format("; write {} without quotes", node.as_string()->get());
    }
    const std::string finite = numeric && !std::isfinite(found) ? "a finite number" : expected;
    wrong(spec, node, with_unit(finite, spec), end);
    return std::nullopt;
  }

  std::optional<std::int64_t> checked_integer(const Spec& spec, const toml::node& node) {
    const auto* found = node.as_integer();
    if (found != nullptr && spec.range.holds(static_cast<double>(found->get()))) {
      return found->get();
    }
    wrong(spec, node, with_unit("an integer", spec));
    return std::nullopt;
  }

  static bool is_number(const std::string& text) {
    return !text.empty() && text.size() < 20 &&
           text.find_first_not_of("0123456789+-.e") == std::string::npos;
  }

  void read_table(const Spec& spec, const Describe& describe, bool partial) {
    const toml::node* node = find(spec, false);
    if (node == nullptr) return;
    const toml::table* table = node->as_table();
    const std::string label = nested_label(spec.key);
    if (table == nullptr) {
      return wrong(spec, *node, fmt::format("a table: {} or {} = {{ ... }}", label, spec.key));
    }
    TomlOptions inner(*table, label, place(node->source()), partial, findings_);
    describe(inner);
    inner.finish();
  }

  std::string nested_label(std::string_view key) const {
    if (label_.empty()) return fmt::format("[{}]", key);
    if (label_.starts_with("[[")) return fmt::format("{} of {}", key, label_);
    if (label_.ends_with("]")) {
      return fmt::format("{}.{}]", label_.substr(0, label_.size() - 1), key);
    }
    return fmt::format("{} of {}", key, label_);
  }

  template <class T>
  void accept(Given<T>& value, const T& found, const toml::node& node) {
    value.value = found;
    value.given = true;
    value.place = place(node.source());
  }

  const toml::table& table_;
  std::string label_;
  Place here_;
  bool partial_;
  Findings& findings_;
  std::vector<std::string> known_;
};

/// `value = VALUE` as a table; nothing if VALUE is more than one value, or none.
std::optional<toml::table> parse_value(std::string_view value, std::string_view label) {
  if (value.find_first_of("\n\r") != std::string_view::npos) return std::nullopt;
  try {
    toml::table parsed = toml::parse("value = " + std::string(value), label);
    if (parsed.size() != 1) return std::nullopt;
    return parsed;
  } catch (const toml::parse_error&) {
    return std::nullopt;
  }
}

toml::table* element_named(toml::array& array, const std::string& name) {
  for (toml::node& element : array) {
    toml::table* table = element.as_table();
    if (table == nullptr) continue;
    const toml::node* said = table->get("name");
    if (said != nullptr && said->is_string() && said->as_string()->get() == name) return table;
  }
  return nullptr;
}

/// The table that the last step of an override is a key of; made where it is not there yet. Null
/// where something else than a table is in the way.
toml::table* table_of(toml::table& root, const TomlOverride& wanted) {
  toml::table* at = &root;
  for (std::size_t i = 0; i + 1 < wanted.steps.size(); ++i) {
    toml::node* next = at->get(wanted.steps[i]);
    if (next == nullptr) {
      at->insert_or_assign(wanted.steps[i], toml::table{});
      next = at->get(wanted.steps[i]);
    }
    if (toml::array* array = next->as_array(); array != nullptr && i + 2 < wanted.steps.size()) {
      at = element_named(*array, wanted.steps[++i]);
    } else {
      at = next->as_table();
    }
    if (at == nullptr) return nullptr;
  }
  return at;
}

void put(toml::table& root, const TomlOverride& wanted, Findings& findings) {
  std::optional<toml::table> parsed = parse_value(wanted.value, wanted.label);
  toml::table* table = wanted.steps.empty() ? nullptr : table_of(root, wanted);
  if (!parsed || table == nullptr) {
    findings.error({wanted.label, 0, 0},
                   parsed ? "there is no such table in the file"
                          : fmt::format("{} is no TOML value", quote(wanted.value)));
    return;
  }
  // Moved, since a copy forgets where it came from.
  toml::node& value = *parsed->get("value");
  value.visit([&](auto& node) { table->insert_or_assign(wanted.steps.back(), std::move(node)); });
}

}  // namespace

std::string toml_string(std::string_view text) {
  std::string out = "\"";
  for (const char letter : text) {
    const auto code = static_cast<unsigned char>(letter);
    if (letter == '"' || letter == '\\') {
      out += '\\';
      out += letter;
    } else if (code < 0x20 || code == 0x7f) {
      out += fmt::format("\\u{:04X}", code);
    } else {
      out += letter;
    }
  }
  return out + "\"";
}

std::optional<std::string> as_toml_value(std::string_view typed) {
  const std::size_t begin = typed.find_first_not_of(" \t");
  if (begin == std::string_view::npos) return std::nullopt;
  typed = typed.substr(begin, typed.find_last_not_of(" \t") - begin + 1);
  // A comment behind the value would hide what follows it once it is written to a file.
  if (parse_value(typed, "value") && parse_value("[" + std::string(typed) + "]", "value")) {
    return std::string(typed);
  }
  const bool bare = std::all_of(typed.begin(), typed.end(), [](unsigned char letter) {
    return std::isalnum(letter) != 0 || letter == '_' || letter == '-' || letter == '.' ||
           letter == ' ' || letter >= 0x80;
  });
  if (!bare || std::isalpha(static_cast<unsigned char>(typed.front())) == 0) return std::nullopt;
  return toml_string(typed);
}

bool read_toml(const std::filesystem::path& file, std::string_view text,
               const OptionVisitor::Describe& describe, Findings& findings,
               std::span<const TomlOverride> overrides) {
  try {
    toml::table table = toml::parse(text, std::string_view(file.native()));
    for (const TomlOverride& wanted : overrides) put(table, wanted, findings);
    TomlOptions options(table, "", Place{file, 1, 1}, false, findings);
    describe(options);
    options.finish();
    return true;
  } catch (const toml::parse_error& error) {
    findings.error({file, static_cast<int>(error.source().begin.line),
                    static_cast<int>(error.source().begin.column)},
                   fmt::format("this is not valid TOML: {}", error.description()));
    return false;
  }
}

}  // namespace geodesic::config
