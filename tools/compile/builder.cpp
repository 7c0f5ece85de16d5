// Source in, shared object out; see builder.hpp.
#include "tools/compile/builder.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>

#include "tools/compile/library.hpp"

extern char** environ;

namespace geodesic::tools::compile {
namespace {

namespace fs = std::filesystem;

class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = (fs::temp_directory_path() / "geodesic-compile-XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) {
      throw BuildError(
          fmt::format("no temporary folder {}: {}; set TMPDIR to one that can be "
                      "written",
                      name, std::strerror(errno)));
    }
    path_ = name;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

bool can_run(const fs::path& file) {
  std::error_code ignored;
  return fs::is_regular_file(file, ignored) && ::access(file.c_str(), X_OK) == 0;
}

/// Full path of a program, empty if it is not in PATH.
std::string which(const std::string& program) {
  if (program.find('/') != std::string::npos) return can_run(program) ? program : std::string();
  const char* path = std::getenv("PATH");
  std::istringstream folders(path != nullptr ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');) {
    const fs::path file = fs::path(folder.empty() ? "." : folder) / program;
    if (can_run(file)) return file.string();
  }
  return {};
}

std::string contents(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// @return the program's exit status; its words go to `words`.
int run(const std::vector<std::string>& command, const fs::path& words) {
  std::vector<char*> arguments;
  arguments.reserve(command.size() + 1);
  for (const std::string& one : command) arguments.push_back(const_cast<char*>(one.c_str()));
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, words.c_str(),
                                   O_WRONLY | O_CREAT | O_TRUNC, 0600);
  pid_t child = 0;
  const int error =
      ::posix_spawn(&child, command.front().c_str(), &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) {
    throw BuildError(fmt::format("{} does not start: {}", command.front(), std::strerror(error)));
  }
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128;
}

}  // namespace

std::string find_compiler(const std::string& wanted) {
  if (!wanted.empty()) {
    if (std::string found = which(wanted); !found.empty()) return found;
    throw BuildError(
        fmt::format("there is no compiler {}; leave --compiler out to use g++, c++ or "
                    "clang++, whichever is in PATH",
                    wanted));
  }
  for (const char* name : {"g++", "c++", "clang++"}) {
    if (std::string found = which(name); !found.empty()) return found;
  }
  throw BuildError(
      "there is no C++ compiler (g++, c++ or clang++ in PATH); install one: sudo apt install g++. "
      "Without one, leave `compiled` out of the robot's file: the model read from it needs none; "
      "or "
      "take --source and build elsewhere");
}

std::vector<std::string> compiler_flags() {
  std::vector<std::string> flags{"-std=c++20",
                                 "-O2",
                                 "-fPIC",
                                 "-shared",
                                 "-fno-rtti",
                                 "-fno-exceptions",
                                 "-ffp-contract=fast",
                                 "-fno-math-errno",
                                 "-fno-trapping-math",
                                 "-fno-tree-slp-vectorize",
                                 "-fvisibility=hidden",
                                 "-Wl,-z,now"};
  if (const unsigned level = processor_level(); level > 1) {
    flags.push_back(fmt::format("-march=x86-64-v{}", level));
    flags.emplace_back("-mtune=native");
    flags.push_back(fmt::format("-DGEODESIC_ISA_LEVEL={}", level));
  }
  return flags;
}

std::string build(const std::string& compiler, const std::string& source) {
  const TemporaryFolder folder;
  const fs::path input = folder.path() / "model.cpp";
  const fs::path output = folder.path() / "model.so";
  const fs::path words = folder.path() / "words";
  std::ofstream(input, std::ios::binary) << source;
  std::vector<std::string> command{compiler};
  for (std::string& flag : compiler_flags()) command.push_back(std::move(flag));
  command.insert(command.end(), {"-o", output.string(), input.string()});
  const int status = run(command, words);
  std::string bytes = contents(output);
  if (status != 0 || bytes.empty()) {
    throw BuildError(fmt::format("{} ended with status {}:\n{}", compiler, status,
                                 contents(words).substr(0, 4000)));
  }
  return bytes;
}

}  // namespace geodesic::tools::compile
