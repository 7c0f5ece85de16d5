// Changes values in a TOML text where they stand: comments, order and layout stay, byte for byte.
// Writes no file (write_back.hpp).
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace geodesic::config {

struct EditResult {
  std::optional<std::string> text;  ///< nothing if it could not be done
  std::string problem;              ///< why not
};

/// Puts `value` (TOML) where `steps` lead to, by "name" into arrays of tables: over the value that
/// stands there, else as a new line behind the last one of its table (inline tables: as a new
/// entry), else under a new heading at the end of the text. Not real-time.
EditResult edit_toml(const std::string& text, const std::vector<std::string>& steps,
                     const std::string& value);

}  // namespace geodesic::config
