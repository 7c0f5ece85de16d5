// Puts tuned values into a robot's file: edited in place, read again and compared before anything
// is replaced. Talks to no daemon.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "config/difference.hpp"
#include "config/robot.hpp"

namespace geodesic::config {

struct WriteResult {
  bool ok = false;
  std::vector<Change> changes;        ///< what the file says now that it did not say before
  std::vector<std::string> problems;  ///< why nothing was written
};

/// Writes `values` into `file`. The new text must be a whole robot that differs from the old one in
/// nothing else; the file must not have changed meanwhile; it is replaced in one step, with its
/// mode and, where this user may, its owner. A symbolic link stays one. Nothing is ever half
/// written.
WriteResult write_back(const std::filesystem::path& file, std::span<const Override> values);

}  // namespace geodesic::config
