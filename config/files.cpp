// Reading whole files; see files.hpp.
#include "config/files.hpp"

#include <fmt/format.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <system_error>

namespace geodesic::config {

std::optional<std::string> read_file(const std::filesystem::path& file, Findings& findings,
                                     const Place& asked_at) {
  constexpr std::uintmax_t kMost = 16U << 20U;
  const Place place = asked_at.file.empty() ? Place{file, 0, 0} : asked_at;
  std::error_code problem;
  const auto status = std::filesystem::status(file, problem);
  if (!std::filesystem::exists(status)) {
    findings.error(place, fmt::format("there is no file {}", quote_path(file)));
    return std::nullopt;
  }
  if (std::filesystem::is_directory(status)) {
    findings.error(place, fmt::format("{} is a folder, expected a file", quote_path(file)));
    return std::nullopt;
  }
  const auto size = std::filesystem::file_size(file, problem);
  if (!problem && size > kMost) {
    findings.error(
        place, fmt::format("{} has {} bytes, expected at most {}", quote_path(file), size, kMost));
    return std::nullopt;
  }
  errno = 0;
  std::ifstream stream(file, std::ios::binary);
  std::string text;
  std::array<char, 65536> part;
  // Pipes and devices tell no size, and some never end.
  while (stream && text.size() <= kMost) {
    stream.read(part.data(), part.size());
    text.append(part.data(), static_cast<std::size_t>(stream.gcount()));
  }
  if (!stream.is_open() || stream.bad()) {
    findings.error(place, fmt::format("{} cannot be read: {}", quote_path(file),
                                      std::generic_category().message(errno)));
    return std::nullopt;
  }
  if (text.size() > kMost) {
    findings.error(place,
                   fmt::format("{} has more than the {} bytes expected", quote_path(file), kMost));
    return std::nullopt;
  }
  return text;
}

}  // namespace geodesic::config
