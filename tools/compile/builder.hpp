// Runs the system's C++ compiler on an emitted file. Knows neither mechanisms nor what is in it.
#pragma once

#include <stdexcept>
#include <string>
#include <vector>

namespace geodesic::tools::compile {

/// Why there is no shared object, in words for people.
class BuildError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The compiler asked for, or the first in PATH of g++, c++, clang++. @throws BuildError that names
/// the package to install.
std::string find_compiler(const std::string& wanted);

/// What the compiler is given besides the files: this processor's instructions, fused
/// multiply-add, and nothing that changes what becomes of NaN.
std::vector<std::string> compiler_flags();

/// @return the shared object's bytes. Works in a temporary folder, which is gone afterwards.
/// @throws BuildError with what the compiler said.
std::string build(const std::string& compiler, const std::string& source);

}  // namespace geodesic::tools::compile
