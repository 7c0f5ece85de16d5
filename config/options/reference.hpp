// Writes the reference of all options from their declarations; see options.hpp.
#pragma once

#include <string>

namespace geodesic::config {

/// Every option of a robot file: type, unit, range, default and meaning, as Markdown.
/// config/OPTIONS.md is exactly this text.
std::string option_reference_markdown();

}  // namespace geodesic::config
