// Reads golden vectors; see row.hpp.
#include "tests/drivers/vectors/row.hpp"

#include <array>
#include <charconv>
#include <cstdint>

namespace geodesic::drivers::test {

namespace {

constexpr std::array kColumns = {"direction", "description", "can_id", "is_extended",
                                 "is_fd",     "data",        "values"};

class Reader {
 public:
  Reader(const std::filesystem::path& name, int line) : name_(name), line_(line) {}

  [[noreturn]] void refuse(const std::string& text) const { throw RowError(name_, line_, text); }

  std::vector<std::string> split(const std::string& text) const {
    std::vector<std::string> fields(1);
    bool quoted = false;
    for (std::size_t i = 0; i < text.size(); ++i) {
      const char c = text[i];
      if (quoted && c == '"' && i + 1 < text.size() && text[i + 1] == '"') {
        fields.back() += '"';
        ++i;
      } else if (c == '"') {
        quoted = !quoted;
      } else if (c == ',' && !quoted) {
        fields.emplace_back();
      } else {
        fields.back() += c;
      }
    }
    if (quoted) {
      refuse("a quote is opened and not closed");
    }
    if (fields.size() != kColumns.size()) {
      refuse("found " + std::to_string(fields.size()) + " fields, expected " +
             std::to_string(kColumns.size()));
    }
    return fields;
  }

  std::uint32_t hexadecimal(const std::string& text, const char* what) const {
    std::uint32_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, 16);
    if (error != std::errc{} || end != text.data() + text.size()) {
      refuse(std::string(what) + " is '" + text + "', expected hexadecimal digits");
    }
    return value;
  }

  bool flag(const std::string& text, const char* what) const {
    if (text != "0" && text != "1") {
      refuse(std::string(what) + " is '" + text + "', expected 0 or 1");
    }
    return text == "1";
  }

  Row row(const std::string& text) const {
    const std::vector<std::string> fields = split(text);
    Row row;
    row.line = line_;
    if (fields[0] != "command" && fields[0] != "feedback") {
      refuse("direction is '" + fields[0] + "', expected command or feedback");
    }
    row.command = fields[0] == "command";
    row.description = fields[1];
    row.frame.id = hexadecimal(fields[2], "can_id");
    row.frame.extended = flag(fields[3], "is_extended");
    if (row.frame.id > (row.frame.extended ? 0x1FFFFFFFU : 0x7FFU)) {
      refuse("can_id " + fields[2] + " does not fit its kind of identifier");
    }
    row.frame.fd = flag(fields[4], "is_fd");
    row.frame.bit_rate_switch = row.frame.fd;
    const std::string& data = fields[5];
    if (data.size() % 2 != 0 || data.size() / 2 > (row.frame.fd ? 64U : 8U)) {
      refuse("data has " + std::to_string(data.size()) + " digits, expected two a byte, at most " +
             (row.frame.fd ? "64" : "8") + " bytes");
    }
    for (std::size_t i = 0; i < data.size(); i += 2) {
      row.frame.data[i / 2] = static_cast<std::uint8_t>(hexadecimal(data.substr(i, 2), "data"));
    }
    row.frame.length = static_cast<std::uint8_t>(data.size() / 2);
    for (std::size_t from = 0; from < fields[6].size();) {
      const std::size_t to = std::min(fields[6].find(';', from), fields[6].size());
      const std::string pair = fields[6].substr(from, to - from);
      const std::size_t equals = pair.find('=');
      if (equals == std::string::npos || equals == 0) {
        refuse("in values, '" + pair + "' is no key=value");
      }
      row.values.emplace_back(pair.substr(0, equals), pair.substr(equals + 1));
      from = to + 1;
    }
    return row;
  }

 private:
  const std::filesystem::path& name_;
  int line_;
};

}  // namespace

std::optional<std::string> Row::text(std::string_view key) const {
  for (const auto& [name, value] : values) {
    if (name == key) {
      return value;
    }
  }
  return std::nullopt;
}

double Row::number(std::string_view key) const {
  const std::optional<std::string> found = text(key);
  if (!found) {
    throw std::invalid_argument("values lack '" + std::string(key) + "'");
  }
  double value = 0.0;
  const auto [end, error] = std::from_chars(found->data(), found->data() + found->size(), value);
  if (error != std::errc{} || end != found->data() + found->size()) {
    throw std::invalid_argument(std::string(key) + " is '" + *found + "', expected a number");
  }
  return value;
}

std::vector<Row> read_rows(std::istream& csv, const std::filesystem::path& name) {
  std::vector<Row> rows;
  std::string text;
  int line = 0;
  while (std::getline(csv, text)) {
    ++line;
    if (!text.empty() && text.back() == '\r') {
      text.pop_back();
    }
    const Reader reader(name, line);
    if (line == 1) {
      const std::vector<std::string> heading = reader.split(text);
      for (std::size_t i = 0; i < kColumns.size(); ++i) {
        if (heading[i] != kColumns[i]) {
          reader.refuse("column " + std::to_string(i + 1) + " is '" + heading[i] + "', expected '" +
                        kColumns[i] + "'");
        }
      }
    } else if (!text.empty()) {
      rows.push_back(reader.row(text));
    }
  }
  if (rows.empty()) {
    throw RowError(name, line, "there are no rows");
  }
  return rows;
}

}  // namespace geodesic::drivers::test
