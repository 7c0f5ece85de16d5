// The fuzz targets' common tools; see fuzz.hpp.
#include "tests/fuzz/fuzz.hpp"

#include <stdlib.h>  // NOLINT(modernize-deprecated-headers): mkdtemp is POSIX, not C++

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <fstream>
#include <limits>
#include <sstream>
#include <system_error>

namespace geodesic::fuzz {

void expect(bool holds, std::string_view what) {
  if (!holds) throw Violation(std::string(what));
}

std::uint8_t Input::byte() {
  if (rest_.empty()) return 0;
  const std::uint8_t first = rest_.front();
  rest_ = rest_.subspan(1);
  return first;
}

std::uint64_t Input::integer(std::size_t bytes) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < bytes; ++i) value = value << 8U | byte();
  return value;
}

double Input::real(double scale) {
  using Limits = std::numeric_limits<double>;
  constexpr std::array kNasty{0.0,
                              -0.0,
                              1.0,
                              -1.0,
                              Limits::quiet_NaN(),
                              Limits::infinity(),
                              -Limits::infinity(),
                              Limits::max(),
                              Limits::lowest(),
                              Limits::min(),
                              Limits::denorm_min(),
                              static_cast<double>(std::numeric_limits<float>::max()) * 2.0};
  const std::uint8_t kind = byte();
  if (kind < 24) return kNasty[kind % kNasty.size()];
  if (kind < 40) return std::bit_cast<double>(integer(8));
  return (static_cast<double>(integer(2)) / 32768.0 - 1.0) * scale;
}

Bytes Input::take(std::size_t most) {
  const Bytes taken = rest_.first(std::min(most, rest_.size()));
  rest_ = rest_.subspan(taken.size());
  return taken;
}

std::string_view as_text(Bytes bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

bool is_printable(std::string_view text) {
  std::size_t expected = 0;  // bytes of the character under way
  for (const char each : text) {
    const auto byte = static_cast<unsigned char>(each);
    if (expected > 0) {
      if ((byte & 0xC0U) != 0x80U) return false;
      --expected;
    } else if (byte < 0x80U) {
      if (byte < 0x20U || byte == 0x7FU) return false;
    } else {
      expected = static_cast<std::size_t>(std::countl_one(byte)) - 1U;
      if (expected < 1 || expected > 3) return false;
    }
  }
  return expected == 0;
}

const std::filesystem::path& scratch_folder() {
  struct Folder {
    Folder() {
      std::string name = (std::filesystem::temp_directory_path() / "fuzz-XXXXXX").string();
      if (::mkdtemp(name.data()) == nullptr)
        throw std::system_error(errno, std::generic_category(), name);
      path = name;
    }
    ~Folder() {
      std::error_code ignored;
      std::filesystem::remove_all(path, ignored);
    }
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;
    std::filesystem::path path;
  };
  static const Folder folder;
  return folder.path;
}

std::filesystem::path write_scratch(std::string_view name, std::string_view text) {
  std::filesystem::path path = scratch_folder() / name;
  std::ofstream(path, std::ios::binary) << text;
  return path;
}

std::string source_text(std::string_view path) {
  const std::filesystem::path file = std::filesystem::path(GEODESIC_SOURCE_DIR) / path;
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw std::runtime_error("cannot read " + file.string());
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

}  // namespace geodesic::fuzz
