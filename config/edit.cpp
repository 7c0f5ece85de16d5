// Editing by the source positions that toml++ reports; see edit.hpp.
#include "config/edit.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cctype>

#include "config/options/toml_reader.hpp"

namespace geodesic::config {
namespace {

/// From toml++'s lines and columns (code points, from 1) to bytes.
class Bytes {
 public:
  explicit Bytes(const std::string& text) : text_(text) {
    begins_.push_back(0);
    for (std::size_t i = 0; i < text.size(); ++i) {
      if (text[i] == '\n') begins_.push_back(i + 1);
    }
  }

  std::size_t at(const toml::source_position& place) const {
    if (place.line == 0 || place.line > begins_.size()) return text_.size();
    std::size_t byte = begins_[place.line - 1];
    if (place.line == 1 && text_.starts_with("\xEF\xBB\xBF")) byte += 3;
    for (toml::source_index column = 1; column < place.column && byte < text_.size(); ++column) {
      ++byte;
      while (byte < text_.size() && (static_cast<unsigned char>(text_[byte]) & 0xC0U) == 0x80U) {
        ++byte;
      }
    }
    return byte;
  }

  /// Begin of the line that holds the byte before `place`'s end.
  std::size_t line_begin(const toml::source_position& place) const {
    return place.line == 0 || place.line > begins_.size() ? text_.size() : begins_[place.line - 1];
  }
  /// Behind that line's last byte, its line break excluded.
  std::size_t line_end(const toml::source_position& place) const {
    std::size_t end = place.line < begins_.size() ? begins_[place.line] - 1 : text_.size();
    if (end > 0 && end <= text_.size() && text_[end - 1] == '\r') --end;
    return end;
  }

 private:
  const std::string& text_;
  std::vector<std::size_t> begins_;
};

std::string key_text(const std::string& key) {
  const bool bare = !key.empty() && std::all_of(key.begin(), key.end(), [](unsigned char c) {
    return (std::isalnum(c) != 0 && c < 0x80) || c == '_' || c == '-';
  });
  return bare ? key : toml_string(key);
}

class Editor {
 public:
  Editor(const std::string& text, const toml::table& root)
      : text_(text), root_(root), bytes_(text) {}

  EditResult put(const std::vector<std::string>& steps, const std::string& value) {
    const toml::table* table = &root_;
    std::size_t step = 0;
    while (step + 1 < steps.size()) {
      const toml::node* next = table->get(steps[step]);
      if (next == nullptr) break;
      if (const toml::array* array = next->as_array(); array != nullptr) {
        table = element_named(*array, steps[++step]);
      } else {
        table = next->as_table();
      }
      if (table == nullptr) return {std::nullopt, "there is no table for it"};
      ++step;
    }
    const std::vector<std::string> rest(steps.begin() + static_cast<long>(step), steps.end());
    if (table == &root_) return append(rest, value);
    if (rest.size() == 1) {
      if (const toml::node* there = table->get(rest[0])) return replace(*there, value);
    }
    std::vector<std::string> keys;
    keys.reserve(rest.size());
    for (const std::string& key : rest) keys.push_back(key_text(key));
    const std::string line = fmt::format("{} = {}", fmt::join(keys, "."), value);
    return table->is_inline() ? into_inline(*table, line) : new_line(*table, line);
  }

 private:
  static const toml::table* element_named(const toml::array& array, const std::string& name) {
    for (const toml::node& element : array) {
      const toml::table* table = element.as_table();
      const toml::node* said = table != nullptr ? table->get("name") : nullptr;
      if (said != nullptr && said->is_string() && said->as_string()->get() == name) return table;
    }
    return nullptr;
  }

  EditResult spliced(std::size_t begin, std::size_t end, const std::string& with) const {
    if (begin > end || end > text_.size()) return {std::nullopt, "its place cannot be told"};
    std::string text = text_;
    text.replace(begin, end - begin, with);
    return {std::move(text), ""};
  }

  EditResult replace(const toml::node& node, const std::string& value) const {
    return spliced(bytes_.at(node.source().begin), bytes_.at(node.source().end), value);
  }

  EditResult into_inline(const toml::table& table, const std::string& entry) const {
    const std::size_t end = bytes_.at(table.source().end);
    if (end == 0 || end > text_.size() || text_[end - 1] != '}') {
      return {std::nullopt, "the end of its table cannot be told"};
    }
    // Behind the last entry; the blank before the brace stays where it is.
    std::size_t at = end - 1;
    while (at > 0 && (text_[at - 1] == ' ' || text_[at - 1] == '\t')) --at;
    return spliced(at, at, table.empty() ? " " + entry + " " : ", " + entry);
  }

  EditResult new_line(const toml::table& table, const std::string& line) const {
    // Below the last line of the table's own body; tables under headings of their own come later.
    toml::source_position after = table.source().begin;
    std::size_t indent_from = bytes_.line_begin(after);
    for (auto&& [key, node] : table) {
      const toml::table* inner = node.as_table();
      const bool tables = node.is_array_of_tables() && node.source().begin == key.source().begin;
      if ((inner != nullptr && !inner->is_inline()) || tables || is_heading(key)) continue;
      if (node.source().end.line < after.line) continue;
      after = node.source().end;
      indent_from = bytes_.line_begin(key.source().begin);
    }
    std::size_t indent_to = indent_from;
    while (indent_to < text_.size() && (text_[indent_to] == ' ' || text_[indent_to] == '\t')) {
      ++indent_to;
    }
    const std::size_t at = bytes_.line_end(after);
    return spliced(at, at,
                   line_break() + text_.substr(indent_from, indent_to - indent_from) + line);
  }

  /// Whether the key stands in a heading, [like.this], and not before a value.
  bool is_heading(const toml::key& key) const {
    const std::size_t begin = bytes_.line_begin(key.source().begin);
    const std::size_t first = text_.find_first_not_of(" \t", begin);
    return first != std::string::npos && first < bytes_.at(key.source().begin) &&
           text_[first] == '[';
  }

  EditResult append(const std::vector<std::string>& rest, const std::string& value) const {
    if (rest.size() < 2) return {std::nullopt, "options stand in tables"};
    std::vector<std::string> heading;
    for (std::size_t i = 0; i + 1 < rest.size(); ++i) heading.push_back(key_text(rest[i]));
    const std::string gap = text_.empty() || text_.ends_with('\n') ? "" : line_break();
    return spliced(text_.size(), text_.size(),
                   fmt::format("{0}{1}[{2}]{1}{3} = {4}{1}", gap, line_break(),
                               fmt::join(heading, "."), key_text(rest.back()), value));
  }

  std::string line_break() const { return text_.find("\r\n") != std::string::npos ? "\r\n" : "\n"; }

  const std::string& text_;
  const toml::table& root_;
  Bytes bytes_;
};

}  // namespace

EditResult edit_toml(const std::string& text, const std::vector<std::string>& steps,
                     const std::string& value) {
  try {
    const toml::table root = toml::parse(text);
    return Editor(text, root).put(steps, value);
  } catch (const toml::parse_error& error) {
    return {std::nullopt, fmt::format("the file is not valid TOML: {}", error.description())};
  }
}

}  // namespace geodesic::config
