// The kernel's files (/proc, /sys, /dev) under a root that tests choose. Reads; changes nothing.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace geodesic::tools {

class SystemTree {
 public:
  explicit SystemTree(std::filesystem::path root = "/") : root_(std::move(root)) {}

  /// `path` is absolute, as on a running system.
  std::filesystem::path place(std::string_view path) const;
  bool exists(std::string_view path) const;
  bool writable(std::string_view path) const;
  /// All of it without the line end; nothing if it cannot be read.
  std::optional<std::string> read(std::string_view path) const;
  std::optional<long> read_number(std::string_view path) const;
  /// Names in a folder, sorted; none if there is no such folder.
  std::vector<std::string> list(std::string_view path) const;

  const std::filesystem::path& root() const { return root_; }

 private:
  std::filesystem::path root_;
};

/// "0-3,6" as the kernel writes sets of processors.
std::vector<int> parse_cpu_list(std::string_view text);
std::string to_cpu_list(const std::vector<int>& cpus);

}  // namespace geodesic::tools
