// Atomic writing of result files.
#include "tools/geodesicd/output_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "drivers/bus/descriptor.hpp"

namespace geodesic::tools {
namespace {

std::string problem(const char* attempted, const std::filesystem::path& file) {
  const int number = errno;
  std::string text = std::string(attempted) + " " + file.string() + ": " + std::strerror(number);
  if (number == ENOSPC || number == EDQUOT) {
    text += "; free some space, or write elsewhere";
  } else if (number == ENOENT) {
    text += "; make its folder first";
  } else if (number == EACCES || number == EROFS) {
    text += "; choose a place that this user may write";
  }
  return text;
}

bool is_special(const std::filesystem::path& file) {
  struct stat status {};
  return ::stat(file.c_str(), &status) == 0 && !S_ISREG(status.st_mode);
}

bool write_all(int descriptor, std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = ::write(descriptor, text.data(), text.size());
    if (written < 0 && errno != EINTR) {
      return false;
    }
    text.remove_prefix(static_cast<std::size_t>(written < 0 ? 0 : written));
  }
  return true;
}

/// A new file beside `file` with `text` in it, safe on the disk; empty path and errno on failure.
std::filesystem::path write_beside(const std::filesystem::path& file, std::string_view text) {
  std::string name = file.string() + ".XXXXXX";
  const drivers::Descriptor descriptor(::mkostemp(name.data(), O_CLOEXEC));
  if (!descriptor.valid()) {
    return {};
  }
  if (::fchmod(descriptor.get(), 0644) == 0 && write_all(descriptor.get(), text) &&
      ::fsync(descriptor.get()) == 0) {
    return name;
  }
  const int number = errno;
  ::unlink(name.c_str());
  errno = number;
  return {};
}

}  // namespace

std::optional<std::string> prepare_output(const std::filesystem::path& file, std::size_t bytes) {
  std::error_code ignored;
  if (std::filesystem::is_directory(file, ignored)) {
    errno = EISDIR;
    return problem("cannot write", file);
  }
  if (is_special(file)) {
    if (::access(file.c_str(), W_OK) != 0) {
      return problem("cannot write", file);
    }
    return std::nullopt;
  }
  const std::filesystem::path probe = write_beside(file, std::string(bytes, ' '));
  if (probe.empty()) {
    return problem("cannot write", file);
  }
  ::unlink(probe.c_str());
  if (::unlink(file.c_str()) != 0 && errno != ENOENT) {
    return problem("cannot replace", file);
  }
  return std::nullopt;
}

std::optional<std::string> write_output(const std::filesystem::path& file, std::string_view text) {
  if (is_special(file)) {
    const drivers::Descriptor descriptor(::open(file.c_str(), O_WRONLY | O_CLOEXEC));
    if (!descriptor.valid() || !write_all(descriptor.get(), text)) {
      return problem("cannot write", file);
    }
    return std::nullopt;
  }
  const std::filesystem::path written = write_beside(file, text);
  if (written.empty()) {
    return problem("cannot write", file);
  }
  if (::rename(written.c_str(), file.c_str()) != 0) {
    const std::string text_of_problem = problem("cannot replace", file);
    ::unlink(written.c_str());
    return text_of_problem;
  }
  return std::nullopt;
}

}  // namespace geodesic::tools
