// Pictures by matplotlib; see the header.
#include "tools/geodesic/picture.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "tools/geodesic/command.hpp"

extern char** environ;  // NOLINT(readability-redundant-declaration): POSIX wants it declared

namespace geodesic::tools {
namespace {

/// The distribution's own: the one that its matplotlib belongs to.
constexpr const char* kPython = "/usr/bin/python3";

/// A file in the temporary folder that is gone with its owner.
class TemporaryFile {
 public:
  explicit TemporaryFile(const std::string& text)
      : path_((std::filesystem::temp_directory_path() / "geodesic-figures-XXXXXX").string()) {
    const int file = mkstemp(path_.data());
    if (file < 0) {
      throw BadInput(fmt::format("{}: cannot be made: {}", path_, std::strerror(errno)));
    }
    ::close(file);
    write_file(path_, text);
  }
  ~TemporaryFile() {
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  const std::string& path() const noexcept { return path_; }

 private:
  std::string path_;
};

/// Runs it and waits. @return exit status; 127 if it cannot be started
int run(std::array<std::string, 5> words) {
  std::array<char*, 6> argv{};
  for (std::size_t i = 0; i < words.size(); ++i) argv[i] = words[i].data();
  pid_t child = 0;
  if (posix_spawn(&child, argv[0], nullptr, nullptr, argv.data(), environ) != 0) return 127;
  int status = 0;
  while (waitpid(child, &status, 0) < 0) {
    if (errno != EINTR) return 127;
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 126;
}

}  // namespace

void draw_picture(const char* script, const nlohmann::ordered_json& figures,
                  const std::string& file, const std::string& otherwise) {
  const TemporaryFile data(figures.dump());
  const int status = run({kPython, "-c", script, data.path(), file});
  if (status == 0) return;
  if (status == 127 || status == 3) {
    throw BadInput(fmt::format(
        "--plot {}: it needs {} with matplotlib; on Debian and Ubuntu: sudo apt install "
        "python3-matplotlib. {}",
        file, kPython, otherwise));
  }
  throw BadInput(fmt::format("--plot {}: the picture could not be drawn (see above)", file));
}

}  // namespace geodesic::tools
