// XML with places and exact numbers; see urdf_document.hpp.
#include "config/urdf_document.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <cstring>
#include <utility>

namespace geodesic::config {

using tinyxml2::XMLElement;

namespace {

std::vector<std::string_view> words(std::string_view text) {
  constexpr std::string_view kSpace = " \t\r\n";
  std::vector<std::string_view> all;
  for (std::size_t at = text.find_first_not_of(kSpace); at != std::string_view::npos;) {
    const std::size_t end = std::min(text.find_first_of(kSpace, at), text.size());
    all.push_back(text.substr(at, end - at));
    at = text.find_first_not_of(kSpace, end);
  }
  return all;
}

}  // namespace

UrdfDocument::UrdfDocument(std::filesystem::path file, std::string text)
    : file_(std::move(file)), text_(std::move(text)) {
  line_begin_.push_back(0);
  for (std::size_t i = 0; i < text_.size(); ++i) {
    if (text_[i] == '\n') line_begin_.push_back(i + 1);
  }
}

bool UrdfDocument::parse(Findings& findings) {
  document_.Parse(text_.c_str(), text_.size());
  if (document_.Error()) {
    const int line = std::max(document_.ErrorLineNum(), 1);
    const char* name = document_.ErrorName();  // "XML_ERROR_MISMATCHED_ELEMENT"
    std::string reason(std::strncmp(name, "XML_ERROR_", 10) == 0 ? name + 10 : name);
    for (char& letter : reason) {
      letter = letter == '_' ? ' ' : static_cast<char>(std::tolower(letter));
    }
    findings.error({file_, line, column(line, "<")},
                   fmt::format("this is not well-formed XML: {}", reason));
    return false;
  }
  const XMLElement* root = document_.RootElement();
  if (root == nullptr || std::strcmp(root->Name(), "robot") != 0) {
    const Place where = root == nullptr ? Place{file_, 1, 1} : place(*root);
    findings.error(where,
                   fmt::format("found {}, expected a URDF: <robot name=\"...\">",
                               root == nullptr ? "no element" : fmt::format("<{}>", root->Name())));
    return false;
  }
  return true;
}

Place UrdfDocument::place(const XMLElement& element) const {
  const int line = element.GetLineNum();
  return {file_, line, column(line, fmt::format("<{}", element.Name()))};
}

Place UrdfDocument::place(const XMLElement& element, const char* attribute) const {
  const tinyxml2::XMLAttribute* found = element.FindAttribute(attribute);
  if (found == nullptr) return place(element);
  const int line = found->GetLineNum();
  // The whole of name="value", so that the same name in another element of the line is passed over.
  for (const char mark : {'"', '\''}) {
    const int at = column(line, fmt::format("{}={}{}{}", attribute, mark, found->Value(), mark));
    if (at > 1) return {file_, line, at + static_cast<int>(std::strlen(attribute)) + 1};
  }
  return {file_, line, column(line, attribute)};
}

int UrdfDocument::column(int line, std::string_view text) const {
  const auto index = static_cast<std::size_t>(std::max(line, 1)) - 1;
  if (index >= line_begin_.size()) return 1;
  const std::size_t end = index + 1 < line_begin_.size() ? line_begin_[index + 1] : text_.size();
  const std::string_view here =
      std::string_view(text_).substr(line_begin_[index], end - line_begin_[index]);
  const std::size_t found = here.find(text);
  return found == std::string_view::npos ? 1 : static_cast<int>(found) + 1;
}

std::optional<double> UrdfNumbers::required(const XMLElement& element,
                                            const char* attribute) const {
  if (element.Attribute(attribute) == nullptr) {
    findings_.error(
        document_.place(element),
        fmt::format("<{}> has no {}=\"...\", expected a number", element.Name(), attribute));
    return std::nullopt;
  }
  return optional(element, attribute, 0.0);
}

std::optional<double> UrdfNumbers::optional(const XMLElement& element, const char* attribute,
                                            double fallback) const {
  const char* text = element.Attribute(attribute);
  if (text == nullptr) return fallback;
  const std::vector<std::string_view> found = words(text);
  if (found.size() == 1) return parse(element, attribute, found.front());
  findings_.error(document_.place(element, attribute),
                  fmt::format("{} of <{}>: found {}, expected one number", attribute,
                              element.Name(), quote(text)));
  return std::nullopt;
}

std::optional<std::array<double, 3>> UrdfNumbers::triple(
    const XMLElement& element, const char* attribute, const std::array<double, 3>& fallback) const {
  const char* text = element.Attribute(attribute);
  if (text == nullptr) return fallback;
  const std::vector<std::string_view> found = words(text);
  if (found.size() != 3) {
    findings_.error(document_.place(element, attribute),
                    fmt::format("{} of <{}>: found {} ({} numbers), expected three numbers with "
                                "spaces between them",
                                attribute, element.Name(), quote(text), found.size()));
    return std::nullopt;
  }
  std::array<double, 3> all{};
  for (std::size_t i = 0; i < 3; ++i) {
    const std::optional<double> number = parse(element, attribute, found[i]);
    if (!number) return std::nullopt;
    all.at(i) = *number;
  }
  return all;
}

std::optional<double> UrdfNumbers::parse(const XMLElement& element, const char* attribute,
                                         std::string_view word) const {
  // from_chars: exact to the last bit and deaf to the locale.
  const std::string_view digits = word.starts_with('+') ? word.substr(1) : word;
  double number = 0.0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  if (error == std::errc() && end == digits.data() + digits.size() && std::isfinite(number)) {
    return number;
  }
  std::string hint;
  if (word.find(',') != std::string_view::npos) hint = "; the decimal mark is a point";
  if (word.find("${") != std::string_view::npos) hint = "; this is xacro, expand it first";
  findings_.error(document_.place(element, attribute),
                  fmt::format("{} of <{}>: found {}, expected a finite number{}", attribute,
                              element.Name(), quote(word), hint));
  return std::nullopt;
}

}  // namespace geodesic::config
