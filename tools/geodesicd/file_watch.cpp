// Watching by inotify, or by looking; see file_watch.hpp.
#include "tools/geodesicd/file_watch.hpp"

#include <sys/inotify.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

namespace geodesic::tools {
namespace {

constexpr std::uint32_t kEvents = IN_CLOSE_WRITE | IN_MOVED_TO | IN_MOVED_FROM | IN_CREATE |
                                  IN_DELETE | IN_DELETE_SELF | IN_MOVE_SELF | IN_ONLYDIR;

std::filesystem::path folder_of(const std::filesystem::path& file) {
  return file.has_parent_path() ? file.parent_path() : std::filesystem::path(".");
}

}  // namespace

FileWatch::FileWatch(std::vector<std::filesystem::path> files)
    : files_(std::move(files)), inotify_(::inotify_init1(IN_NONBLOCK | IN_CLOEXEC)) {
  const auto add = [this](const std::filesystem::path& folder) {
    const bool known = std::any_of(folders_.begin(), folders_.end(),
                                   [&](const Folder& f) { return f.path == folder; });
    if (!known) folders_.push_back({folder, -1});
  };
  for (const std::filesystem::path& file : files_) {
    add(folder_of(file));
    std::error_code problem;
    const std::filesystem::path target = std::filesystem::canonical(file, problem);
    if (!problem && std::filesystem::is_symlink(file, problem)) add(folder_of(target));
    stamps_.push_back(stamp_of(file));
  }
  if (!inotify_.valid()) {
    problem_ = std::string("inotify: ") + std::strerror(errno);
  }
  watch_folders();
}

FileWatch::Stamp FileWatch::stamp_of(const std::filesystem::path& file) {
  struct stat status {};
  if (::stat(file.c_str(), &status) != 0) return {};
  return {true, status.st_mtim.tv_sec * 1'000'000'000LL + status.st_mtim.tv_nsec, status.st_size,
          status.st_ino};
}

void FileWatch::watch_folders() {
  if (!inotify_.valid()) return;
  problem_.clear();
  for (Folder& folder : folders_) {
    if (folder.watch >= 0) continue;
    folder.watch = ::inotify_add_watch(inotify_.get(), folder.path.c_str(), kEvents);
    if (folder.watch < 0) problem_ = folder.path.string() + ": " + std::strerror(errno);
  }
}

/// Takes all events there are. @return whether one may concern a file.
bool FileWatch::drain() {
  bool any = false;
  alignas(inotify_event) std::array<char, 4096> bytes{};
  for (int round = 0; round < 64 && inotify_.valid(); ++round) {
    const ssize_t got = ::read(inotify_.get(), bytes.data(), bytes.size());
    if (got <= 0) break;
    any = true;  // which file it was shows when they are looked at
    for (std::size_t at = 0; at + sizeof(inotify_event) <= static_cast<std::size_t>(got);) {
      inotify_event event{};
      std::memcpy(&event, bytes.data() + at, sizeof(event));
      at += sizeof(event) + event.len;
      if ((event.mask & (IN_IGNORED | IN_MOVE_SELF | IN_DELETE_SELF | IN_UNMOUNT)) == 0) continue;
      for (Folder& folder : folders_) {
        if (folder.watch != event.wd) continue;
        if ((event.mask & IN_MOVE_SELF) != 0) ::inotify_rm_watch(inotify_.get(), folder.watch);
        folder.watch = -1;  // the path leads elsewhere now, or nowhere
      }
    }
  }
  return any;
}

/// @return whether a file is another than it was at the last look.
bool FileWatch::look() {
  bool differs = false;
  for (std::size_t i = 0; i < files_.size(); ++i) {
    const Stamp stamp = stamp_of(files_[i]);
    differs = differs || !(stamp == stamps_[i]);
    stamps_[i] = stamp;
  }
  return differs;
}

bool FileWatch::changed(Clock::time_point now) {
  bool event = drain();
  if (now - last_look_ >= kLook) {
    last_look_ = now;
    watch_folders();
    event = true;
  }
  if (event && look()) {
    pending_ = true;
    last_event_ = now;
  }
  if (!pending_ || now - last_event_ < kSettle) return false;
  if (look()) {  // still being written
    last_event_ = now;
    return false;
  }
  pending_ = false;
  return true;
}

}  // namespace geodesic::tools
