// Notices that files were saved, replaced, removed or came back, whatever way an editor does it.
// Reads none of them. Not for the real-time thread.
#pragma once

#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

#include "drivers/bus/descriptor.hpp"

namespace geodesic::tools {

/// Watches the folders that hold the files (inotify), since editors write beside and rename; where
/// a file is a symbolic link, its target's folder too. It also looks at the files once a second:
/// not every file system tells of every change (those of a network, of a container's host), and
/// nobody tells where there is no inotify or a folder is gone.
class FileWatch {
 public:
  using Clock = std::chrono::steady_clock;
  /// Quiet for so long, a burst of writes counts as one save.
  static constexpr std::chrono::milliseconds kSettle{100};
  static constexpr std::chrono::milliseconds kLook{1000};

  explicit FileWatch(std::vector<std::filesystem::path> files);

  /// To be called often. Never waits. @return true once for every settled change of any of them.
  bool changed(Clock::time_point now);

  /// Why it has to look instead of being told; empty: it is told.
  const std::string& problem() const noexcept { return problem_; }

 private:
  struct Folder {
    std::filesystem::path path;
    int watch = -1;
  };
  /// What is known of a file without reading it.
  struct Stamp {
    bool there = false;
    std::int64_t changed_ns = 0;
    std::int64_t size = 0;
    std::uint64_t node = 0;
    bool operator==(const Stamp&) const = default;
  };
  static Stamp stamp_of(const std::filesystem::path& file);
  void watch_folders();
  bool drain();
  bool look();

  std::vector<std::filesystem::path> files_;
  std::vector<Stamp> stamps_;
  std::vector<Folder> folders_;
  drivers::Descriptor inotify_;
  std::string problem_;
  bool pending_ = false;
  Clock::time_point last_event_{};
  Clock::time_point last_look_{};
};

}  // namespace geodesic::tools
