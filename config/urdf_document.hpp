// A URDF file as XML with places: elements, attributes and numbers, each with line and column.
// What the elements mean is checked in urdf_check.cpp.
#pragma once

#include <tinyxml2.h>

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "config/findings.hpp"

namespace geodesic::config {

class UrdfDocument {
 public:
  UrdfDocument(std::filesystem::path file, std::string text);

  /// Whether it is XML at all, with a <robot> around it; says why not.
  bool parse(Findings& findings);

  const tinyxml2::XMLElement& robot() const { return *document_.RootElement(); }
  const std::filesystem::path& file() const noexcept { return file_; }

  Place place(const tinyxml2::XMLElement& element) const;
  /// Of an attribute's value, or of the element if it has no such attribute.
  Place place(const tinyxml2::XMLElement& element, const char* attribute) const;

 private:
  int column(int line, std::string_view text) const;

  std::filesystem::path file_;
  std::string text_;
  std::vector<std::size_t> line_begin_;
  tinyxml2::XMLDocument document_;
};

/// Reads numbers of attributes; says what is wrong with them.
class UrdfNumbers {
 public:
  UrdfNumbers(const UrdfDocument& document, Findings& findings)
      : document_(document), findings_(findings) {}

  /// The attribute's number; nothing (and a finding) if it is missing or no finite number.
  std::optional<double> required(const tinyxml2::XMLElement& element, const char* attribute) const;
  /// As above, but a missing attribute is `fallback`.
  std::optional<double> optional(const tinyxml2::XMLElement& element, const char* attribute,
                                 double fallback) const;
  /// Three numbers; a missing attribute is `fallback`.
  std::optional<std::array<double, 3>> triple(const tinyxml2::XMLElement& element,
                                              const char* attribute,
                                              const std::array<double, 3>& fallback) const;

 private:
  std::optional<double> parse(const tinyxml2::XMLElement& element, const char* attribute,
                              std::string_view word) const;

  const UrdfDocument& document_;
  Findings& findings_;
};

}  // namespace geodesic::config
