// Files the daemon leaves behind: is there room and permission at the start, and whole or not at
// all at the end.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace geodesic::tools {

/// Whether `file` can be written when the run ends: tries with `bytes` bytes beside it, and removes
/// an older file of that name, so that a file that is there is this run's.
/// @return what is wrong and what helps; nothing if all is well.
std::optional<std::string> prepare_output(const std::filesystem::path& file,
                                          std::size_t bytes = 65536);

/// Writes `text` to a temporary file beside `file`, to the disk, and renames it. What is no regular
/// file (/dev/stdout, a pipe) is written as it is.
/// @return what is wrong; nothing if all is well.
std::optional<std::string> write_output(const std::filesystem::path& file, std::string_view text);

}  // namespace geodesic::tools
