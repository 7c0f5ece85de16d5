// Reads a TOML text into what a describe() function declares; toml++ stays behind this line.
#pragma once

#include <filesystem>
#include <string_view>

#include "config/findings.hpp"
#include "config/options/options.hpp"

namespace geodesic::config {

/// Reads `text` (of `file`, for messages). Everything that is wrong with it is found in one go:
/// unknown keys, wrong types, numbers out of range, missing ones. Never throws for what the text
/// says. @return whether the text was TOML at all.
bool read_toml(const std::filesystem::path& file, std::string_view text,
               const OptionVisitor::Describe& describe, Findings& findings);

}  // namespace geodesic::config
