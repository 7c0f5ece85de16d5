// A compiled model's file on disk: what makes it trustworthy enough to be loaded, and loading it.
// Whether it computes the right thing is agreement.hpp's.
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>

#include "tools/compile/abi.hpp"

namespace geodesic::tools::compile {

/// Why a file is not taken, in words for people: file, what was found, the fix.
class CompiledModelError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A shared object's bytes with the seal at their end that tells a damaged file.
std::string sealed(std::string shared_object);

/// x86-64-vN that this processor has; 0: not that architecture.
unsigned processor_level() noexcept;

class Library {
 public:
  /// The file must belong to this process's user or to root, must not be writable for others,
  /// whole, and built for a processor like this. @throws CompiledModelError.
  /// @param rebuild  the command that makes it anew, for the messages
  Library(const std::filesystem::path& file, const std::string& rebuild);
  ~Library();
  Library(const Library&) = delete;
  Library& operator=(const Library&) = delete;

  const geodesic_compiled& model() const noexcept { return *model_; }

 private:
  int file_ = -1;  ///< stays open: the loader knows the object by this number
  void* handle_ = nullptr;
  const geodesic_compiled* model_ = nullptr;
};

}  // namespace geodesic::tools::compile
