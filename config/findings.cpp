// Collecting and wording of findings; see findings.hpp.
#include "config/findings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <utility>

namespace geodesic::config {
namespace {

/// Bytes of the letter that `text` begins with; 0: a control character, or no UTF-8.
std::size_t letter_bytes(std::string_view text) {
  const auto code = [text](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  if (code(0) < 0x80) return code(0) >= 0x20 && code(0) != 0x7f ? 1 : 0;
  const std::size_t bytes = code(0) >= 0xf0 ? 4 : (code(0) >= 0xe0 ? 3 : 2);
  if (code(0) < 0xc2 || code(0) > 0xf4 || text.size() < bytes) return 0;
  for (std::size_t i = 1; i < bytes; ++i) {
    if ((code(i) & 0xc0U) != 0x80U) return 0;
  }
  // U+0080 to U+009F are control characters too: a terminal takes the latter of them for ESC [.
  return code(0) == 0xc2 && code(1) < 0xa0 ? 0 : bytes;
}

}  // namespace

std::string to_string(const Message& message) {
  std::string place = message.place.file.string();
  if (message.place.line > 0) {
    place += fmt::format(":{}:{}", message.place.line, std::max(message.place.column, 1));
  }
  const char* severity = message.severity == Message::Severity::kError ? "error" : "warning";
  return fmt::format("{}: {}: {}", place, severity, message.text);
}

void Findings::error(Place place, std::string text) {
  add({Message::Severity::kError, std::move(place), std::move(text)});
}

void Findings::warning(Place place, std::string text) {
  add({Message::Severity::kWarning, std::move(place), std::move(text)});
}

void Findings::add(Message message) {
  if (message.severity == Message::Severity::kError) ++errors_;
  message.text = printable(message.text);  // parsers' own texts hold pieces of the file as it is
  messages_.push_back(std::move(message));
}

std::vector<Message> Findings::take() {
  std::vector<std::filesystem::path> files;
  auto rank = [&files](const std::filesystem::path& file) {
    const auto found = std::find(files.begin(), files.end(), file);
    if (found != files.end()) return found - files.begin();
    files.push_back(file);
    return static_cast<std::ptrdiff_t>(files.size()) - 1;
  };
  for (const Message& message : messages_) rank(message.place.file);
  std::stable_sort(messages_.begin(), messages_.end(), [&](const Message& a, const Message& b) {
    return std::tuple(rank(a.place.file), a.place.line, a.place.column) <
           std::tuple(rank(b.place.file), b.place.line, b.place.column);
  });
  errors_ = 0;
  return std::exchange(messages_, {});
}

std::size_t edit_distance(std::string_view a, std::string_view b) {
  // Optimal string alignment: three rolling rows, the oldest for swapped neighbours.
  std::array<std::vector<std::size_t>, 3> row;
  row.fill(std::vector<std::size_t>(b.size() + 1));
  std::iota(row[0].begin(), row[0].end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::vector<std::size_t>& now = row[i % 3];
    const std::vector<std::size_t>& before = row[(i + 2) % 3];
    const std::vector<std::size_t>& before_that = row[(i + 1) % 3];
    now[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replace = before[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      now[j] = std::min({replace, before[j] + 1, now[j - 1] + 1});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
        now[j] = std::min(now[j], before_that[j - 2] + 1);
      }
    }
  }
  return row[a.size() % 3][b.size()];
}

std::string_view nearest_name(std::string_view found, std::span<const std::string> known) {
  constexpr std::size_t kLongest = 80;  // beyond it nobody mistyped a name, and time is quadratic
  if (found.empty() || found.size() > kLongest) return {};
  std::string_view best;
  std::size_t least = std::max<std::size_t>(1, found.size() / 3) + 1;
  for (const std::string& name : known) {
    if (name.size() > kLongest) continue;
    // A name cut short or drawn out ("torque" for "torque_limit") is also a near miss.
    const bool part = found.size() >= 3 && (name.starts_with(found) || found.starts_with(name));
    const std::size_t distance = part ? 1 : edit_distance(found, name);
    if (distance < least && !name.empty()) {
      least = distance;
      best = name;
    }
  }
  return best;
}

std::string did_you_mean(std::string_view found, std::span<const std::string> known) {
  const std::string_view best = nearest_name(found, known);
  return best.empty() ? std::string() : fmt::format("; did you mean {}?", quote(best));
}

std::string list_names(std::span<const std::string> names) {
  constexpr std::size_t kMost = 40;
  if (names.empty()) return "none";
  std::string text;
  for (std::size_t i = 0; i < names.size() && i < kMost; ++i) {
    text += (i > 0 ? ", " : "") + names[i];
  }
  if (names.size() > kMost) text += fmt::format(" and {} more", names.size() - kMost);
  return text;
}

std::string printable(std::string_view text) {
  std::string shown;
  while (!text.empty()) {
    const std::size_t bytes = letter_bytes(text);
    shown += bytes > 0 ? text.substr(0, bytes) : std::string_view("?");
    text.remove_prefix(std::max<std::size_t>(bytes, 1));
  }
  return shown;
}

std::string quote(std::string_view text, std::size_t most) {
  std::string_view kept = text.substr(0, most);
  if (text.size() > most) {
    // A multi-byte letter is not cut in half.
    while (!kept.empty() && (static_cast<unsigned char>(kept.back()) & 0xC0U) == 0x80U) {
      kept.remove_suffix(1);
    }
    if (!kept.empty() && static_cast<unsigned char>(kept.back()) >= 0xC0U) kept.remove_suffix(1);
  }
  return "\"" + printable(kept) + (text.size() > most ? "...\"" : "\"");
}

std::string quote_path(const std::filesystem::path& path) {
  return quote(path.string(), std::string::npos);
}

}  // namespace geodesic::config
