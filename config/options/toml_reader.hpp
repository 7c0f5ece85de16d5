// Reads a TOML text into what a describe() function declares; toml++ stays behind this line.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "config/findings.hpp"
#include "config/options/options.hpp"

namespace geodesic::config {

/// A value that counts in place of what a text says, or though it says nothing.
struct TomlOverride {
  std::vector<std::string> steps;  ///< keys; into an array of tables by "name"
  std::string value;               ///< as TOML
  std::string label;               ///< what messages name in place of a file
};

/// What people type for a value, as TOML: `30`, `[0, 0, -9.81]`, `true`; a bare word becomes a
/// string. @return nothing if it is none of these.
std::optional<std::string> as_toml_value(std::string_view typed);
/// A text as a TOML string.
std::string toml_string(std::string_view text);

/// Reads `text` (of `file`, for messages). Everything that is wrong with it is found in one go:
/// unknown keys, wrong types, numbers out of range, missing ones. Never throws for what the text
/// says. @return whether the text was TOML at all.
bool read_toml(const std::filesystem::path& file, std::string_view text,
               const OptionVisitor::Describe& describe, Findings& findings,
               std::span<const TomlOverride> overrides = {});

}  // namespace geodesic::config
