// Edit, read again, compare, replace; see write_back.hpp.
#include "config/write_back.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <map>
#include <utility>

#include "config/edit.hpp"
#include "config/files.hpp"
#include "config/settings.hpp"

namespace geodesic::config {
namespace {

/// An open file that closes itself.
class OpenFile {
 public:
  explicit OpenFile(int descriptor) : descriptor_(descriptor) {}
  ~OpenFile() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;
  int get() const { return descriptor_; }

 private:
  int descriptor_;
};

std::string failed(const char* attempted, const std::filesystem::path& file) {
  return fmt::format("cannot {} {}: {}", attempted, quote_path(file), std::strerror(errno));
}

bool write_all(int descriptor, std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = ::write(descriptor, text.data(), text.size());
    if (written < 0 && errno != EINTR) return false;
    text.remove_prefix(static_cast<std::size_t>(written < 0 ? 0 : written));
  }
  return true;
}

/// Replaces `file`, which must still hold `before`. @return why not, or nothing.
std::string replace_file(const std::filesystem::path& file, const std::string& before,
                         const std::string& after) {
  struct stat status {};
  if (::stat(file.c_str(), &status) != 0) return failed("read", file);
  if (::access(file.c_str(), W_OK) != 0) return failed("write", file);
  std::string beside = file.string() + ".XXXXXX";
  const OpenFile copy(::mkostemp(beside.data(), O_CLOEXEC));
  if (copy.get() < 0) return failed("write beside", file);
  std::string problem;
  // Without the right to give the file to its owner, one's own will have to do; group and mode
  // stay.
  if (::fchown(copy.get(), status.st_uid, status.st_gid) != 0 &&
      ::fchown(copy.get(), static_cast<uid_t>(-1), status.st_gid) != 0 &&
      (status.st_mode & S_IRWXG) != (status.st_mode & S_IRWXO) << 3U) {
    problem = fmt::format("cannot keep the group of {}; write it as its owner", quote_path(file));
  } else if (::fchmod(copy.get(), status.st_mode & 07777U) != 0 || !write_all(copy.get(), after) ||
             ::fsync(copy.get()) != 0) {
    problem = failed("write", beside);
  }
  Findings findings;
  if (problem.empty() && read_file(file, findings) != before) {
    problem =
        fmt::format("{} has changed meanwhile; nothing was written, try again", quote_path(file));
  }
  if (problem.empty() && ::rename(beside.c_str(), file.c_str()) != 0) {
    problem = failed("replace", file);
  }
  if (!problem.empty()) {
    ::unlink(beside.c_str());
    return problem;
  }
  // The new name is on the disk too; if this fails, one of the two files is there all the same.
  const OpenFile folder(::open(file.parent_path().c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (folder.get() >= 0) ::fsync(folder.get());
  return {};
}

void add_errors(const LoadResult& loaded, std::vector<std::string>& problems) {
  for (const Message& message : loaded.messages) {
    if (message.severity == Message::Severity::kError) problems.push_back(to_string(message));
  }
}

/// What changed must be what was asked for, to the bit, and nothing else.
std::string compare(const LoadResult& asked, const LoadResult& written) {
  const std::vector<Change> wrong = difference(asked.robot, written.robot);
  if (wrong.empty()) return {};
  return fmt::format("the edited text would not say what was asked ({}); write it by hand",
                     to_string(wrong.front()));
}

}  // namespace

WriteResult write_back(const std::filesystem::path& file, std::span<const Override> values) {
  WriteResult result;
  std::error_code ignored;
  const std::filesystem::path target = std::filesystem::canonical(file, ignored);
  const LoadResult before = load_robot(file);
  LoadOptions with_values;
  with_values.text = before.text;
  with_values.overrides.assign(values.begin(), values.end());
  const LoadResult asked = before.ok ? load_robot(file, with_values) : LoadResult{};
  if (!before.ok || !asked.ok) {
    add_errors(before.ok ? asked : before, result.problems);
    return result;
  }
  std::string text = before.text.robot;
  for (const Override& value : values) {
    const Setting* setting = find_setting(before.robot.settings, value.path);
    EditResult edited = setting != nullptr ? edit_toml(text, setting->steps, value.value)
                                           : EditResult{std::nullopt, "there is no such option"};
    if (!edited.text) {
      result.problems.push_back(fmt::format("{}: {}", value.path, edited.problem));
      return result;
    }
    text = std::move(*edited.text);
  }
  with_values.overrides.clear();
  with_values.text->robot = text;
  const LoadResult after = load_robot(file, with_values);
  add_errors(after, result.problems);
  if (result.problems.empty()) {
    if (std::string wrong = compare(asked, after); !wrong.empty()) {
      result.problems.push_back(std::move(wrong));
    }
  }
  if (!result.problems.empty()) return result;
  result.changes = difference(before.robot, after.robot);
  if (text != before.text.robot) {
    if (std::string problem = replace_file(target, before.text.robot, text); !problem.empty()) {
      result.problems.push_back(std::move(problem));
      return result;
    }
  }
  result.ok = true;
  return result;
}

}  // namespace geodesic::config
