// Golden vectors as files hold them: one row of a CSV, read and checked for form. What a row means
// is its family's business (checkers.hpp).
#pragma once

#include <filesystem>
#include <istream>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "drivers/bus/frame.hpp"

namespace geodesic::drivers::test {

struct Row {
  int line = 0;          ///< counts from 1; the heading is line 1
  bool command = false;  ///< host to drive; else drive to host
  std::string description;
  Frame frame;
  std::vector<std::pair<std::string, std::string>> values;

  bool says(std::string_view words) const { return description.find(words) != std::string::npos; }
  std::optional<std::string> text(std::string_view key) const;
  /// The value as a number, "nan" among them. @throws std::invalid_argument if it is missing or no
  /// number.
  double number(std::string_view key) const;
  bool has(std::string_view key) const { return text(key).has_value(); }
};

/// A row that has not the form of the others; what() is "FILE:LINE: text".
class RowError : public std::runtime_error {
 public:
  RowError(const std::filesystem::path& file, int line, const std::string& text)
      : std::runtime_error(file.string() + ":" + std::to_string(line) + ": " + text) {}
};

/// All rows of a CSV: the heading, then fields that may be quoted ("" is a quote within quotes).
/// @throws RowError at the first row of another form.
std::vector<Row> read_rows(std::istream& csv, const std::filesystem::path& name);

}  // namespace geodesic::drivers::test
