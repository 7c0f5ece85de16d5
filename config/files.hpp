// Reads whole text files for the readers of this room.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "config/findings.hpp"

namespace geodesic::config {

/// The file's text; nothing, and a finding at `asked_at` (default: the file itself), if it cannot
/// be read or is larger than 16 MiB.
std::optional<std::string> read_file(const std::filesystem::path& file, Findings& findings,
                                     const Place& asked_at = {});

}  // namespace geodesic::config
