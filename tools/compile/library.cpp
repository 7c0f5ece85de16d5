// Distrust, then dlopen; see library.hpp.
#include "tools/compile/library.hpp"

#include <dlfcn.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "tools/compile/fingerprint.hpp"

namespace geodesic::tools::compile {
namespace {

constexpr std::string_view kSealMark = "\ngeodesic compiled model ";
constexpr std::size_t kDigits = 32;
constexpr std::size_t kSealSize = kSealMark.size() + kDigits + 1;
constexpr off_t kLargest = 256 << 20;

/// What opened the file, and the words about it.
class Inspection {
 public:
  Inspection(const std::filesystem::path& file, const std::string& rebuild)
      : file_(file), rebuild_(rebuild) {}

  [[noreturn]] void refuse(const std::string& what) const {
    throw CompiledModelError(
        fmt::format("compiled model {}: {}; {}", file_.string(), what, rebuild_));
  }

  void check_owner(int descriptor) const {
    struct stat about {};
    if (::fstat(descriptor, &about) != 0) refuse(std::strerror(errno));
    if (!S_ISREG(about.st_mode)) refuse("is no file");
    if (about.st_uid != ::geteuid() && about.st_uid != 0) {
      refuse(
          fmt::format("belongs to user {}; code is only run that belongs to root or to user {}, "
                      "who starts it",
                      about.st_uid, ::geteuid()));
    }
    if ((about.st_mode & (S_IWGRP | S_IWOTH)) != 0) {
      refuse(
          fmt::format("others may write it (mode {:o}); chmod go-w it once you know what is in "
                      "it, or",
                      about.st_mode & 07777U));
    }
    if (about.st_size > kLargest) refuse("is too large to be one");
  }

  /// A file that was cut off would not fail when it is loaded, but crash when it runs.
  void check_seal(int descriptor) const {
    std::string bytes;
    char buffer[1 << 16];
    ssize_t got = 0;
    while ((got = ::read(descriptor, buffer, sizeof buffer)) > 0) {
      bytes.append(buffer, static_cast<std::size_t>(got));
    }
    if (got < 0) refuse(std::strerror(errno));
    const bool marked =
        bytes.size() > kSealSize &&
        std::string_view(bytes).substr(bytes.size() - kSealSize, kSealMark.size()) == kSealMark;
    if (!marked) refuse("is not one, or its end is missing");
    const std::size_t size = bytes.size() - kSealSize;
    if (bytes.compare(size + kSealMark.size(), kDigits, digest(bytes.data(), size)) != 0) {
      refuse("has been changed or damaged since it was built");
    }
  }

 private:
  const std::filesystem::path& file_;
  const std::string& rebuild_;
};

}  // namespace

std::string sealed(std::string bytes) {
  const std::string digits = digest(bytes.data(), bytes.size());
  bytes.append(kSealMark).append(digits).push_back('\n');
  return bytes;
}

unsigned processor_level() noexcept {
#if defined(__x86_64__)
  __builtin_cpu_init();
  unsigned level = 1;
  const bool two = __builtin_cpu_supports("sse4.2") && __builtin_cpu_supports("popcnt");
  const bool three = two && __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
                     __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2");
  const bool four = three && __builtin_cpu_supports("avx512f") &&
                    __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512cd") &&
                    __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl");
  level += static_cast<unsigned>(two) + static_cast<unsigned>(three) + static_cast<unsigned>(four);
  return level;
#else
  return 0;
#endif
}

Library::Library(const std::filesystem::path& file, const std::string& rebuild) {
  const Inspection inspection(file, rebuild);
  file_ = ::open(file.c_str(), O_RDONLY | O_CLOEXEC);
  if (file_ < 0) inspection.refuse(std::strerror(errno));
  try {
    inspection.check_owner(file_);
    inspection.check_seal(file_);
    // By descriptor: the file that was looked at is the one that is loaded.
    handle_ = ::dlopen(fmt::format("/proc/self/fd/{}", file_).c_str(), RTLD_NOW | RTLD_LOCAL);
    if (handle_ == nullptr) inspection.refuse(fmt::format("cannot be loaded ({})", ::dlerror()));
    using Describe = const geodesic_compiled* (*)();
    const auto describe = reinterpret_cast<Describe>(::dlsym(handle_, kCompiledSymbol));
    if (describe == nullptr) inspection.refuse("holds no compiled model");
    model_ = describe();
    if (model_ == nullptr || model_->abi != kCompiledAbi) {
      inspection.refuse("was written by another version of geodesic");
    }
    if (model_->isa_level > processor_level()) {
      inspection.refuse(fmt::format("was built for x86-64-v{}, this processor is x86-64-v{}",
                                    model_->isa_level, processor_level()));
    }
    if (model_->bias == nullptr || model_->gravity == nullptr || model_->metric == nullptr ||
        model_->inverse_dynamics == nullptr || model_->robot == nullptr ||
        model_->fingerprint == nullptr) {
      inspection.refuse("lacks a function");
    }
  } catch (const CompiledModelError&) {
    if (handle_ != nullptr) ::dlclose(handle_);
    ::close(file_);
    throw;
  }
}

Library::~Library() {
  ::dlclose(handle_);
  ::close(file_);
}

}  // namespace geodesic::tools::compile
