// Every option of a robot as one flat list with paths, made from the declarations (robot_file.cpp);
// and the way from a path to a place in the file. What a change of one means is in difference.hpp.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "config/findings.hpp"
#include "config/options/toml_reader.hpp"
#include "config/robot_file.hpp"
#include "control/mechanism/tree.hpp"

namespace geodesic::config {

/// Every option of `file`, whether it is written there or not; `tree` tells which joints count in
/// metres. Not real-time.
std::vector<Setting> settings_of(const RobotFile& file, const control::TreeDescription& tree);

/// The setting of that path; null if there is none.
const Setting* find_setting(std::span<const Setting> settings, std::string_view path);

/// What `key` means: a path, or an option of [robot] without its table ("payload").
/// @return nothing, and in `problem` why, with the nearest name, if there is none.
const Setting* find_by_key(std::span<const Setting> settings, std::string_view key,
                           std::string& problem);

/// Where in `text` each override belongs; paths that do not exist are findings.
std::vector<TomlOverride> resolve(std::span<const Override> overrides,
                                  const std::filesystem::path& file, std::string_view text,
                                  Findings& findings);

}  // namespace geodesic::config
