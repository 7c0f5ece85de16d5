// Reading the kernel's files; see the header.
#include "tools/geodesic/system_tree.hpp"

#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <iterator>
#include <system_error>

namespace geodesic::tools {

std::filesystem::path SystemTree::place(std::string_view path) const {
  return root_ / std::filesystem::path(path).relative_path();
}

bool SystemTree::exists(std::string_view path) const {
  std::error_code none;
  return std::filesystem::exists(place(path), none);
}

bool SystemTree::writable(std::string_view path) const {
  return ::access(place(path).c_str(), W_OK) == 0;
}

std::optional<std::string> SystemTree::read(std::string_view path) const {
  std::ifstream file(place(path), std::ios::binary);
  if (!file) return std::nullopt;
  std::string text{std::istreambuf_iterator<char>(file), {}};
  if (file.bad()) return std::nullopt;
  while (!text.empty() && (text.back() == '\n' || text.back() == '\0')) text.pop_back();
  return text;
}

std::optional<long> SystemTree::read_number(std::string_view path) const {
  const std::optional<std::string> text = read(path);
  if (!text) return std::nullopt;
  long value = 0;
  const auto [end, error] = std::from_chars(text->data(), text->data() + text->size(), value);
  if (error != std::errc()) return std::nullopt;
  return value;
}

std::vector<std::string> SystemTree::list(std::string_view path) const {
  std::vector<std::string> names;
  std::error_code none;
  for (std::filesystem::directory_iterator it(place(path), none), end; !none && it != end;
       it.increment(none)) {
    names.push_back(it->path().filename().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

std::vector<int> parse_cpu_list(std::string_view text) {
  constexpr int kMost = 4096;
  std::vector<int> cpus;
  while (!text.empty()) {
    const std::string_view part = text.substr(0, text.find(','));
    text.remove_prefix(std::min(text.size(), part.size() + 1));
    int first = 0;
    const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), first);
    if (error != std::errc()) continue;
    int last = first;
    if (end != part.data() + part.size() && *end == '-') {
      std::from_chars(end + 1, part.data() + part.size(), last);
    }
    for (int cpu = first; cpu <= std::min(last, kMost); ++cpu) cpus.push_back(cpu);
  }
  return cpus;
}

std::string to_cpu_list(const std::vector<int>& cpus) {
  std::string text;
  for (const int cpu : cpus) {
    if (!text.empty()) text += ',';
    text += std::to_string(cpu);
  }
  return text;
}

}  // namespace geodesic::tools
